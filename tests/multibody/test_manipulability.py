"""Manipulability and its slope, against determinants and differences."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.autodiffutils import AutoDiffXd, ExtractValue, InitializeAutoDiff

from drake_ltl.multibody import AgentModel
from drake_ltl.multibody.manipulability import jacobian_slopes, log_manipulability_slope, manipulability

STEP = 1e-6
MODELS = {9: "mobile_manipulator", 10: "mobile_manipulator_7"}
postures = st.sampled_from(sorted(MODELS)).flatmap(lambda n: arrays(float, n, elements=st.floats(-0.35, 0.35)))


@pytest.fixture(scope="module")
def robots(make_agent) -> dict[int, AgentModel]:
    return {n: AgentModel(make_agent(model=f"package://drake_ltl_models/agents/{m}.urdf")) for n, m in MODELS.items()}


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(6, 9))
def test_manipulability_is_a_determinant(seed, n):
    J = np.random.default_rng(seed).uniform(-2.0, 2.0, size=(6, n))
    assert manipulability(J) ** 2 == pytest.approx(np.linalg.det(J @ J.T), rel=1e-6, abs=1e-9)


def test_manipulability_of_few_joints(make_agent):
    """The planar arm: sin q1 = 0 is its only singularity."""
    arm = AgentModel(make_agent())
    assert arm.manipulability(np.array([3.0, 1.0, 0.0, 0.7])) == pytest.approx(0.0, abs=1e-12)
    assert arm.manipulability(np.array([3.0, 1.0, 1.2, 0.3])) > 0.5


@given(q=postures)
def test_slopes_of_the_jacobian(robots, q):
    robot = robots[len(q)]
    slopes = jacobian_slopes(robot.grasp_jacobian(q))
    for j, e in enumerate(np.eye(len(q))):
        change = (robot.grasp_jacobian(q + STEP * e) - robot.grasp_jacobian(q - STEP * e)) / (2 * STEP)
        np.testing.assert_allclose(slopes[:, :, j], change, atol=1e-8)


@given(q=postures)
def test_slope_of_manipulability(robots, q):
    robot = robots[len(q)]
    slope = log_manipulability_slope(robot.grasp_jacobian(q))
    change = [
        np.log(robot.manipulability(q + STEP * e) / robot.manipulability(q - STEP * e)) / (2 * STEP)
        for e in np.eye(len(q))
    ]
    np.testing.assert_allclose(slope, change, atol=1e-6)


def test_slope_of_manipulability_of_autodiff(robots):
    J = robots[9].grasp_jacobian(np.full(9, 0.2))
    slope = log_manipulability_slope(InitializeAutoDiff(J.reshape(-1, 1)).reshape(J.shape))
    assert isinstance(slope[0], AutoDiffXd)
    np.testing.assert_allclose(ExtractValue(slope).ravel(), log_manipulability_slope(J), atol=1e-12)
