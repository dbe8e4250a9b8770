"""Robots and objects shipped with drake_ltl, as the Drake package `drake_ltl_models`.

agents/planar_arm.urdf            holonomic base with a two-link arm, joints x, y, q1, q2
agents/mobile_manipulator.urdf    holonomic base that turns, with an arm of six joints: x, y, yaw, q1 .. q6
agents/mobile_manipulator_7.urdf  the same with an arm of seven joints
bases/differential_drive.urdf     base on two driven wheels, which cannot move sideways, free on the floor
objects/crate.sdf                 crate with a handle ring that can be grasped from all sides
"""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

PACKAGE_NAME = "drake_ltl_models"
"""What stands after `package://` in the URIs of these models."""


def package_xml() -> Path:
    """Path of package.xml, for `pydrake.multibody.parsing.PackageMap.AddPackageXml`."""
    return Path(str(files(__name__).joinpath("package.xml")))
