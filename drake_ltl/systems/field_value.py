"""k Phi + h_O of a step's movers and its gradient, wherever their kinematics come from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Protocol

import numpy as np

from drake_ltl.dynamics import quaternion_mismatch
from drake_ltl.errors import ExecutionError
from drake_ltl.multibody.agent_model import AgentModel
from drake_ltl.systems.step_field import StepField

ROTATION_WEIGHT = 1.0
"""Weight of a carried object's orientation error in gamma [m^2/rad^2]: the paper's gamma_T has none, which leaves
the tilt of a load that one agent carries to itself."""

# Of a carried object the obstacle function G sees x and y, at the height of the goal: a load goes around what is in
# its way. Lifted over it, its team would fold together, in places to postures from which there is no way back down.


class Kinematics(Protocol):
    """Where movers are: `multibody.CrewModel`, or anything else that knows."""

    def q(self, name: str) -> np.ndarray:
        """(n,) of an agent, quaternion and origin (7,) of an object."""
        ...

    def centre(self, agent: str) -> np.ndarray:
        """c_i (3,) [m] in W."""
        ...

    def centre_jacobian(self, agent: str) -> np.ndarray:
        """d c_i / d q (3, n) in W."""
        ...


@dataclass(frozen=True)
class FieldValue:
    """k Phi + h_O, the latter of all loads (`dynamics.load_spring`), and its gradient with respect to all movers."""

    potential: float
    """k Phi + h_O [J]."""
    agents: Mapping[str, np.ndarray]
    """k dPhi/dq_z (n_z,) of each traveller."""
    objects: Mapping[str, np.ndarray]
    """d(k Phi + h_O)/dx (6,) (rotational; translational) of each carried object."""


REST = FieldValue(0.0, {}, {})


def evaluate_field(field: StepField, force: float, models: Mapping[str, AgentModel], world: Kinematics) -> FieldValue:
    """Value and gradient of force * Phi + h_O.

    Raises:
        ExecutionError: a relation is violated, of those it names.
    """
    points, slopes, gamma = [], [], 0.0
    for task in field.travels:
        points.append(world.centre(task.agent).tolist())
        gamma_z, slope = models[task.agent].goal_error(world.q(task.agent), task.q_goal)
        gamma += gamma_z
        slopes.append(slope.tolist())
    for task in field.transports:
        pose = world.q(task.object)
        x, y, _ = p_WO = pose[4:].tolist()
        points.append([x, y, float(task.p_goal[2])])
        gamma_T, slope = rotation_error(pose[:4], task.orientation_goal)
        error = [here - there for here, there in zip(p_WO, task.p_goal.tolist(), strict=True)]
        gamma += sum([length * length for length in error], gamma_T)
        slopes.append([0.5 * turn for turn in slope.tolist()] + error)
    value, by_gamma, by_p = field.potential.value_and_gradient(gamma, points)
    if not isfinite(by_gamma):
        violated = ", ".join(str(label) for label in field.function.violated(field.relations.at(np.array(points))))
        raise ExecutionError(f"in collision: {violated}" if violated else f"no gradient at gamma = {gamma!r} m^2")
    twice = 2.0 * force * by_gamma
    forces = [[force * along for along in row] for row in by_p]
    first = len(field.travels)
    agents = {
        task.agent: _pulled_back(twice, slope, f, world.centre_jacobian(task.agent))
        for task, slope, f in zip(field.travels, slopes[:first], forces[:first], strict=True)
    }
    potential, objects = force * value, {}
    for task, spring, slope, (fx, fy, _) in zip(
        field.transports, field.springs, slopes[first:], forces[first:], strict=True
    ):
        energy, pull = spring.value_and_slope(world.q(task.object))
        potential += energy
        rows = zip(slope, (0.0, 0.0, 0.0, fx, fy, 0.0), pull, strict=True)
        objects[task.object] = np.array([twice * s + along + h for s, along, h in rows])
    return FieldValue(potential, agents, objects)


def _pulled_back(factor: float, slope: list[float], f: list[float], J: np.ndarray) -> np.ndarray:
    """factor * slope + f J (n,), for J (3, n)."""
    (fx, fy, fz), (along_x, along_y, along_z) = f, J.tolist()
    rows = zip(slope, along_x, along_y, along_z, strict=True)
    return np.array([factor * s + (fx * x + fy * y + fz * z) for s, x, y, z in rows])


def rotation_error(quaternion: np.ndarray, goal: np.ndarray) -> tuple[float, np.ndarray]:
    """3 - tr(R*^T R) = 2 (1 - cos angle) between an orientation and its goal, quaternions (4,), times ROTATION_WEIGHT,
    and its slope (3,) along omega_W."""
    error, slope = quaternion_mismatch(quaternion, goal)
    return ROTATION_WEIGHT * error, ROTATION_WEIGHT * slope
