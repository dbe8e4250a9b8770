"""How far an arm is from its singularities, and which way leads away from them: functions of its Jacobian alone."""

from __future__ import annotations

import numpy as np
from pydrake.math import inv


def manipulability(J: np.ndarray) -> np.ndarray:
    """w = sqrt(det J J^T) (...), of J (..., 6, n) with n >= 6; of fewer joints, sqrt(det J^T J): 0 at singularities."""
    return np.prod(np.linalg.svd(J, compute_uv=False), axis=-1)


def jacobian_slopes(J: np.ndarray) -> np.ndarray:
    """(6, n, n): [:, i, j] = dJ_i/dq_j, of a serial chain whose joints stand in order, base first.

    A joint j before i carries joint i along, omega_j x (omega_i; v_i); one behind it moves the end-effector alone,
    omega_i x v_j. Joints that do not move the end-effector do not matter (their columns are zero).
    """
    w, v = J[:3].T, J[3:].T
    before = np.tri(len(w), dtype=bool)[:, :, None]  # [i, j]: j <= i
    turned = np.cross(w[None, :], w[:, None])
    carried, swept = np.cross(w[None, :], v[:, None]), np.cross(w[:, None], v[None, :])
    rotational, translational = np.where(before, turned, 0.0 * turned), np.where(before, carried, swept)
    return np.concatenate([rotational, translational], axis=2).transpose(2, 0, 1)


def log_manipulability_slope(J: np.ndarray) -> np.ndarray:
    """d(log w)/dq (n,) = tr(J^+ dJ/dq_j), of J (6, n) with full rank 6; of AutoDiffXd as well.

    Args:
        J: of a serial chain, see `jacobian_slopes`.
    """
    pseudo_inverse = J.T @ inv(J @ J.T)
    slopes = jacobian_slopes(J)
    return np.array([np.sum(pseudo_inverse.T * slopes[:, :, j]) for j in range(J.shape[1])])
