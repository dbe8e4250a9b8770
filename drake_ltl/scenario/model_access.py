"""Which files a scenario may use: those of the installed package, of its own folder, and of folders that were allowed.

A scenario comes from anywhere. Its models, and what these name in turn (meshes, textures, other models), are read with
the rights of whoever runs it; so they have to be where a scenario has business to look, links and `..` followed.
"""

from __future__ import annotations

import json
import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from urllib.parse import unquote

from drake_ltl.scenario.model_files import PACKAGE, shipped_folder
from drake_ltl.scenario.table import shown

ANYWHERE = Path("/")
LARGEST_FILE = 100_000_000
"""Bytes of a model, mesh or texture; more would take minutes to read."""

_allowed: ContextVar[tuple[Path, ...]] = ContextVar("allowed folders of models", default=())


class NotAllowedError(Exception):
    """A file that a scenario may not use."""

    def __init__(self, what: str, remedy: str):
        self.what, self.remedy = what, remedy
        super().__init__(f"{what}; {remedy}")


@contextmanager
def allow_models(*folders: Path | str) -> Iterator[None]:
    """In the body scenarios may use what is in these folders as well."""
    token = _allowed.set((*_allowed.get(), *map(Path, folders)))
    try:
        yield
    finally:
        _allowed.reset(token)


def check_access(path: Path, scenario_folder: Path | None) -> None:
    """Raises NotAllowedError if a scenario in this folder may not use the file at `path`, which need not exist."""
    if _is_shipped(path):
        return
    place = path.resolve()
    folders = (scenario_folder or Path.cwd(), *_allowed.get())
    if not any(place.is_relative_to(folder.resolve()) for folder in folders):
        where = "" if place == path.absolute() else f" (it is {shown(str(place))})"
        raise NotAllowedError(
            f"{shown(str(path))} is outside the scenario's folder and the package of models{where}",
            f"move it there, or allow it with --allow-models {shown(str(place.parent))}",
        )


def _is_shipped(path: Path) -> bool:
    """Whatever the links of an installed package are: some installers make all its files links."""
    return Path(os.path.normpath(path)).is_relative_to(shipped_folder())


def check_references(model: Path, scenario_folder: Path | None) -> None:
    """Looks into a model's file, and those that it names, for names of files that a scenario may not use.

    Raises:
        NotAllowedError: there is one, or a file is too large.
        OSError: a file cannot be read.
    """
    seen, waiting = {model}, [] if _is_shipped(model) else [model]
    while waiting:
        file = waiting.pop()
        if file.stat().st_size > LARGEST_FILE:
            raise NotAllowedError(f"{file.name} is larger than {LARGEST_FILE // 10**6} MB", "name a smaller one")
        names = _names_in_xml(file) if file == model else _names_in(file)
        for named in (place for name in names if name for place in _places(name, file, scenario_folder)):
            files = [*named.glob("*.sdf"), *named.glob("*.config")] if named.is_dir() else [named]
            waiting += [path for path in files if path.is_file() and path not in seen]
            seen.update(files)


def _places(name: str, file: Path, scenario_folder: Path | None) -> set[Path]:
    """Where a file names another; %20 and the like are not understood by everybody who reads it."""
    try:
        places = {_file_of(spelling, file.parent) for spelling in (name, unquote(name))}
        for place in places:
            check_access(place, scenario_folder)
    except (NotAllowedError, ValueError) as error:  # ValueError: a null character
        what = error.what if isinstance(error, NotAllowedError) else str(error)
        remedy = error.remedy if isinstance(error, NotAllowedError) else "name a file beside the model"
        raise NotAllowedError(f"{file.name} names {shown(name)}: {what}", remedy) from error
    return places


def package_of(model: Path) -> tuple[str, Path] | None:
    """Name and folder of the ROS package that a file belongs to: that of the nearest package.xml above it."""
    for folder in model.absolute().parents:
        description = folder / "package.xml"
        if description.is_file():
            try:
                return (ET.parse(description).findtext("name") or "").strip(), folder
            except (ET.ParseError, LookupError, ValueError):
                return None
    return None


def _file_of(name: str, folder: Path) -> Path:
    """The file that a model in `folder` means by a name. Raises NotAllowedError for other schemes and packages."""
    scheme, separator, rest = name.partition("://")
    if not separator:
        return folder / name
    if scheme == "file":
        return Path(rest)
    if scheme not in ("package", "model"):
        raise NotAllowedError(f"{shown(scheme)} is not a known scheme", "name a file beside the model")
    package, _, inside = rest.partition("/")
    own = package_of(folder / "model")
    known = {PACKAGE: shipped_folder()} | ({own[0]: own[1]} if own else {})
    if package not in known:
        raise NotAllowedError(f"{shown(package)} is not a known package", f"known packages: {', '.join(known)}")
    return known[package] / inside


def _names_in(file: Path) -> Iterator[str]:
    """Names of other files in a model, or in a mesh of a format that has any."""
    kind = file.suffix.lower()
    if kind in (".sdf", ".urdf", ".xml", ".config", ".dae"):
        yield from _names_in_xml(file)
    elif kind in (".obj", ".mtl"):
        text = file.read_text(encoding="utf-8", errors="replace")
        yield from re.findall(r"^\s*(?:mtllib|map_\w+|bump|disp|decal|refl|norm)\s+(?:-.*\s)?(\S+)\s*$", text, re.M)
    elif kind in (".gltf", ".glb"):
        yield from _names_in_gltf(file.read_bytes())


def _names_in_xml(file: Path) -> Iterator[str]:
    try:
        tree = ET.parse(file)
    except (ET.ParseError, LookupError, ValueError):  # whoever reads the model says so
        return
    for element in tree.iter():
        tag = element.tag.rpartition("}")[2].rpartition(":")[2] if isinstance(element.tag, str) else ""
        if tag in ("uri", "sdf") or tag.endswith("_map"):
            yield (element.text or "").strip()
        for key, value in element.attrib.items():
            if key in ("filename", "file", "uri", "url"):
                yield value.strip()


def _names_in_gltf(data: bytes) -> Iterator[str]:
    if data[:4] == b"glTF":  # binary: a header of 12 bytes, then a chunk of JSON with its length
        data = data[20 : 20 + int.from_bytes(data[12:16], "little")]
    try:
        content = json.loads(data)
        for kind in ("buffers", "images"):
            uris = [entry["uri"] for entry in content.get(kind, ()) if "uri" in entry]
            yield from (unquote(uri) for uri in uris if not uri.startswith("data:"))
    except (ValueError, AttributeError, TypeError, RecursionError):
        return
