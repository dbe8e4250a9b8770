"""Grasp kinematics, load sharing and the control laws of the paper, as pure functions of arrays.

Spatial vectors are stacked as in Drake, (rotational; translational), and expressed in the world frame W; the paper
stacks (translational; rotational). `u` is a wrench, `tau` are joint torques.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def skew(x: np.ndarray) -> np.ndarray:
    """S(x) (3, 3) with S(x) y = x cross y."""
    return np.array([[0.0, -x[2], x[1]], [x[2], 0.0, -x[0]], [-x[1], x[0], 0.0]])


def object_to_agent_jacobian(p_OoEo_W: np.ndarray) -> np.ndarray:
    """J^O_{i,j} (6, 6) of (4): V_WE = J^O V_WO for the end-effector at p_OoEo_W (3,) [m] from the object's origin."""
    jacobian = np.eye(6)
    jacobian[3:, :3] = -skew(p_OoEo_W)
    return jacobian


def grasp_matrix(offsets: Sequence[np.ndarray]) -> np.ndarray:
    """G_{T,j} (6 |T|, 6) of (6): stacks J^O_{i,j}; the agents' wrenches f_T add up to G^T f_T on the object.

    Args:
        offsets: p_OoEo_W (3,) [m] of each member of the team.
    """
    return np.concatenate([object_to_agent_jacobian(p) for p in offsets])


def wrench_at_gripper(F_O: np.ndarray, p_OoEo_W: np.ndarray) -> np.ndarray:
    """J_O^{-T} F_O (6,): the wrench at Eo that is equivalent to F_O (6,) [N m; N] at Oo. No inverse is formed."""
    torque = F_O[:3] - skew(p_OoEo_W) @ F_O[3:]
    return np.concatenate([torque, F_O[3:]])


def load_shares(power: Sequence[float]) -> np.ndarray:
    """c_tau in proportion to the members' powers zeta: positive, of sum 1."""
    shares = np.asarray(power, dtype=float)
    if shares.size == 0 or not np.all(shares > 0.0):
        raise ValueError(f"load shares need positive powers, not {list(power)!r}")
    return shares / shares.sum()


def growing_damping(damping: np.ndarray, speed: float, limit: float) -> np.ndarray:
    """The diagonal of K, growing with the square of the speed beyond `limit` [m/s], at most MAX_GROWTH times.

    Leaving a narrow place under a navigation function is fast; K may depend on the state as long as it is positive
    definite, V falls all the more.
    """
    return damping * min(max(1.0, (speed / limit) ** 2), MAX_GROWTH)


MAX_GROWTH = 8.0
"""K dt / m stays below about one half for the lightest mover at a time step of 5 ms: no chatter."""


def transition_torque(gravity: np.ndarray, gradient: np.ndarray, damping: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """(10a): tau_z = g_q(q) - grad_q psi - K_z qd, all (n,)."""
    return gravity - gradient - damping * qd


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


def tracking_acceleration(
    q: np.ndarray,
    qd: np.ndarray,
    q_ref: np.ndarray,
    qd_ref: np.ndarray,
    qdd_ref: np.ndarray,
    frequency: float,
) -> np.ndarray:
    """qdd (n,) whose error obeys e'' + 2 w e' + w^2 e = 0, w = `frequency` [rad/s] (critically damped)."""
    return qdd_ref + 2.0 * frequency * (qd_ref - qd) + frequency**2 * (q_ref - q)


def quintic(
    t: float, duration: float, start: np.ndarray, goal: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rest-to-rest quintic from start to goal (n,): position, velocity, acceleration at time t [s]."""
    s = min(max(t / duration, 0.0), 1.0)
    way = goal - start
    position = start + way * (s**3 * (10.0 - 15.0 * s + 6.0 * s**2))
    velocity = way * (30.0 * s**2 * (1.0 - s) ** 2 / duration)
    acceleration = way * (60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / duration**2)
    return position, velocity, acceleration
