"""The coupled dynamics (7) of an object and its team: on solved constraints, on simulated transports, and Lemma 1."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drake_ltl.dynamics import (
    admissible_twists,
    coupled_dynamics,
    frame_jacobian,
    grasp_matrix,
    grasp_matrix_rate,
    null_space_wrench,
    object_dynamics,
    object_to_agent_jacobian,
    object_to_agent_jacobian_rate,
    task_dynamics,
    task_inverse,
)

TEAMS = [(6, 6), (7, 6), (7, 7, 6)]
MASS, INERTIA = 0.8, np.array([[0.05, 0.004, -0.003], [0.004, 0.06, 0.002], [-0.003, 0.002, 0.04]])
POSTURES = {6: [0.3, 0.7, 0.9, 0.2], 7: [0.3, 0.5, 0.6, 0.5, 0.2]}


def random_team(solo, joints, rng):
    """A state with a rigid grasp: any grippers, any twist of the object, joints that follow (and idle as they like)."""
    R = Rotation.random(random_state=rng).as_matrix()
    V = rng.uniform(-1.0, 1.0, 6)
    offsets = [rng.uniform(-0.4, 0.4, 3) for _ in joints]
    members = []
    for n, p in zip(joints, offsets, strict=True):
        q = np.array([0.0, 0.0, *POSTURES[n]]) + rng.uniform(-0.2, 0.2, n)
        at_rest = solo(n).dynamics(q, np.zeros(n))
        inverse, idle = task_inverse(at_rest), rng.uniform(-1.0, 1.0, n)
        qd = inverse @ (object_to_agent_jacobian(p) @ V) + idle - inverse @ (at_rest.J @ idle)
        members.append((solo(n).dynamics(q, qd), q, qd))
    return R, V, offsets, members


def coupled(R, V, offsets, dynamics):
    body = object_dynamics(MASS, INERTIA, R, V[:3])
    return coupled_dynamics(body, [task_dynamics(joint) for joint in dynamics], offsets, V[:3])


@pytest.mark.parametrize("joints", TEAMS)
def test_coupled_dynamics_are_those_of_the_constrained_bodies(solo, joints):
    """An oracle that knows no (7): all bodies with rigid constraints, solved by Lagrange's multipliers."""
    rng = np.random.default_rng(7)
    for _ in range(5):
        R, V, offsets, members = random_team(solo, joints, rng)
        u = [rng.uniform(-5.0, 5.0, 6) for _ in members]
        vdot = constrained_acceleration(R, V, offsets, members, u)
        idle = np.concatenate([null_space_wrench(joint, qd) for joint, _, qd in members])
        G = grasp_matrix(offsets)
        left = coupled(R, V, offsets, [joint for joint, _, _ in members]).wrench(vdot, V)
        np.testing.assert_allclose(left + G.T @ idle, G.T @ np.concatenate(u), atol=1e-8)  # inverses lose 1e6 of 1e-16
        assert (np.abs(idle).max() > 1e-2) == (7 in joints)  # what the paper leaves out is there


def constrained_acceleration(R, V, offsets, members, u) -> np.ndarray:
    """vdot_O (6,) from (1a) of each arm, Newton and Euler for the object, and equal accelerations at the grippers."""
    sizes = [len(qd) for _, _, qd in members]
    n, m = sum(sizes) + 6, 6 * len(members)
    inertia, rest, pull = np.zeros((n, n)), np.zeros(n), np.zeros((m, n))
    gap, start = np.zeros(m), 0
    for k, ((joint, _, qd), p, wrench) in enumerate(zip(members, offsets, u, strict=True)):
        own, rows = slice(start, start + len(qd)), slice(6 * k, 6 * k + 6)
        inertia[own, own] = joint.B
        rest[own] = joint.J.T @ wrench - joint.N @ qd - joint.g_q
        pull[rows, own] = joint.J
        pull[rows, -6:] = -object_to_agent_jacobian(p)
        centripetal = np.concatenate([np.zeros(3), np.cross(V[:3], np.cross(V[:3], p))])
        gap[rows] = centripetal - joint.Jdot @ qd
        start += len(qd)
    I_W = R @ INERTIA @ R.T
    inertia[-6:-3, -6:-3], inertia[-3:, -3:] = I_W, MASS * np.eye(3)
    rest[-6:-3], rest[-1] = -np.cross(V[:3], I_W @ V[:3]), -MASS * 9.81
    system = np.block([[inertia, pull.T], [pull, np.zeros((m, m))]])
    return np.linalg.solve(system, np.concatenate([rest, gap]))[n - 6 : n]


@pytest.mark.parametrize("joints", TEAMS)
def test_inertia_is_definite_and_its_rate_less_twice_coriolis_is_skew(solo, joints):
    """Lemma 1 for M~; the rate by central differences along the motion."""
    rng = np.random.default_rng(5)
    h = 1e-5
    for _ in range(4):
        R, V, offsets, members = random_team(solo, joints, rng)

        def inertia(s: float, R=R, V=V, offsets=offsets, members=members) -> np.ndarray:
            turn = Rotation.from_rotvec(s * V[:3]).as_matrix()
            moved = [solo(len(q)).dynamics(q + s * qd, qd) for _, q, qd in members]
            return coupled(turn @ R, V, [turn @ p for p in offsets], moved).M

        now = coupled(R, V, offsets, [joint for joint, _, _ in members])
        np.testing.assert_allclose(now.M, now.M.T, atol=1e-10)
        assert np.linalg.eigvalsh(now.M)[0] > 0.035  # never less than the crate's own
        S = (inertia(h) - inertia(-h)) / (2.0 * h) - 2.0 * now.C
        assert np.abs(S).max() > 0.1
        np.testing.assert_allclose(S, -S.T, atol=1e-6 * np.abs(S).max())  # h^2 times third derivatives, rounding over h


def test_arms_of_four_joints_make_the_inertia_definite_too(solo):
    """The object's own inertia fills what two planar arms leave out; C~ keeps Lemma 1."""
    rng = np.random.default_rng(2)
    arm, h = solo(4), 1e-5
    V, offsets = np.array([0, 0, 0, 0.5, -0.3, 0.2]), [np.array([-0.3, 0.0, 0.15]), np.array([0.15, 0.26, 0.15])]
    states = [(np.array([0, 0, 0.9, 0.6]) + rng.uniform(-0.2, 0.2, 4), rng.uniform(-1, 1, 4)) for _ in offsets]

    def team(s: float):
        moved = [arm.dynamics(q + s * qd, qd) for q, qd in states]
        return coupled(np.eye(3), V, offsets, moved)

    now = team(0.0)
    assert np.linalg.eigvalsh(now.M)[0] > 0.035
    S = (team(h).M - team(-h).M) / (2.0 * h) - 2.0 * now.C
    np.testing.assert_allclose(S, -S.T, atol=1e-6 * np.abs(S).max())


@pytest.mark.parametrize("joints", TEAMS)
def test_coupled_dynamics_hold_on_simulated_transports(transport, joints):
    """(7) with accelerations by differences. Drake's step keeps velocities, not accelerations, of grippers equal:
    between both lie the changes of the Jacobians within a step, so the residual is of first order in dt."""
    power = (1.0, 3.0, 2.0)[: len(joints)]
    coarse, fine = (transport(joints, power, dt, 0.3, 0.02) for dt in (2e-3, 5e-4))
    inertial = max(np.abs(s.coupled.M @ s.A_WO).max() for s in fine)
    assert inertial > 10.0  # it moves in earnest
    assert residual(fine) < 3e-3 * inertial
    assert residual(fine) < 0.4 * residual(coarse)  # a quarter, if of first order
    assert max(np.abs(s.V_WO[:3]).max() for s in fine) > 0.3  # and turns [rad/s]


def residual(samples) -> float:
    return max(np.abs(s.residual).max() for s in samples)


def test_object_dynamics_are_newton_and_euler_s():
    rng = np.random.default_rng(4)
    R, v, vdot = Rotation.random(random_state=1).as_matrix(), rng.normal(size=6), rng.normal(size=6)
    I_W = R @ INERTIA @ R.T
    wrench = object_dynamics(MASS, INERTIA, R, v[:3]).wrench(vdot, v)
    np.testing.assert_allclose(wrench[:3], I_W @ vdot[:3] + np.cross(v[:3], I_W @ v[:3]), atol=1e-12)
    np.testing.assert_allclose(wrench[3:], MASS * (vdot[3:] + 9.81 * np.eye(3)[2]), atol=1e-12)


def test_rates_of_the_grasp_are_its_derivatives():
    p, w, h = np.array([0.3, -0.2, 0.1]), np.array([0.5, -1.0, 2.0]), 1e-6
    ahead, behind = (object_to_agent_jacobian(Rotation.from_rotvec(s * w).apply(p)) for s in (h, -h))
    rate = object_to_agent_jacobian_rate(p, w)
    np.testing.assert_allclose(rate, (ahead - behind) / (2.0 * h), atol=1e-9)  # rounding over h
    np.testing.assert_array_equal(grasp_matrix_rate([p, p], w), np.concatenate([rate, rate]))


def test_admissible_twists_of_planar_arms(arm_plant):
    """One planar arm: translations and a turn in its plane; two of different headings: translations alone."""
    p = np.array([-0.3, 0.0, 0.15])
    jacobians = []
    for heading in (0.0, 2.1):
        plant = arm_plant(heading)
        context = plant.CreateDefaultContext()
        plant.SetPositions(context, [0.0, 0.0, 1.2, 0.3])
        jacobians.append(_jacobian(plant, context))
    alone = admissible_twists(jacobians[:1], [p])
    assert alone.shape == (6, 4)
    both = admissible_twists(jacobians, [p, p])
    assert both.shape == (6, 3)
    np.testing.assert_allclose(both[:3], 0.0, atol=1e-9)
    np.testing.assert_allclose(both.T @ both, np.eye(3), atol=1e-12)


def test_arms_of_six_joints_follow_every_twist():
    rng = np.random.default_rng(0)
    np.testing.assert_array_equal(admissible_twists([rng.normal(size=(6, 6))], [np.ones(3)]), np.eye(6))


def _jacobian(plant, context):
    return frame_jacobian(plant, context, plant.GetFrameByName("grasp"))
