"""Scenarios and scripts that come with drake_ltl: `drake_ltl.examples`, installed with the library."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from drake_ltl.errors import InvalidInputError, Mistake


def names() -> tuple[str, ...]:
    """All scenarios, by name."""
    return tuple(sorted(path.stem for path in _folder().glob("*.yaml")))


def path(name: str) -> Path:
    """The file of one of them.

    Raises:
        InvalidInputError: there is none of this name.
    """
    if name not in names():
        raise InvalidInputError([Mistake(name, "is not an example", f"write one of {', '.join(names())}")])
    return _folder() / f"{name}.yaml"


def find(file: Path | str) -> Path:
    """The file, or if there is none of this name the example that is called so.

    Raises:
        InvalidInputError: neither is there. (A name with a suffix, such as `errand.yaml`, is none of an example: it is
            returned as it is.)
    """
    file = Path(file)
    if file.suffix or file.exists():
        return file
    if str(file) not in names():
        what = "is neither a file nor the name of an example"
        raise InvalidInputError([Mistake(str(file), what, f"examples are {', '.join(names())}")])
    return path(str(file))


def _folder() -> Path:
    return Path(str(files(__name__)))
