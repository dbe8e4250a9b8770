"""The spring of redundant arms: a potential with a slope, zero where it rests, steep at the limits; V falls with it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.autodiffutils import ExtractValue, InitializeAutoDiff

from drake_ltl.dynamics.null_space import EDGE, SHORTFALL, PostureSpring, null_space_projector
from drake_ltl.multibody import AgentModel
from drake_ltl.scenario.model import Agent
from drake_ltl.systems.posture_springs import posture_spring
from drake_ltl.verification.postures import posture_energy

STEP = 1e-6
REST = np.array([0.5, -0.3, 0.2, 0.1, 0.1, -0.2, 0.05, 0.1, -0.05])
offsets = arrays(float, 9, elements=st.floats(-0.5, 0.5))
rates = arrays(float, 9, elements=st.floats(-2.0, 2.0))


@pytest.fixture(scope="module")
def robot() -> AgentModel:
    model = "package://drake_ltl_models/agents/mobile_manipulator.urdf"
    return AgentModel(Agent("a1", model, (0.0, 0.0), 0.0, power=1.0))


@pytest.fixture(scope="module")
def spring(robot) -> PostureSpring:
    return posture_spring(robot, REST)


def energy(robot, spring, q) -> float:
    return spring.energy(q, robot.grasp_jacobian(q))


@given(offset=offsets)
def test_torque_is_the_slope_of_the_energy(robot, spring, offset):
    q = REST + offset
    tau = spring.torque(q, np.zeros(9), robot.grasp_jacobian(q))
    slope = [
        (energy(robot, spring, q + STEP * e) - energy(robot, spring, q - STEP * e)) / (2 * STEP) for e in np.eye(9)
    ]
    # relative to forces of a hundred newtons; the barrier's second derivatives are some 1e3
    np.testing.assert_allclose(tau, -np.array(slope), rtol=1e-5, atol=1e-4)


def test_at_rest_there_is_nothing(robot, spring):
    assert energy(robot, spring, REST) == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(spring.torque(REST, np.zeros(9), robot.grasp_jacobian(REST)), 0.0, atol=1e-12)


@given(offset=offsets, shift=arrays(float, 2, elements=st.floats(-20.0, 20.0)))
def test_energy_is_not_negative_and_the_same_everywhere(robot, spring, offset, shift):
    """The base's x and y do not matter: a whole team may be shifted, and no force acts on x and y."""
    q = REST + offset
    h = energy(robot, spring, q)
    assert h >= -1e-12
    moved = q + np.concatenate([shift, np.zeros(7)])
    assert energy(robot, spring, moved) == pytest.approx(h, rel=1e-9, abs=1e-9)
    np.testing.assert_allclose(spring.torque(moved, np.zeros(9), robot.grasp_jacobian(moved))[:2], 0.0, atol=1e-9)


@pytest.mark.parametrize("joint", range(3, 9))
def test_energy_grows_at_the_limits(robot, spring, joint):
    """Far steeper than a plain spring, and a number even beyond them."""
    upper = spring.upper[joint]
    levels, forces = [], []
    for share in (0.9, 0.99, EDGE, 1.1):
        q = REST.copy()
        q[joint] = share * upper
        levels.append(energy(robot, spring, q))
        forces.append(-spring.torque(q, np.zeros(9), robot.grasp_jacobian(q))[joint])
    assert np.all(np.isfinite(levels))
    assert np.all(np.diff(levels) > 0.0)
    assert forces[2] > 5.0 * spring.stiffness[joint] * (upper - REST[joint])
    assert forces[3] > forces[2]


def test_it_leads_away_from_singularities(robot):
    """Of a spring without stiffness only that is left; it acts below SHORTFALL of the reference's manipulability."""
    zero = np.zeros(9)
    spring = PostureSpring(REST, zero, zero, np.full(9, -np.inf), np.full(9, np.inf), robot.manipulability(REST))
    q = REST.copy()
    q[7] = -2.0  # far beyond the wrist's limits: nothing else is as singular
    q[5] = -1.25  # the elbow straight
    while robot.manipulability(q) > SHORTFALL * spring.manipulability:
        spring = PostureSpring(REST, zero, zero, spring.lower, spring.upper, 2.0 * spring.manipulability)
    J = robot.grasp_jacobian(q)
    assert spring.energy(q, J) > 0.0
    ahead = q + 1e-4 * spring.torque(q, zero, J)
    assert robot.manipulability(ahead) > robot.manipulability(q)


@given(offset=offsets, qd=rates)
def test_friction_takes_energy(robot, spring, offset, qd):
    q = REST + offset
    J = robot.grasp_jacobian(q)
    friction = spring.torque(q, qd, J) - spring.torque(q, np.zeros(9), J)
    assert friction @ qd <= 1e-12


def test_torque_of_autodiff(robot, spring):
    """The value is that of floats; the derivatives by the joints' velocities are the friction."""
    q, qd = REST + 0.3, np.full(9, 0.4)
    J = robot.grasp_jacobian(q)
    x = InitializeAutoDiff(np.concatenate([q, qd])).ravel()
    tau = spring.torque(x[:9], x[9:], J + 0.0 * x[0])
    # x, y and yaw have no spring: what is left there are rounding errors of the rest, tens of N m
    np.testing.assert_allclose(ExtractValue(tau).ravel(), spring.torque(q, qd, J), rtol=1e-9, atol=1e-12)
    slopes = np.array([t.derivatives()[9:] for t in tau])
    np.testing.assert_allclose(slopes, -np.diag(spring.damping), atol=1e-12)


@given(offset=offsets)
def test_projected_torques_do_not_accelerate_the_gripper(robot, offset):
    q = REST + offset
    J, B = robot.grasp_jacobian(q), robot.inertia(q)
    N = null_space_projector(J, B)
    np.testing.assert_allclose(J @ np.linalg.solve(B, N), 0.0, atol=1e-7)  # of entries up to 50 / kg m^2
    np.testing.assert_allclose(N @ N, N, atol=1e-7)
    assert np.linalg.matrix_rank(N, tol=1e-6) == 3


@given(offset=arrays(float, 9, elements=st.floats(-3.0, 3.0)))
def test_verdicts_form_the_same_energy(robot, spring, offset):
    """Written by another hand; far beyond the limits of joints as well."""
    q = np.array([REST, REST + offset])
    h = posture_energy(robot, q, 0, np.array([0, 1]))
    assert h[0] == pytest.approx(0.0, abs=1e-12)
    assert h[1] == pytest.approx(energy(robot, spring, q[1]), rel=1e-9, abs=1e-9)
