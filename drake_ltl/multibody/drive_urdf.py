"""A differential drive's URDF on joints from the world, in place of its free base.

A free body's pose is a quaternion, whose rates are none of its velocities. The same six degrees of freedom as joints,

    world - x - y - yaw - z - pitch - roll - base,

have one number for each rate, and say what control laws ask for: x, y and yaw are the pose (p, theta) of (U1). Pitch
and roll are about the centre of mass, above the middle of the axle: whatever a body does that rocks on its tyres and
casters, there forces change the velocity. Nothing is tied by these joints: the wheels stand on the floor by contact.
"""

from __future__ import annotations

from xml.dom import minidom

FREE_JOINTS = ("x", "y", "yaw", "z", "pitch", "roll")
"""In the order of q; the wheels follow."""
_AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1", "yaw": "0 0 1", "pitch": "0 1 0", "roll": "1 0 0"}
_TYPES = {"x": "prismatic", "y": "prismatic", "z": "prismatic"}
_FRAME = "bounding_centre"


def on_joints(document: minidom.Document, centre: float) -> None:
    """Puts the robot on FREE_JOINTS, all zero where its base's origin is the world's.

    `centre` is the height of its centre of mass there [m].

    Its frame `bounding_centre` no longer bounces and pitches with the tyres: it is as high above the floor as when the
    base is level, wherever x, y and yaw are.

    Raises ValueError unless one link is the root, with `bounding_centre` on it.
    """
    robot = document.documentElement
    base = _root_link(robot)
    parent = "world"
    for name in FREE_JOINTS:
        child = f"_{name}"
        _add(robot, "link", name=child)
        height = centre if name == "z" else 0.0
        _join(robot, name, _TYPES.get(name, "continuous"), parent, child, height, _AXES[name])
        parent = child
    _join(robot, "_base", "fixed", parent, base, -centre, None)
    for frame in _children(robot, "frame"):
        if frame.getAttribute("name") == _FRAME:
            if frame.getAttribute("link") != base:
                raise ValueError(f"the frame {_FRAME!r} is not on the base, {base!r}")
            frame.setAttribute("link", "_yaw")


def _root_link(robot: minidom.Element) -> str:
    joints = _children(robot, "joint")
    moved = {child.getAttribute("link") for joint in joints for child in _children(joint, "child")}
    roots = [name for link in _children(robot, "link") if (name := link.getAttribute("name")) not in moved]
    if len(roots) != 1:
        raise ValueError(f"a differential drive has one free base, not {', '.join(roots) or 'none'}")
    return roots[0]


def _join(robot: minidom.Element, name: str, kind: str, parent: str, child: str, z: float, axis: str | None) -> None:
    joint = _add(robot, "joint", name=name, type=kind)
    _add(joint, "origin", xyz=f"0 0 {z!r}")
    _add(joint, "parent", link=parent)
    _add(joint, "child", link=child)
    if axis is not None:
        _add(joint, "axis", xyz=axis)


def _add(parent: minidom.Element, tag: str, **attributes: str) -> minidom.Element:
    element = parent.appendChild(parent.ownerDocument.createElement(tag))
    for name, value in attributes.items():
        element.setAttribute(name, value)
    return element


def _children(parent: minidom.Element, tag: str) -> list[minidom.Element]:
    return [node for node in parent.childNodes if getattr(node, "tagName", None) == tag]
