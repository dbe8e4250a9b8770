"""The control laws (10a) and (10b), as pure functions of arrays; of AutoDiffXd as well as of floats."""

from __future__ import annotations

import numpy as np

from drake_ltl.dynamics.grasp import wrench_at_gripper


def speed_of(v: np.ndarray) -> float:
    """|v| [m/s] of a velocity (3,) or (2,); AutoDiffXd has no derivatives of it at rest, where there are none."""
    x, y, *z = v.tolist()
    squared = x * x + y * y + z[0] * z[0] if z else x * x + y * y
    return squared**0.5 if squared > 0.0 else 0.0 * squared


def growth_of_damping(speed: float, limit: float) -> float:
    """How many times K is what it is at rest: it grows with the square of the speed beyond `limit` [m/s], at most to
    MAX_GROWTH.

    Leaving a narrow place under a navigation function is fast; K may depend on the state as long as it is positive
    definite, V falls all the more.
    """
    return 1.0 if speed <= limit else min((speed / limit) ** 2, MAX_GROWTH)


def growing_damping(damping: np.ndarray, speed: float, limit: float) -> np.ndarray:
    """The diagonal of K at a speed [m/s], see `growth_of_damping`."""
    return damping if speed <= limit else damping * growth_of_damping(speed, limit)


MAX_GROWTH = 8.0
"""K at most, times K at rest, however fast a mover is."""


def transition_torque(gravity: np.ndarray, gradient: np.ndarray, damping: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """(10a): tau_z = g_q(q) - grad_q psi - K_z qd, all (n,)."""
    return gravity - gradient - damping * qd


def team_damping(damping: np.ndarray, mass: float) -> np.ndarray:
    """The diagonal (6,) of K_O (rotational; translational) for a team of so much mass with its load [kg].

    As told up to LIGHT; more mass is damped in proportion to its root, so that heavy teams overshoot as little: whoever
    shoots over the place where a load is to be set down sets it down in full motion.
    """
    return damping * np.repeat([1.0, max(1.0, mass / LIGHT) ** 0.5], 3)


LIGHT = 5.0
"""[kg]: what weighs so much is damped by 0.6 of the critical damping at the usual gains."""


def team_wrench(gravity: np.ndarray, gradient: np.ndarray, damping: np.ndarray, V_WO: np.ndarray) -> np.ndarray:
    """What the team of (10b) shares: g_O - grad_x psi - K_O v_O, all (6,) [N m; N] at Oo."""
    return gravity - gradient - damping * V_WO


def transport_torque(
    share: float, F_O: np.ndarray, p_OoEo_W: np.ndarray, J_WE: np.ndarray, gravity: np.ndarray
) -> np.ndarray:
    """(10b) in joint space: tau = J^T J_O^{-T} c F_O + g_q (n,), for any number n of joints.

    Args:
        share: c_tau of this agent.
        F_O: the team's wrench (6,), see `team_wrench`.
        p_OoEo_W: (3,) [m], from the object's origin to the gripper.
        J_WE: J_i(q) (6, n).
        gravity: g_q(q) (n,).
    """
    return J_WE.T @ wrench_at_gripper(share * F_O, p_OoEo_W) + gravity


def body_gravity(mass: float) -> np.ndarray:
    """g_O (6,) [N m; N]: the wrench at the centre of mass that balances gravity."""
    return np.array([0.0, 0.0, 0.0, 0.0, 0.0, mass * GRAVITY])


GRAVITY = 9.81
"""[m/s^2], Drake's default gravity field."""
