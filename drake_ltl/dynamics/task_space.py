"""Task-space dynamics (1b) of one agent: what its end-effector's twist obeys, for any number of joints.

With a right inverse of J, v = J qd and qd = J# v + (I - J# J) qd, (1a) becomes, multiplied by (J#)^T,

    M vdot + C v + g + h = u - f,   M = (J#)^T B J#,   C = (J#)^T (N J# + B dJ#/dt),   g = (J#)^T g_q,

and dM/dt - 2 C is skew symmetric for any differentiable J#. The paper's choice for n >= 6 is the dynamically
consistent inverse, for which M = (J B^-1 J^T)^-1 and null-space torques do not move the end-effector. What motion in
the null space does to it all the same is h (`null_space_wrench`), zero for n <= 6; the paper leaves it out.

An arm of n < 6 joints cannot produce all twists. J# is then the pseudo-inverse, the equations hold within the range of
J (multiplied by the projection J J#), and M has rank n.
"""

from __future__ import annotations

import numpy as np

from drake_ltl.dynamics.joint_space import JointDynamics
from drake_ltl.dynamics.spatial import SpatialDynamics

SINGULAR = 1e-9
"""Relative to the greatest singular value of J: below this nothing is left of the inverse but rounding."""


def task_inverse(joint: JointDynamics) -> np.ndarray:
    """J# (n, 6): for n >= 6 that of the paper, B^-1 J^T M, else the pseudo-inverse (J^T J)^-1 J^T.

    Raises:
        ValueError: at a kinematic singularity, outside the set S_i.
    """
    J = joint.J
    values = np.linalg.svd(J, compute_uv=False)
    if values[-1] <= SINGULAR * values[0]:
        raise ValueError(f"kinematic singularity: J has singular values {values.tolist()!r}")
    if J.shape[1] < 6:
        return np.linalg.pinv(J)
    by_inertia = np.linalg.solve(joint.B, J.T)
    return by_inertia @ np.linalg.inv(J @ by_inertia)


def task_dynamics(joint: JointDynamics) -> SpatialDynamics:
    """M_i, C_i, g_i of (1b), with dM_i/dt - 2 C_i skew symmetric.

    Raises:
        ValueError: at a kinematic singularity.
    """
    inverse = task_inverse(joint)
    M = inverse.T @ joint.B @ inverse
    C = inverse.T @ joint.N @ inverse + _inertia_times_inverse_rate(joint, inverse, M)
    return SpatialDynamics(0.5 * (M + M.T), C, inverse.T @ joint.g_q)


def null_space_wrench(joint: JointDynamics, qd: np.ndarray) -> np.ndarray:
    """h (6,) [N m; N] = ((J#)^T N - M Jdot) (I - J# J) qd of a redundant arm that also moves in its null space."""
    inverse = task_inverse(joint)
    M = inverse.T @ joint.B @ inverse
    idle = qd - inverse @ (joint.J @ qd)
    return (inverse.T @ joint.N - M @ joint.Jdot) @ idle if joint.J.shape[1] > 6 else np.zeros(6)


def _inertia_times_inverse_rate(joint: JointDynamics, inverse: np.ndarray, M: np.ndarray) -> np.ndarray:
    """(J#)^T B dJ#/dt (6, 6)."""
    if joint.J.shape[1] >= 6:  # (J#)^T B = M J, and J J# = I
        return -M @ joint.Jdot @ inverse
    out_of_range = np.eye(6) - joint.J @ inverse
    rate = -inverse @ joint.Jdot @ inverse + inverse @ inverse.T @ joint.Jdot.T @ out_of_range
    return inverse.T @ joint.B @ rate
