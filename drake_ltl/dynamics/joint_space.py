"""Joint-space dynamics (1a) of one agent and the Jacobian of its end-effector, from a MultibodyPlant.

All functions take a plant of prismatic and revolute joints (so that v = qd) that holds the agent alone, and a context
with its q and qd, which they leave as it was. Plants of AutoDiffXd will do as well.

Drake offers the products N qd and Jdot qd, not the matrices. Both products are quadratic forms in qd, and a quadratic
form determines its symmetric bilinear form: b(v + e) - b(v - e) = 4 N(q, v) e. No derivatives of models are taken.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, JacobianWrtVariable
from pydrake.systems.framework import Context


@dataclass(frozen=True)
class JointDynamics:
    """B qdd + N qd + g_q = tau - J^T f, eq. (1a), at one state."""

    B: np.ndarray
    """(n, n), symmetric and positive definite."""
    N: np.ndarray
    """(n, n), with dB/dt - 2 N skew symmetric (Lemma 1)."""
    g_q: np.ndarray
    """(n,) [N, N m], the torque that balances gravity."""
    J: np.ndarray
    """J_i (6, n): V_WE = J qd, rows (rotational; translational) in W."""
    Jdot: np.ndarray
    """(6, n)."""


def joint_dynamics(plant: MultibodyPlant, context: Context, frame: Frame) -> JointDynamics:
    """Everything in (1a); `frame` is the end-effector's frame {E_i}."""
    return JointDynamics(
        B=inertia_matrix(plant, context),
        N=coriolis_matrix(plant, context),
        g_q=gravity_torque(plant, context),
        J=frame_jacobian(plant, context, frame),
        Jdot=frame_jacobian_rate(plant, context, frame),
    )


def inertia_matrix(plant: MultibodyPlant, context: Context) -> np.ndarray:
    """B(q) (n, n) of (1a)."""
    return plant.CalcMassMatrix(context)


def gravity_torque(plant: MultibodyPlant, context: Context) -> np.ndarray:
    """g_q(q) (n,) [N, N m] of (1a)."""
    return -plant.CalcGravityGeneralizedForces(context)


def coriolis_matrix(plant: MultibodyPlant, context: Context) -> np.ndarray:
    """N(q, qd) (n, n) of (1a), formed with Christoffel's symbols, as Lemma 1 needs it.

    N_kj = sum_i Gamma_ijk qd_i, Gamma_ijk = (dB_kj/dq_i + dB_ki/dq_j - dB_ij/dq_k) / 2 (Siciliano et al. 2010,
    eqs. 7.44, 7.45). The symbols are symmetric in i and j: N is the symmetric bilinear form of the bias N qd.
    """
    return _symmetric_form(plant, context, lambda: plant.CalcBiasTerm(context))


def frame_jacobian(plant: MultibodyPlant, context: Context, frame: Frame) -> np.ndarray:
    """J_i(q) (6, n): V_WE = J qd, rows (rotational; translational) in W."""
    world = plant.world_frame()
    return plant.CalcJacobianSpatialVelocity(context, JacobianWrtVariable.kV, frame, np.zeros(3), world, world)


def frame_jacobian_rate(plant: MultibodyPlant, context: Context, frame: Frame) -> np.ndarray:
    """d J_i / dt (6, n).

    Its translational rows are second derivatives of a position and so a symmetric form of the bias. The rotational
    ones are not: d J_k/dq_i - d J_i/dq_k = J_i x J_k (rotations do not commute), which adds omega x J / 2.
    """
    world = plant.world_frame()

    def bias() -> np.ndarray:
        A = plant.CalcBiasSpatialAcceleration(context, JacobianWrtVariable.kV, frame, np.zeros(3), world, world)
        return A.get_coeffs()

    rate = _symmetric_form(plant, context, bias)
    J = frame_jacobian(plant, context, frame)[:3]
    w_WE = J @ plant.GetVelocities(context)
    rate[:3] += 0.5 * np.cross(w_WE, J, axisb=0, axisc=0)
    return rate


def _symmetric_form(plant: MultibodyPlant, context: Context, quadratic: Callable[[], np.ndarray]) -> np.ndarray:
    """The matrix (m, n) of w -> b(qd, w), b symmetric and bilinear, from the quadratic form v -> b(v, v) (m,)."""
    v = plant.GetVelocities(context)
    columns = []
    with _velocities_kept(plant, context):
        for e in np.eye(len(v)):
            plant.SetVelocities(context, v + e)
            ahead = quadratic()
            plant.SetVelocities(context, v - e)
            columns.append(0.25 * (ahead - quadratic()))
    return np.stack(columns, axis=1)


@contextmanager
def _velocities_kept(plant: MultibodyPlant, context: Context) -> Iterator[None]:
    v = plant.GetVelocities(context)
    try:
        yield
    finally:
        plant.SetVelocities(context, v)
