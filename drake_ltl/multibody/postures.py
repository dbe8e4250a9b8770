"""Joint configurations by inverse kinematics: how an agent's arm stands at an object, and where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.solvers import Solve

from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS, AgentModel

POSITION_TOLERANCE = 1e-5
"""Inverse kinematics must meet the grasp this closely [m]: a hundredth of the weld tolerance."""
ANGLE_TOLERANCE = 1e-4
"""... and this closely [rad]."""


@dataclass(frozen=True)
class GraspConfiguration:
    """A configuration that grasps an object standing upright with its origin at (0, 0, z)."""

    name: str
    q: np.ndarray
    """q_i (n,)."""
    X_OE: RigidTransform
    """The grasp frame on the object: where {E} is in {O}."""


def grasp_configurations(
    model: AgentModel, X_OG: RigidTransform, object_height: float
) -> tuple[GraspConfiguration, ...]:
    """The ways in which an agent can grasp a ring around an object: along its heading, forwards or backwards.

    That is all an arm in a vertical plane can do; one with a yaw joint does the same.

    Args:
        X_OG: the ring's grasp frame at azimuth 0, z towards the object; Rz(azimuth) X_OG is one as well.
        object_height: z of Oo in W [m].

    Returns:
        `plus`, reaching along the heading e(psi) (the agent stands at -e(psi) from the object), and `minus`, the
        mirror image, as far as they exist.
    """
    X_WO = RigidTransform([0.0, 0.0, object_height])
    psi = model.agent.heading
    found = []
    for name, azimuth in (("plus", psi + np.pi), ("minus", psi)):
        X_OR = RigidTransform(RotationMatrix.MakeZRotation(azimuth), np.zeros(3)) @ X_OG
        for flip in (0.0, np.pi):  # a parallel gripper may be turned by half a turn about its own z axis
            X_OE = X_OR @ RigidTransform(RotationMatrix.MakeZRotation(flip), np.zeros(3))
            q = solve_grasp(model, X_WO @ X_OE)
            if q is not None:
                found.append(GraspConfiguration(name, q, X_OE))
                break
    return tuple(found)


def solve_grasp(model: AgentModel, X_WE: RigidTransform) -> np.ndarray | None:
    """q (n,) with X_WE(q) as given and the base as far behind the gripper as possible, or None."""
    best, best_reach = None, -np.inf
    for guess in _guesses(model, X_WE):
        q = _solve_from(model, X_WE, guess)
        if q is None:
            continue
        reach = float(np.linalg.norm(q[:NUM_BASE_JOINTS] - X_WE.translation()[:2]))
        if reach > best_reach + 1e-6:
            best, best_reach = q, reach
    return best


def _guesses(model: AgentModel, X_WE: RigidTransform):
    """Starting points: the base 2 m behind the gripper, arm joints at several shares of their ranges."""
    backwards = -X_WE.rotation().matrix()[:2, 2]
    base = X_WE.translation()[:2] + 2.0 * backwards
    lower = np.clip(model.plant.GetPositionLowerLimits()[NUM_BASE_JOINTS:], -np.pi, np.pi)
    upper = np.clip(model.plant.GetPositionUpperLimits()[NUM_BASE_JOINTS:], -np.pi, np.pi)
    for share in (0.25, 0.75, 0.4, 0.6):
        yield np.concatenate([base, lower + share * (upper - lower)])


def _solve_from(model: AgentModel, X_WE: RigidTransform, guess: np.ndarray) -> np.ndarray | None:
    plant = model.plant
    ik = InverseKinematics(plant)
    frame_E, frame_W = plant.GetFrameByName("grasp"), plant.world_frame()
    p = X_WE.translation()
    slack = np.full(3, POSITION_TOLERANCE / 4)
    ik.AddPositionConstraint(frame_E, np.zeros(3), frame_W, p - slack, p + slack)
    ik.AddOrientationConstraint(frame_W, X_WE.rotation(), frame_E, RotationMatrix(), ANGLE_TOLERANCE / 4)
    ik.prog().SetInitialGuess(ik.q(), guess)
    result = Solve(ik.prog())
    q = _polish(model, X_WE, result.GetSolution(ik.q()))
    return q if _meets(model, X_WE, q) else None


def _polish(model: AgentModel, X_WE: RigidTransform, q: np.ndarray) -> np.ndarray:
    """A few Gauss-Newton steps: the solver stops at its own feasibility tolerance."""
    for _ in range(5):
        q = q + np.linalg.lstsq(model.grasp_jacobian(q), pose_error(model.grasp_pose(q), X_WE), rcond=None)[0]
    return q


def _meets(model: AgentModel, X_WE: RigidTransform, q: np.ndarray) -> bool:
    lower, upper = model.plant.GetPositionLowerLimits(), model.plant.GetPositionUpperLimits()
    if not (np.all(np.isfinite(q)) and np.all(q >= lower) and np.all(q <= upper)):
        return False
    error = pose_error(model.grasp_pose(q), X_WE)
    return bool(np.linalg.norm(error[:3]) <= ANGLE_TOLERANCE and np.linalg.norm(error[3:]) <= POSITION_TOLERANCE)


def pose_error(X_WA: RigidTransform, X_WB: RigidTransform) -> np.ndarray:
    """(6,): the rotation vector [rad] and the translation [m], both in W, that take A to B."""
    R_AB_W = X_WB.rotation() @ X_WA.rotation().inverse()
    angle_axis = R_AB_W.ToAngleAxis()
    return np.concatenate([angle_axis.angle() * angle_axis.axis(), X_WB.translation() - X_WA.translation()])
