"""How a command speaks: results to stdout, complaints to stderr, data to files."""

from __future__ import annotations

import errno
import json
import logging
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TextIO

from rich.console import Console

from drake_ltl.errors import InvalidInputError, Mistake, naming_file
from drake_ltl.whole_files import write_text_whole

PIPE_WIDTH = 120
"""Columns of a table that is not shown on a terminal."""


def console() -> Console:
    """Where results go."""
    plain = {"color_system": None} if os.environ.get("NO_COLOR") else {}
    return _Console(**plain) if sys.stdout.isatty() else _Console(width=PIPE_WIDTH, **plain)


@contextmanager
def colours(wanted: bool) -> Iterator[None]:
    """Without colours in the body unless they are wanted; the environment may forbid them anyhow."""
    before = os.environ.get("NO_COLOR")
    if not wanted:
        os.environ["NO_COLOR"] = "1"
    try:
        yield
    finally:
        if before is None:
            os.environ.pop("NO_COLOR", None)
        else:
            os.environ["NO_COLOR"] = before


@contextmanager
def working(text: str) -> Iterator[None]:
    """Says on a terminal what takes so long; nothing in a pipe."""
    screen = Console(stderr=True)
    if not screen.is_terminal:
        yield
        return
    with screen.status(text):
        yield


class _Console(Console):
    def print(self, *objects: Any, **options: Any) -> None:
        with naming_stdout():
            super().print(*objects, **options)

    def on_broken_pipe(self) -> None:
        """The reader of a pipe went away: say nothing more to it, but finish the work (the base class would exit)."""
        self.quiet = True
        silence(sys.stdout)


@contextmanager
def naming_stdout() -> Iterator[None]:
    """Says so if it is stdout that cannot be written; what it has not taken by then is dropped."""
    try:
        with naming_file("standard output"):
            yield
    except BrokenPipeError:
        raise
    except OSError:
        silence(sys.stdout)
        raise


def silence(stream: TextIO) -> None:
    """Whatever is still to be written to stdout or stderr is dropped."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def say_written(path: Path) -> None:
    """A line of its own, however long the name."""
    console().print(f"wrote {path}", highlight=False, markup=False, soft_wrap=True)


def silence_matplotlib() -> None:
    """Where there is no home it would speak of its caches."""
    logging.getLogger("matplotlib").setLevel(logging.ERROR)


def complain(text: str) -> None:
    """One line per mistake, on stderr; dropped if nothing can be written there."""
    try:
        print(text, file=sys.stderr, flush=True)
    except OSError:
        silence(sys.stderr)


def check_writable(
    *paths: Path | None,
    source: Path | None = None,
    replaced: Path | None = None,
    folder: Path | None = None,
    inside: tuple[str, ...] = (),
) -> None:
    """Refuses outputs that could not be written, before any long work is done. Nothing is changed or left behind.

    Args:
        paths: files that will be opened for writing.
        source: the command's input, which none of them may be.
        replaced: a file that will be written beside its place first, so its folder must be writable.
        folder: a folder that will be made if it is not there, with files in it.
        inside: names of these files.

    Raises:
        InvalidInputError: with every output that cannot be written, would overwrite the input, or is named twice.
    """
    files = [path for path in (*paths, replaced) if path is not None]
    mistakes = [_mistake(path) for path in files]
    if replaced is not None and mistakes[-1] is None:
        mistakes[-1] = _irreplaceable(replaced)
    if folder is not None:
        mistakes.append(_unusable_folder(folder))
    if source is not None:
        written = [*files, *(folder / name for name in inside if folder is not None)]
        mistakes += [_overwriting(path) for path in written if _same_file(path, source)]
    places = [os.path.realpath(path) for path in files]
    twice = {path: None for path, place in zip(files, places, strict=True) if places.count(place) > 1}
    mistakes += [Mistake(str(path), "is named for several outputs", "name a file for each") for path in list(twice)[:1]]
    if any(mistakes):
        raise InvalidInputError([mistake for mistake in mistakes if mistake is not None])


def _same_file(one: Path, other: Path) -> bool:
    """Whatever they are called: links, and places like /dev/stdin, lead to one file. Devices hold nothing to lose."""
    try:
        return one.samefile(other) and one.is_file()
    except OSError:  # one of them is not there
        return False


def _overwriting(path: Path) -> Mistake:
    return Mistake(str(path), "is the input, and would be overwritten", "name another file")


def _mistake(path: Path) -> Mistake | None:
    if path.is_dir():
        return Mistake(str(path), "is a folder", "name a file")
    if not path.absolute().parent.is_dir():
        return Mistake(str(path), f"there is no folder {path.parent}", "make it first")
    return _tried(path, _open_for_writing)


def _open_for_writing(path: Path) -> None:
    """Neither truncates the file nor leaves an empty one. A pipe is not opened: that would wait for its reader."""
    place = Path(os.path.realpath(path))  # of a dangling link, what it points to
    if place.is_file() or not place.exists():
        new = not place.exists()
        os.close(os.open(place, os.O_WRONLY | os.O_CREAT))
        if new:
            place.unlink()
    elif not os.access(place, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))


def _irreplaceable(path: Path) -> Mistake | None:
    if path.exists() and not path.is_file():
        return Mistake(str(path), "is not a plain file", "name another file")
    return _tried(path, lambda file: tempfile.TemporaryFile(dir=file.absolute().parent).close())


def _unusable_folder(path: Path) -> Mistake | None:
    missing = [place for place in (path, *path.parents) if not place.exists()]

    def use(folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()

    try:
        return _tried(path, use)
    finally:
        for place in missing:
            with suppress(OSError):
                place.rmdir()


def _tried(path: Path, action: Callable[[Path], None]) -> Mistake | None:
    try:
        action(path)
    except OSError as error:
        return Mistake(str(path), f"cannot be written ({error.strerror or error})", "name another place")
    return None


def write_json(path: Path | None, data: dict[str, Any]) -> None:
    """Writes the data unless there is no path. Raises OSError, with the file's name, if it cannot."""
    if path is not None:
        with naming_file(path):
            write_text_whole(path, json_text(data))


def json_text(data: dict[str, Any]) -> str:
    """As it stands in files."""
    return json.dumps(data, indent=2, allow_nan=False) + "\n"
