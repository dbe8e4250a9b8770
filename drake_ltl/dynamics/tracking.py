"""Motions in joint space that the navigation function does not govern: reaching for a grasp, holding still."""

from __future__ import annotations

import numpy as np


def tracking_acceleration(
    q: np.ndarray,
    qd: np.ndarray,
    q_ref: np.ndarray,
    qd_ref: np.ndarray | float,
    qdd_ref: np.ndarray | float,
    frequency: float | np.ndarray,
) -> np.ndarray:
    """qdd (n,) whose error obeys e'' + 2 w e' + w^2 e = 0, w = `frequency` [rad/s] (critically damped).

    `qd_ref` and `qdd_ref` may be 0 for a reference at rest, `frequency` (n,) may have a number for each joint.
    """
    return qdd_ref + frequency * (2.0 * (qd_ref - qd) + frequency * (q_ref - q))


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
