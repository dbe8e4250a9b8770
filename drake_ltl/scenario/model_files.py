"""Where models are, and what can be said of them without loading them."""

from __future__ import annotations

import importlib.resources
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from pathlib import Path
from urllib.parse import unquote

PACKAGE = "drake_ltl_models"
"""Name of the ROS-style package of models that is installed with the library."""
BASE_JOINTS = 2
"""The first movable joints of an agent: x and y of its holonomic base."""
FEWEST_ARM_JOINTS = 2
"""Fewer cannot set a gripper to a handle."""
WHEELS = ("left", "right")
"""The joints of a differential drive's wheels."""


def resolve(uri: str, base: Path | None = None) -> Path:
    """The file that `uri` means: `package://drake_ltl_models/...`, `file://...` or a path.

    A relative path starts at the folder `base` (default: the working folder). The file need not exist.

    Raises:
        ValueError: another package or another scheme.
    """
    if uri.startswith("package://"):
        package, _, inside = uri.removeprefix("package://").partition("/")
        if package != PACKAGE:
            raise ValueError(f"{package!r} is not a known package of models; {PACKAGE!r} is")
        return shipped_folder() / inside
    if uri.startswith("file://"):
        return Path(unquote(uri.removeprefix("file://")))
    if "://" in uri:
        raise ValueError(f"{uri.partition('://')[0]!r} is not a known scheme; `package` and `file` are")
    return (base or Path.cwd()) / Path(uri).expanduser()


def shipped(folder: str) -> tuple[str, ...]:
    """URIs of the models in `folder` (`agents`, `bases` or `objects`) that come with the library."""
    inside = shipped_folder() / folder
    files = sorted(path.name for path in inside.glob("*") if path.suffix in (".urdf", ".sdf"))
    return tuple(f"package://{PACKAGE}/{folder}/{name}" for name in files)


def shipped_folder() -> Path:
    """Where the models are that come with the library."""
    return Path(str(importlib.resources.files("drake_ltl.models")))


def movable_joints(path: Path) -> tuple[tuple[str, str], ...]:
    """Name and type of the joints of a URDF that move, in the file's order.

    Raises:
        ValueError: the file is not a URDF.
        OSError: it cannot be read.
    """
    robot = _root(path, ("robot",))
    joints = ((joint.get("name", ""), joint.get("type", "")) for joint in robot.findall("joint"))
    return tuple((name, kind) for name, kind in joints if kind != "fixed")


def is_drive(path: Path) -> bool:
    """Whether the agent stands on two driven wheels: joints `left` and `right` and no base on prismatic joints.

    Raises ValueError if the file is no URDF, OSError if it cannot be read.
    """
    joints = dict(movable_joints(path))
    return all(wheel in joints for wheel in WHEELS) and [*joints.values()][:BASE_JOINTS] != ["prismatic"] * BASE_JOINTS


def check_agent(path: Path) -> int:
    """How many arm joints the agent has: its movable joints after those of the base, none on a differential drive.

    Raises:
        ValueError: the model cannot be an agent (or is no URDF).
        OSError: it cannot be read.
    """
    joints = movable_joints(path)
    if is_drive(path):
        if others := [name for name, _ in joints if name not in WHEELS]:
            raise ValueError(
                f"{path.name} moves {', '.join(others)} besides its wheels: on a base that cannot move sideways arms "
                "cannot approach, grasp or carry"
            )
        _check_limits(path)
        return 0
    fewest = BASE_JOINTS + FEWEST_ARM_JOINTS
    if len(joints) < fewest:
        names = ", ".join(name for name, _ in joints) or "none"
        raise ValueError(f"{path.name} has {len(joints)} movable joints ({names}), not at least {fewest}")
    for name, kind in joints[:BASE_JOINTS]:
        if kind != "prismatic":
            raise ValueError(f"joint {name!r} of {path.name} is {kind or 'of no type'}, not prismatic")
    _check_limits(path)
    return len(joints) - BASE_JOINTS


def _check_limits(path: Path) -> None:
    """Drake ends the process where a lower limit is above the upper one."""
    for joint in _root(path, ("robot",)).findall("joint"):
        limit = joint.find("limit")
        lower, upper = (float(limit.get(key, "0")) if limit is not None else 0.0 for key in ("lower", "upper"))
        if not lower <= upper:
            raise ValueError(f"joint {joint.get('name')!r} of {path.name} has a lower limit above the upper one")


def check_object(path: Path) -> None:
    """Raises ValueError if the file is neither SDFormat nor URDF, OSError if it cannot be read."""
    _root(path, ("sdf", "robot"))


def _root(path: Path, tags: Iterable[str]) -> ET.Element:
    try:
        root = ET.parse(path).getroot()
    except (ET.ParseError, LookupError, ValueError) as error:  # malformed; of unknown encoding
        raise ValueError(f"{path.name} is not well-formed XML ({error})") from error
    if root.tag not in tags:
        expected = " or ".join(f"<{tag}>" for tag in tags)
        raise ValueError(f"{path.name} begins with <{root.tag}>, not with {expected}")
    return root
