"""Damping by torques that stay for a time step."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.autodiffutils import AutoDiffXd, ExtractGradient, ExtractValue, InitializeAutoDiff

from drake_ltl.dynamics import MAX_GROWTH, HeldDamping, transition_torque, velocity_after

K = np.array([18.0, 18.0, 5.0])
LIMIT = 2.0
numbers = arrays(float, 3, elements=st.floats(-50.0, 50.0))
matrices = arrays(float, (3, 3), elements=st.floats(-2.0, 2.0))
steps = st.floats(1e-4, 0.05)


def inertia_of(root: np.ndarray) -> np.ndarray:
    return root @ root.T + 0.1 * np.eye(3)


def held(time_step: float, *, decay: float = 0.5) -> HeldDamping:
    return HeldDamping(K, LIMIT, time_step, mass=1.5, decay=decay)


@given(matrices, numbers, numbers, steps)
def test_the_velocity_is_that_after_the_step(root, gradient, qd, time_step):
    B = inertia_of(root)
    w = velocity_after(B, gradient, K, qd, time_step)
    force = transition_torque(np.zeros(3), gradient, K, w)
    np.testing.assert_allclose(B @ (w - qd), time_step * force, atol=1e-9 * (1.0 + np.abs(B @ qd).max()))


@given(matrices, matrices, numbers, numbers, steps)
def test_energy_never_rises_where_damping_outweighs_half_the_step_s_stiffness(root, slope, q, qd, time_step):
    """However stiff damping is for the inertia; psi = q^T H q / 2."""
    B, H = inertia_of(root), slope @ slope.T
    damping = K + time_step / 2.0 * np.linalg.norm(H, 2)
    w = velocity_after(B, H @ q, damping, qd, time_step)
    after = q + time_step * w
    energy, later = (0.5 * (p @ H @ p + v @ B @ v) for p, v in ((q, qd), (after, w)))
    assert later <= energy * (1.0 + 1e-12) + 1e-9


def test_the_velocity_before_the_step_makes_energy_rise_where_damping_is_stiff():
    B, qd, time_step = 0.02 * np.eye(3), np.ones(3), 0.01  # time_step * K = 9 B for x and y
    explicit = qd - time_step * np.linalg.solve(B, K * qd)
    implicit = velocity_after(B, np.zeros(3), K, qd, time_step)
    assert explicit @ B @ explicit > 10.0 * (qd @ B @ qd) > 10.0 * (implicit @ B @ implicit)


@given(numbers, arrays(float, 3, elements=st.floats(-1.0, 1.0)))
def test_what_is_slow_is_damped_by_10a(gradient, qd):
    """No inertia is asked for: gradients add at most 0.3 m/s here."""
    damping, velocity = held(0.005).at(gradient, qd, inertia=lambda: pytest.fail("not needed"))
    assert damping is K
    assert velocity is qd


@given(matrices, numbers, numbers)
def test_a_step_of_no_length_is_10a(root, gradient, qd):
    damping, velocity = held(0.0, decay=0.0).at(gradient, qd, lambda: inertia_of(root))
    assert velocity is qd
    assert np.all(damping >= K)
    assert np.all(damping <= MAX_GROWTH * K)
    at_once, short = (velocity_after(inertia_of(root), gradient, K, qd, step) for step in (0.0, 1e-9))
    np.testing.assert_allclose(at_once, qd, atol=1e-9)
    np.testing.assert_allclose(short, qd, atol=1e-4)  # forces of some 1000 N for 1e-9 s at inertias down to 0.1


@pytest.mark.parametrize(
    ("gradient", "qd", "decay"),
    [([0.0, 0.0, 0.0], [3.0, 0.0, 0.0], 0.5), ([900.0, 0.0, 0.0], [0.0] * 3, 0.5), ([0.0] * 3, [0.1] * 3, 1.1)],
)
def test_what_is_fast_or_about_to_be_or_stiff_is_damped_by_the_velocity_after(gradient, qd, decay):
    gradient, qd, B = np.array(gradient), np.array(qd), np.diag([1.5, 1.5, 0.2])
    damping, velocity = held(0.005, decay=decay).at(gradient, qd, lambda: B)
    np.testing.assert_allclose(velocity, velocity_after(B, gradient, damping, qd, 0.005))
    assert not np.array_equal(velocity, qd)
    assert np.all(damping > K) or decay > 1.0


def test_an_agent_is_stiff_for_steps_that_are_long_for_its_damping(models):
    model = models.agents["a1"]
    K_a1 = model.damping(18.0, 1.8)
    short, long = (HeldDamping.of(model, K_a1, LIMIT, step) for step in (0.005, 0.02))
    assert short.decay < 1.0 < long.decay
    assert short.mass == pytest.approx(model.inertia(np.ones(model.n))[0, 0])  # x moves all of it, in any posture


def test_derivatives_follow_the_state():
    """AutoDiffXd gives what finite differences give."""
    B, gradient, qd = np.diag([1.5, 1.4, 0.2]), np.array([300.0, -200.0, 3.0]), np.array([1.5, 2.0, -0.3])
    law = held(0.005)

    def velocity(speeds: np.ndarray) -> np.ndarray:
        inertia = np.vectorize(AutoDiffXd)(B) if speeds.dtype == object else B
        return law.at(gradient, speeds, lambda: inertia)[1]

    w = velocity(InitializeAutoDiff(qd).ravel())
    np.testing.assert_allclose(ExtractValue(w).ravel(), velocity(qd), rtol=1e-12)
    numeric = np.column_stack([(velocity(qd + h) - velocity(qd - h)) / 2e-6 for h in 1e-6 * np.eye(3)])
    np.testing.assert_allclose(ExtractGradient(w), numeric, atol=1e-6)
