"""How a team shares its load: the coefficients c_tau of (10b), and what of the agents' wrenches is internal."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drake_ltl.dynamics.grasp import object_to_agent_jacobian, wrench_at_gripper

SUM_TOLERANCE = 1e-9
"""How far from 1 the sum of shares may be: rounding of a few quotients."""


def load_shares(power: Sequence[float]) -> np.ndarray:
    """c_tau in proportion to the members' powers zeta: positive, of sum 1.

    Raises:
        ValueError: no powers, or some that are not positive and finite, or too far apart to be shared by.
    """
    power = np.asarray(power, dtype=float)
    if power.size == 0 or not np.all((power > 0.0) & np.isfinite(power)):
        raise ValueError(f"load shares need positive, finite powers, not {power.tolist()!r}")
    shares = power / power.max()  # a sum of the largest numbers may overflow
    shares /= shares.sum()
    if not np.all(shares > 0.0):
        raise ValueError(f"powers {power.tolist()!r} are too far apart: the least share would be 0")
    return shares


def check_load_shares(shares: np.ndarray) -> None:
    """c_tau (N,) as the team's controller takes them: positive in the team, of sum 1; zero elsewhere.

    All may be zero, while nobody carries.

    Raises:
        ValueError: some are negative or not finite, or their sum is neither 1 nor 0.
    """
    total = shares.sum()
    if not (shares >= 0.0).all() or not (total == 0.0 or -SUM_TOLERANCE <= total - 1.0 <= SUM_TOLERANCE):
        raise ValueError(f"load shares must be positive and of sum 1 within a team, not {shares.tolist()!r}")


def internal_wrenches(
    wrenches: Sequence[np.ndarray], offsets: Sequence[np.ndarray], shares: Sequence[float]
) -> np.ndarray:
    """The part (|T|, 6) [N m; N] of the agents' wrenches f_i on the object that does not move it: G^T f_int = 0.

    What moves the object is F = G^T f, distributed as (10b) does it, J_O^{-T} c_i F: a right inverse of G^T that
    squeezes nothing, since all members push alike. The rest lies in the null space of G^T. Which right inverse is
    taken is a convention; the pseudo-inverse would add metres to newtons.

    Args:
        wrenches: f_i (6,) at Eo, in W, of each member.
        offsets: p_OoEo_W (3,) [m] of each member.
        shares: c_i of each member, of sum 1.
    """
    F_O = sum(object_to_agent_jacobian(p).T @ f for f, p in zip(wrenches, offsets, strict=True))
    return np.array([f - wrench_at_gripper(c * F_O, p) for f, p, c in zip(wrenches, offsets, shares, strict=True)])
