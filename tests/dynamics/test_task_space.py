"""M, C, g of (1b) for arms with fewer joints than six, with six, and with more."""

from __future__ import annotations

import numpy as np
import pytest

from drake_ltl.dynamics import JointDynamics, null_space_wrench, task_dynamics, task_inverse

JOINTS = (4, 5, 6, 7)
ROUNDING = 1e-7  # the smallest singular values of J are about 0.1: M has entries of 1e2, and inverses lose 1e4


@pytest.fixture(params=JOINTS, ids=lambda n: f"{n} joints")
def arm(request, solo):
    return solo(request.param)


def states(n: int, count: int = 4):
    """Away from singularities: the elbows bent."""
    rng = np.random.default_rng(n)
    bent = {4: [0.8, 0.7], 5: [0.3, 0.7, 0.9], 6: [0.3, 0.7, 0.9, 0.2], 7: [0.3, 0.5, 0.6, 0.5, 0.2]}[n]
    centre = np.array([*([0.0] * (n - len(bent))), *bent])
    return [(centre + rng.uniform(-0.2, 0.2, n), rng.uniform(-2.0, 2.0, n)) for _ in range(count)]


def test_task_space_follows_from_joint_space(arm):
    """(1a) with any torque and contact wrench gives a motion that obeys (1b), for u with tau = J^T u + tau_0.

    With fewer than six joints it does so within the range of J; null-space torques tau_0 of the paper (projected by
    the dynamically consistent inverse) move nothing.
    """
    rng = np.random.default_rng(1)
    for q, qd in states(arm.plant.num_positions()):
        joint = arm.dynamics(q, qd)
        inverse = task_inverse(joint)
        u, f, tau_0 = rng.normal(size=6), rng.normal(size=6), rng.normal(size=len(q))
        tau = joint.J.T @ u + (tau_0 - joint.J.T @ (inverse.T @ tau_0) if len(q) > 6 else 0.0)
        qdd = np.linalg.solve(joint.B, tau - joint.J.T @ f - joint.N @ qd - joint.g_q)
        v, vdot = joint.J @ qd, joint.J @ qdd + joint.Jdot @ qd
        left = task_dynamics(joint).wrench(vdot, v) + null_space_wrench(joint, qd)
        within = joint.J @ inverse  # the identity for n >= 6
        np.testing.assert_allclose(within.T @ left, within.T @ (u - f), atol=ROUNDING)


def test_inertia_is_the_paper_s(solo):
    for n in (6, 7):
        q, qd = states(n)[0]
        joint = solo(n).dynamics(q, qd)
        expected = np.linalg.inv(joint.J @ np.linalg.inv(joint.B) @ joint.J.T)
        np.testing.assert_allclose(task_dynamics(joint).M, expected, rtol=1e-9, atol=1e-10)


def test_kinetic_energy_is_that_of_the_joints(arm):
    """For motions without any in the null space: qd = J# v."""
    for q, qd in states(arm.plant.num_positions()):
        joint = arm.dynamics(q, qd)
        v = joint.J @ qd
        moved = task_inverse(joint) @ v
        assert v @ task_dynamics(joint).M @ v == pytest.approx(moved @ joint.B @ moved, rel=1e-9)


def test_inertia_is_symmetric_and_as_definite_as_joints_allow(arm):
    n = arm.plant.num_positions()
    for q, qd in states(n):
        M = task_dynamics(arm.dynamics(q, qd)).M
        np.testing.assert_array_equal(M, M.T)
        values = np.linalg.eigvalsh(M)
        assert np.all(values[-min(n, 6) :] > 1e-4)
        np.testing.assert_allclose(values[: -min(n, 6)], 0.0, atol=1e-12)


def test_rate_of_inertia_less_twice_coriolis_is_skew(arm):
    """The rate by central differences of the motion q + t qd."""
    h = 1e-5
    for q, qd in states(arm.plant.num_positions()):
        ahead, behind = (task_dynamics(arm.dynamics(q + s * qd, qd)).M for s in (h, -h))
        S = (ahead - behind) / (2.0 * h) - 2.0 * task_dynamics(arm.dynamics(q, qd)).C
        scale = np.abs(S).max()
        assert scale > 1e-2
        np.testing.assert_allclose(S, -S.T, atol=1e-6 * scale)  # h^2 times third derivatives, and rounding over h


def test_null_space_motion_counts_for_redundant_arms_alone(solo):
    rng = np.random.default_rng(3)
    for n in JOINTS:
        q, qd = states(n)[0]
        joint = solo(n).dynamics(q, qd)
        size = np.abs(null_space_wrench(joint, qd)).max()
        assert (size > 1e-3) == (n > 6)
        moved = task_inverse(joint) @ joint.J @ rng.normal(size=n)
        np.testing.assert_allclose(null_space_wrench(joint, moved), 0.0, atol=1e-9)


def test_a_singularity_is_named():
    """Link 2 in line with link 1 upright: J loses a rank."""
    J = np.diag([1.0, 1.0, 1.0, 1.0, 1.0, 0.0])
    joint = JointDynamics(np.eye(6), np.zeros((6, 6)), np.zeros(6), J, np.zeros((6, 6)))
    with pytest.raises(ValueError, match="kinematic singularity"):
        task_dynamics(joint)
