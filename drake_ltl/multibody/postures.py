"""Joint configurations by inverse kinematics: how an agent's arm stands at an object, and where."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.solvers import Solve

from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS, AgentModel
from drake_ltl.multibody.manipulability import log_manipulability_slope

POSITION_TOLERANCE = 1e-5
"""Inverse kinematics must meet the grasp this closely [m]: a hundredth of the weld tolerance."""
ANGLE_TOLERANCE = 1e-4
"""... and this closely [rad]."""
EASE = 0.03
"""How far a redundant arm's base comes closer for an e-fold of manipulability, or of room to its joints' limits [m]."""
ROOM = 0.02
"""A redundant arm keeps this share of its joints' ranges free on either side."""
LEAST_CLEARANCE = 2e-3
"""Who grasps stays this clear of the object, but for its handles [m]: twice the gap with which welds are made."""
GOOD_CLEARANCE = 0.01
"""Who has a yaw joint grasps from beside its heading if it is less clear than this [m]."""
SIDESTEPS = np.deg2rad([0.0, 15.0, -15.0, 30.0, -30.0])
"""... by one of these angles [rad], the first from which it is."""


@dataclass(frozen=True)
class GraspConfiguration:
    """A configuration that grasps an object as it stands at the start, but with its origin at (0, 0, z)."""

    name: str
    q: np.ndarray
    """q_i (n,)."""
    X_OE: RigidTransform
    """The grasp frame on the object: where {E} is in {O}."""


Clearance = Callable[[GraspConfiguration], float]
"""How clear of the object an agent stays that grasps so [m]."""


def grasp_configurations(
    model: AgentModel,
    X_OG: RigidTransform,
    object_height: float,
    R_WO: RotationMatrix | None = None,
    clearance: Clearance | None = None,
) -> tuple[GraspConfiguration, ...]:
    """The ways in which an agent can grasp a ring around an object: along its heading, forwards or backwards.

    That is all an arm in a vertical plane can do; one with a yaw joint does the same, or somewhat beside its heading
    where it would come too close to the object. Of all the postures in which a redundant arm can do so, the one that
    stands far off at ease, see `comfort`.

    Args:
        X_OG: the ring's grasp frame at azimuth 0, z towards the object; Rz(azimuth) X_OG is one as well.
        object_height: z of Oo in W [m].
        R_WO: how the object stands; None if upright, at heading 0.
        clearance: of what is less clear than LEAST_CLEARANCE no way is made; None takes all as clear.

    Returns:
        `plus`, reaching along the heading e(psi) (the agent stands at -e(psi) from the object), and `minus`, the
        mirror image, as far as they exist. On an object that lies on its side, each the nearest to that.
    """
    X_WO = RigidTransform(R_WO or RotationMatrix(), [0.0, 0.0, object_height])
    found = []
    for name, sign in (("plus", 1.0), ("minus", -1.0)):
        ways = _from_sides(model, name, sign, X_OG, X_WO)
        if clearance is not None:
            clear = ((clearance(way), way) for way in ways)
            ways = iter(_clearest(clear))
        found += [way for way in (next(ways, None),) if way is not None]
    return tuple(found)


def _from_sides(
    model: AgentModel, name: str, sign: float, X_OG: RigidTransform, X_WO: RigidTransform
) -> Iterator[GraspConfiguration]:
    """The way along the heading, then those beside it that an agent with a yaw joint has."""
    for sidestep in SIDESTEPS if model.yaw_direction else SIDESTEPS[:1]:
        way = _grasp_along(model, name, sign, model.agent.heading + sidestep, X_OG, X_WO)
        if way is not None:
            yield way


def _clearest(ways: Iterator[tuple[float, GraspConfiguration]]) -> list[GraspConfiguration]:
    """The first that is clear enough, else the one that is most, if that will do: none or one."""
    best, most = None, LEAST_CLEARANCE
    for clear, way in ways:
        if clear >= GOOD_CLEARANCE:
            return [way]
        if clear >= most:
            best, most = way, clear
    return [] if best is None else [best]


def _grasp_along(
    model: AgentModel, name: str, sign: float, heading: float, X_OG: RigidTransform, X_WO: RigidTransform
) -> GraspConfiguration | None:
    """The grasp on the ring whose approach is nearest to along `sign` e(heading), in the most comfortable posture."""
    ahead_O = X_WO.rotation().inverse() @ (sign * np.array([np.cos(heading), np.sin(heading), 0.0]))
    approach_O = X_OG.rotation().matrix()[:, 2]
    if min(np.linalg.norm(ahead_O[:2]), np.linalg.norm(approach_O[:2])) < 1e-6:
        return None  # the ring's axis lies along the heading: it has no such side
    azimuth = np.arctan2(ahead_O[1], ahead_O[0]) - np.arctan2(approach_O[1], approach_O[0])
    X_OR = RigidTransform(RotationMatrix.MakeZRotation(azimuth), np.zeros(3)) @ X_OG
    # a parallel gripper may be turned by half a turn about its own z axis
    turned = [X_OR @ RigidTransform(RotationMatrix.MakeZRotation(flip), np.zeros(3)) for flip in (0.0, np.pi)]
    solved = [(solve_grasp(model, X_WO @ X_OE), X_OE) for X_OE in turned]
    ways = [GraspConfiguration(name, q, X_OE) for q, X_OE in solved if q is not None]
    return max(ways, key=lambda way: comfort(model, way.q)) if ways else None


def solve_grasp(model: AgentModel, X_WE: RigidTransform) -> np.ndarray | None:
    """q (n,) with X_WE(q) as given and the greatest `comfort` found, or None."""
    best, best_comfort = None, -np.inf
    for guess in _guesses(model, X_WE):
        q = _solve_from(model, X_WE, guess)
        if q is not None and model.is_redundant:
            q = _at_ease(model, X_WE, q)
        if q is not None and comfort(model, q) > best_comfort + 1e-6:
            best, best_comfort = q, comfort(model, q)
    return best


def comfort(model: AgentModel, q: np.ndarray) -> float:
    """How far the base stands from the gripper [m], so that teams find room; for a redundant arm less what it costs.

    That is EASE times log(1 / w) and -log(1 - x^2) of every joint with limits, x in (-1, 1): far from singularities
    and from the limits of joints.
    """
    reach = float(np.linalg.norm(q[:NUM_BASE_JOINTS] - model.grasp_pose(q).translation()[:2]))
    if not model.is_redundant:
        return reach
    _, _, x = _shares_of_ranges(model, q)
    w = model.manipulability(q)
    return reach + EASE * float(np.log(max(w, 1e-12)) + np.log(np.maximum(1.0 - x**2, 1e-12)).sum())


def _comfort_slope(model: AgentModel, q: np.ndarray) -> np.ndarray:
    J = model.grasp_jacobian(q)
    limited, half, x = _shares_of_ranges(model, q)
    slope = EASE * log_manipulability_slope(J)
    slope[limited] -= EASE * 2.0 * x / (1.0 - x**2) / half
    behind = q[:NUM_BASE_JOINTS] - model.grasp_pose(q).translation()[:2]
    away = behind / np.linalg.norm(behind)
    slope[:NUM_BASE_JOINTS] += away
    return slope - J[3:5].T @ away


def _shares_of_ranges(model: AgentModel, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which joints of the arm have limits, half their ranges, and where in (-1, 1) of them q is."""
    lower, upper = model.plant.GetPositionLowerLimits(), model.plant.GetPositionUpperLimits()
    limited = np.isfinite(upper - lower) & (upper > lower)
    limited[:NUM_BASE_JOINTS] = False
    lower, upper = lower[limited], upper[limited]
    half = 0.5 * (upper - lower)
    return limited, half, (q[limited] - 0.5 * (lower + upper)) / half


def _at_ease(model: AgentModel, X_WE: RigidTransform, q: np.ndarray) -> np.ndarray | None:
    """The same grasp with the greatest comfort nearby."""
    import scipy.optimize  # takes a while to load, and few models need it

    lower, upper = model.plant.GetPositionLowerLimits(), model.plant.GetPositionUpperLimits()
    limited, half, _ = _shares_of_ranges(model, q)
    lower[limited] += 2.0 * ROOM * half
    upper[limited] -= 2.0 * ROOM * half
    result = scipy.optimize.minimize(
        lambda q: -comfort(model, q),
        np.clip(q, lower, upper),
        jac=lambda q: -_comfort_slope(model, q),
        method="SLSQP",
        bounds=scipy.optimize.Bounds(lower, upper),
        constraints={
            "type": "eq",
            "fun": lambda q: pose_error(model.grasp_pose(q), X_WE),
            "jac": lambda q: -model.grasp_jacobian(q),
        },
        options={"maxiter": 200, "ftol": 1e-10},
    )
    q = polished(model, X_WE, result.x)
    return q if _meets(model, X_WE, q) else None


def _guesses(model: AgentModel, X_WE: RigidTransform):
    """Starting points: the base 2 m behind the gripper, arm joints at several shares of their ranges.

    Of a redundant arm also its zero, which is where designers mean it to be, with the third joint, its yaw as a rule,
    turned as the gripper is.
    """
    backwards = -X_WE.rotation().matrix()[:2, 2]
    base = X_WE.translation()[:2] + 2.0 * backwards
    lower, upper = model.arm_limits
    if model.is_redundant:
        arm = np.clip(0.0, lower, upper)
        yield np.concatenate([base, arm])
        arm[0] = np.clip(np.arctan2(-backwards[1], -backwards[0]), lower[0], upper[0])
        yield np.concatenate([base, arm])
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
    q = polished(model, X_WE, result.GetSolution(ik.q()))
    return q if _meets(model, X_WE, q) else None


def polished(model: AgentModel, X_WE: RigidTransform, q: np.ndarray) -> np.ndarray:
    """q (n,) nearby whose gripper is at X_WE, or as close to it as an arm of few joints comes: some Gauss-Newton steps,
    each as short as it can be."""
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
