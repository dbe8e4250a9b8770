"""The numbers that planning needs to know of the models: radii and where spheres stand.

Planning never loads a model. `drake_ltl.multibody.MeasureGeometry` measures these numbers with Drake.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

Vector3 = tuple[float, float, float]


@dataclass(frozen=True)
class GraspOption:
    """One way in which an agent can grasp an object that stands on the floor.

    The offsets point from the object's origin Oo to the centre C of the agent's bounding sphere, in the world
    frame W, for the object as it stands at the start.
    """

    name: str
    p_OoC_standoff: Vector3
    """Where the agent waits: its sphere is clear of the object's, the way to the grasp is a straight line."""
    p_OoC_grasp: Vector3
    """Where it is once it has grasped."""
    standoff_posture: str
    """Key into `Geometry.postures` of the arm posture at the stand-off."""

    def turned(self, angle: float) -> GraspOption:
        """The same grasp of the object when it has been turned by `angle` [rad], the agent along with it."""
        standoff, grasp = turned(self.p_OoC_standoff, angle), turned(self.p_OoC_grasp, angle)
        return GraspOption(self.name, standoff, grasp, turned_posture(self.standoff_posture, angle))


def turned(p: Vector3, angle: float) -> Vector3:
    """The vector, turned about the vertical."""
    x, y, z = p
    c, s = math.cos(angle), math.sin(angle)
    return p if angle == 0.0 else (c * x - s * y, s * x + c * y, z)


def turned_posture(name: str, angle: float) -> str:
    """Key into `Geometry.postures` of the arm posture when all of the arm is turned by `angle` [rad]."""
    return name if angle == 0.0 else f"{name} turned by {angle:.6g}"


@dataclass(frozen=True)
class Geometry:
    """Radii [m] and offsets [m] of all members of a scenario."""

    agent_radius: Mapping[str, float]
    """r_i, constant for every configuration."""
    object_radius: Mapping[str, float]
    """r_j^O."""
    object_height: Mapping[str, float]
    """z of the object's origin Oo when it rests on the floor."""
    team_radius: Mapping[str, float]
    """r_{T,j} about Oo, for any team that grasps j."""
    postures: Mapping[str, Mapping[str, Vector3]] = field(default_factory=dict)
    """agent -> posture -> p_BC_W, from the base's origin B (on the floor) to the sphere's centre C.

    The first posture is the default one at the start; a start position that does not fit it may take another.
    """
    grasps: Mapping[tuple[str, str], tuple[GraspOption, ...]] = field(default_factory=dict)
    """(agent, object) -> the ways to grasp; empty where the agent cannot."""
