"""Grasp kinematics, load sharing and control laws as pure functions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from drake_ltl.dynamics import (
    grasp_matrix,
    growing_damping,
    load_shares,
    object_to_agent_jacobian,
    quintic,
    skew,
    team_wrench,
    tracking_acceleration,
    transition_torque,
    transport_torque,
    wrench_at_gripper,
)

numbers = st.floats(-10.0, 10.0)
vector3 = arrays(float, 3, elements=numbers)
vector6 = arrays(float, 6, elements=numbers)
ROUNDING = 1e-10  # products of numbers up to 10, sums of a dozen of them


@given(vector3, vector3)
def test_skew_is_the_cross_product(x, y):
    np.testing.assert_allclose(skew(x) @ y, np.cross(x, y), atol=ROUNDING)


@given(vector3, vector6)
def test_jacobian_moves_a_twist_to_the_gripper(p, V):
    moved = object_to_agent_jacobian(p) @ V
    np.testing.assert_allclose(moved[:3], V[:3], atol=ROUNDING)
    np.testing.assert_allclose(moved[3:], V[3:] + np.cross(V[:3], p), atol=ROUNDING)


@given(vector3, vector6, vector6)
def test_wrench_at_the_gripper_does_the_same_work(p, F, V):
    """F_E . V_E = F_O . V_O: the duality behind (10b), and J_O^{-T} without an inverse."""
    F_E = wrench_at_gripper(F, p)
    assert F_E @ (object_to_agent_jacobian(p) @ V) == pytest.approx(F @ V, abs=1e-8)
    np.testing.assert_allclose(object_to_agent_jacobian(p).T @ F_E, F, atol=1e-8)


@given(st.lists(vector3, min_size=1, max_size=4), vector6, st.data())
def test_shared_wrenches_add_up_to_the_team_s(offsets, F, data):
    power = data.draw(st.lists(st.floats(0.1, 10.0), min_size=len(offsets), max_size=len(offsets)))
    shares = load_shares(power)
    stacked = np.concatenate([wrench_at_gripper(c * F, p) for c, p in zip(shares, offsets, strict=True)])
    np.testing.assert_allclose(grasp_matrix(offsets).T @ stacked, F, atol=1e-8)


def test_transition_torque_is_10a():
    tau = transition_torque(np.array([1.0, 2.0]), np.array([0.5, -1.0]), np.array([3.0, 4.0]), np.array([1.0, 0.5]))
    np.testing.assert_allclose(tau, [1.0 - 0.5 - 3.0, 2.0 + 1.0 - 2.0])


def test_transport_torque_does_the_team_s_work():
    """qd . tau = share * F_O . V_O + qd . g_q for joints that move with the object."""
    rng = np.random.default_rng(1)
    J_WE, gravity, F, p = rng.normal(size=(6, 6)), rng.normal(size=6), rng.normal(size=6), rng.normal(size=3)
    V_WO = rng.normal(size=6)
    qd = np.linalg.solve(J_WE, object_to_agent_jacobian(p) @ V_WO)
    power = qd @ transport_torque(0.3, F, p, J_WE, gravity)
    assert power == pytest.approx(0.3 * F @ V_WO + qd @ gravity, abs=1e-9)


def test_team_wrench_opposes_gradient_and_velocity():
    F = team_wrench(np.zeros(6), np.ones(6), np.full(6, 2.0), np.full(6, 3.0))
    np.testing.assert_allclose(F, -7.0)


@given(st.floats(0.0, 100.0), st.floats(0.1, 10.0))
def test_damping_never_falls_and_is_bounded(speed, limit):
    damping = np.array([1.0, 2.0])
    grown = growing_damping(damping, speed, limit)
    assert np.all(grown >= damping)
    assert np.all(grown <= 8.0 * damping)
    assert speed > limit or np.array_equal(grown, damping)


@given(st.floats(0.1, 10.0), vector3, vector3)
def test_quintic_starts_and_ends_at_rest(duration, start, goal):
    for t, at in ((-1.0, start), (0.0, start), (duration, goal), (2.0 * duration, goal)):
        position, velocity, acceleration = quintic(t, duration, start, goal)
        np.testing.assert_allclose(position, at, atol=ROUNDING)
        np.testing.assert_allclose(velocity, 0.0, atol=ROUNDING)
        np.testing.assert_allclose(acceleration, 0.0, atol=1e-6)  # 60 * 20 / 0.1^2 times rounding


def test_quintic_derivatives_are_those_of_its_position():
    start, goal, h = np.array([0.0, 1.0]), np.array([2.0, -1.0]), 1e-5
    for t in (0.2, 0.7, 1.3):
        ahead, behind = quintic(t + h, 1.5, start, goal), quintic(t - h, 1.5, start, goal)
        _, velocity, acceleration = quintic(t, 1.5, start, goal)
        np.testing.assert_allclose((ahead[0] - behind[0]) / (2 * h), velocity, atol=1e-8)
        np.testing.assert_allclose((ahead[1] - behind[1]) / (2 * h), acceleration, atol=1e-7)


def test_tracking_error_decays_critically():
    """The double integrator under the law follows e(t) = (1 + w t) exp(-w t) e(0)."""
    w, dt, q, qd = 5.0, 1e-4, np.array([1.0]), np.array([0.0])
    for _ in range(10_000):
        qd = qd + dt * tracking_acceleration(q, qd, np.zeros(1), np.zeros(1), np.zeros(1), w)
        q = q + dt * qd
    assert q[0] == pytest.approx((1.0 + w) * np.exp(-w), abs=1e-4)  # Euler at dt w = 5e-4
