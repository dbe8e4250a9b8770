"""k Phi of a step's movers and its gradient, wherever their kinematics come from."""

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
    """k Phi and its gradient with respect to all movers."""

    potential: float
    """k Phi [J]."""
    agents: Mapping[str, np.ndarray]
    """k dPhi/dq_z (n_z,) of each traveller."""
    objects: Mapping[str, np.ndarray]
    """k dPhi/dx (6,) (rotational; translational) of each carried object."""


REST = FieldValue(0.0, {}, {})


def evaluate_field(field: StepField, force: float, models: Mapping[str, AgentModel], world: Kinematics) -> FieldValue:
    """Value and gradient of force * Phi.

    Raises:
        ExecutionError: a relation is violated, of those it names.
    """
    travels, transports = field.travels, field.transports
    points, slopes, gamma = [], [], 0.0
    for task in travels:
        points.append(world.centre(task.agent))
        gamma_z, slope = models[task.agent].goal_error(world.q(task.agent), task.q_goal)
        gamma += gamma_z
        slopes.append(slope)
    for task in transports:
        pose = world.q(task.object)
        points.append((*pose[4:6], task.p_goal[2]))
        gamma_R, slope_R = rotation_error(pose[:4], task.orientation_goal)
        error = pose[4:] - task.p_goal
        gamma += float(error @ error) + gamma_R
        slopes.append(np.array([*(0.5 * slope_R), *error]))
    p = np.array(points)
    value, by_gamma, by_p = field.potential.value_and_gradient(gamma, p)
    if not isfinite(by_gamma):
        violated = ", ".join(str(label) for label in field.function.violated(field.relations.at(p)))
        raise ExecutionError(f"in collision: {violated}" if violated else f"no gradient at gamma = {gamma!r} m^2")
    by_p = force * by_p
    gradients = [2.0 * force * by_gamma * slope for slope in slopes]
    for row, task in enumerate(travels):
        gradients[row] += by_p[row] @ world.centre_jacobian(task.agent)
    for row in range(len(travels), len(gradients)):
        gradients[row][3:5] += by_p[row, :2]
    return FieldValue(
        force * value,
        {task.agent: gradient for task, gradient in zip(travels, gradients, strict=False)},
        {task.object: gradient for task, gradient in zip(transports, gradients[len(travels) :], strict=True)},
    )


def rotation_error(quaternion: np.ndarray, goal: np.ndarray) -> tuple[float, np.ndarray]:
    """3 - tr(R*^T R) = 2 (1 - cos angle) between an orientation and its goal, quaternions (4,), times ROTATION_WEIGHT,
    and its slope (3,) along omega_W."""
    error, slope = quaternion_mismatch(quaternion, goal)
    return ROTATION_WEIGHT * error, ROTATION_WEIGHT * slope
