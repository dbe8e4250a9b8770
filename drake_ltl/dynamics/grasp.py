"""Kinematics of a rigid grasp: the object-to-agent Jacobian (4), the grasp matrix (6), and their rates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def skew(x: np.ndarray) -> np.ndarray:
    """S(x) (3, 3) with S(x) y = x cross y."""
    return np.array([[0.0, -x[2], x[1]], [x[2], 0.0, -x[0]], [-x[1], x[0], 0.0]])


def object_to_agent_jacobian(p_OoEo_W: np.ndarray) -> np.ndarray:
    """J^O_{i,j} (6, 6) of (4): V_WE = J^O V_WO for the end-effector at p_OoEo_W (3,) [m] from the object's origin."""
    return _with_corner(np.eye(6), -skew(p_OoEo_W))


def object_to_agent_jacobian_rate(p_OoEo_W: np.ndarray, w_WO: np.ndarray) -> np.ndarray:
    """d/dt J^O_{i,j} (6, 6): the offset turns with the object, whose angular velocity is w_WO (3,) [rad/s]."""
    return _with_corner(np.zeros((6, 6)), -skew(skew(w_WO) @ p_OoEo_W))


def grasp_matrix(offsets: Sequence[np.ndarray]) -> np.ndarray:
    """G_{T,j} (6 |T|, 6) of (6): stacks J^O_{i,j}; the agents' wrenches f_T add up to G^T f_T on the object.

    Args:
        offsets: p_OoEo_W (3,) [m] of each member of the team.
    """
    return np.concatenate([object_to_agent_jacobian(p) for p in offsets])


def grasp_matrix_rate(offsets: Sequence[np.ndarray], w_WO: np.ndarray) -> np.ndarray:
    """d/dt G_{T,j} (6 |T|, 6), needed by (7), for the object's angular velocity w_WO (3,) [rad/s]."""
    return np.concatenate([object_to_agent_jacobian_rate(p, w_WO) for p in offsets])


def wrench_at_gripper(F_O: np.ndarray, p_OoEo_W: np.ndarray) -> np.ndarray:
    """J_O^{-T} F_O (6,): the wrench at Eo that is equivalent to F_O (6,) [N m; N] at Oo. No inverse is formed."""
    (x, y, z), (tx, ty, tz, fx, fy, fz) = p_OoEo_W.tolist(), F_O.tolist()  # numbers of their own are quick
    return np.array([tx - (y * fz - z * fy), ty - (z * fx - x * fz), tz - (x * fy - y * fx), fx, fy, fz])


def _with_corner(matrix: np.ndarray, corner: np.ndarray) -> np.ndarray:
    """`matrix` with `corner` in the rows of the translation and the columns of the rotation, of any scalar type."""
    matrix = matrix.astype(np.asarray(corner).dtype)
    matrix[3:, :3] = corner
    return matrix
