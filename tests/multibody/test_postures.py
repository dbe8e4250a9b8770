"""Grasp configurations by inverse kinematics."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.math import RigidTransform, RollPitchYaw

from drake_ltl.multibody import AgentModel
from drake_ltl.multibody.object_model import ObjectModel
from drake_ltl.multibody.postures import comfort, grasp_configurations, pose_error, solve_grasp

angles = arrays(float, 3, elements=st.floats(-3.0, 3.0))


@pytest.fixture(scope="module")
def crate(make_object) -> ObjectModel:
    return ObjectModel(make_object())


@pytest.mark.parametrize("heading", [0.0, 0.3, 2.0944, -1.7, np.pi])
def test_every_configuration_meets_its_frame(make_agent, crate, heading):
    model = AgentModel(make_agent(heading))
    found = grasp_configurations(model, crate.X_OG, crate.height)
    assert [grasp.name for grasp in found] == ["plus", "minus"]
    e = np.array([np.cos(heading), np.sin(heading), 0.0])
    for grasp, sign in zip(found, (1.0, -1.0), strict=True):
        X_WG = RigidTransform([0.0, 0.0, crate.height]) @ grasp.X_OE
        X_WE = model.grasp_pose(grasp.q)
        assert np.linalg.norm(X_WE.translation() - X_WG.translation()) <= 1e-5
        assert X_WE.rotation().inverse().multiply(X_WG.rotation()).ToAngleAxis().angle() <= 1e-4
        # reaching along the heading, from the other side, on the handle
        np.testing.assert_allclose(X_WE.rotation().matrix()[:, 2], sign * e, atol=1e-4)
        np.testing.assert_allclose(grasp.X_OE.translation(), -sign * 0.3 * e + [0, 0, 0.15], atol=1e-9)
        assert np.dot(grasp.q[:2], sign * e[:2]) < -2.0
        lower, upper = model.plant.GetPositionLowerLimits(), model.plant.GetPositionUpperLimits()
        assert np.all((grasp.q >= lower) & (grasp.q <= upper))


def test_the_ring_s_frame_may_be_turned(make_agent, crate):
    """X_OE is the ring's frame at the agent's azimuth, or half a turn of the gripper off it."""
    model = AgentModel(make_agent(0.5))
    for grasp in grasp_configurations(model, crate.X_OG, crate.height):
        azimuth = 0.5 + (np.pi if grasp.name == "plus" else 0.0)
        X_OR = RigidTransform(RollPitchYaw(0, 0, azimuth), np.zeros(3)) @ crate.X_OG
        X_RE = X_OR.inverse() @ grasp.X_OE
        np.testing.assert_allclose(X_RE.translation(), 0.0, atol=1e-9)
        np.testing.assert_allclose(np.abs(X_RE.rotation().matrix()), np.eye(3), atol=1e-9)
        assert X_RE.rotation().matrix()[2, 2] == pytest.approx(1.0)


@given(place=arrays(float, 2, elements=st.floats(-20.0, 20.0)), height=st.floats(0.3, 0.9))
def test_level_grasps_anywhere(case_model, place, height):
    X_WE = RigidTransform(RollPitchYaw(0.0, np.pi / 2, 0.0), [*place, height])
    q = solve_grasp(case_model, X_WE)
    assert q is not None
    np.testing.assert_allclose(case_model.grasp_pose(q).translation(), X_WE.translation(), atol=1e-5)


@pytest.fixture(scope="module")
def case_model(make_agent) -> AgentModel:
    return AgentModel(make_agent(0.0))


@pytest.mark.parametrize("name", ["mobile_manipulator", "mobile_manipulator_7"])
@pytest.mark.parametrize("heading", [0.0, 2.0944, -2.5])
def test_redundant_arms_grasp_at_ease(make_agent, crate, name, heading):
    """Along the heading, far from limits and singularities, and nothing nearby is better."""
    model = AgentModel(make_agent(heading, model=f"package://drake_ltl_models/agents/{name}.urdf"))
    found = grasp_configurations(model, crate.X_OG, crate.height)
    assert [grasp.name for grasp in found] == ["plus", "minus"]
    lower, upper = model.arm_limits
    rng = np.random.default_rng(0)
    for grasp, sign in zip(found, (1.0, -1.0), strict=True):
        X_WE = RigidTransform([0.0, 0.0, crate.height]) @ grasp.X_OE
        assert np.linalg.norm(pose_error(model.grasp_pose(grasp.q), X_WE)) <= 1e-4
        e = [np.cos(heading), np.sin(heading), 0.0]
        np.testing.assert_allclose(X_WE.rotation().matrix()[:, 2], np.multiply(sign, e), atol=1e-9)
        arm = grasp.q[3:]
        assert np.all((arm > lower[1:] + 0.1) & (arm < upper[1:] - 0.1))  # [rad]
        assert model.manipulability(grasp.q) > 1.0
        # self-motions, to first order: comfort has its maximum there
        J = model.grasp_jacobian(grasp.q)
        for step in rng.normal(scale=1e-3, size=(5, model.n)):
            q = grasp.q + step - np.linalg.pinv(J) @ (J @ step)
            assert comfort(model, q) < comfort(model, grasp.q) + 1e-5


@pytest.mark.parametrize(
    "X_WE",
    [
        RigidTransform(RollPitchYaw(0, np.pi / 2, 0), [0, 0, 5.0]),  # too high
        RigidTransform(RollPitchYaw(0, np.pi / 2, 0.3), [0, 0, 0.4]),  # out of the arm's plane
    ],
    ids=["too high", "sideways"],
)
def test_what_cannot_be_reached_has_no_configuration(case_model, X_WE):
    assert solve_grasp(case_model, X_WE) is None


def test_an_object_out_of_reach_has_no_grasps(case_model, crate):
    assert grasp_configurations(case_model, crate.X_OG, 4.0) == ()


@given(a=angles, b=angles, p=angles, r=angles)
def test_pose_error_takes_one_to_the_other(a, b, p, r):
    X_WA, X_WB = RigidTransform(RollPitchYaw(a), p), RigidTransform(RollPitchYaw(b), r)
    error = pose_error(X_WA, X_WB)
    angle = np.linalg.norm(error[:3])
    assert angle <= np.pi + 1e-9
    K = np.array([[0, -error[2], error[1]], [error[2], 0, -error[0]], [-error[1], error[0], 0]])
    s = np.sinc(angle / np.pi)
    c = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    turned = (np.eye(3) + s * K + c * K @ K) @ X_WA.rotation().matrix()  # Rodrigues
    np.testing.assert_allclose(turned, X_WB.rotation().matrix(), atol=1e-7)
    np.testing.assert_allclose(X_WA.translation() + error[3:], X_WB.translation(), atol=1e-12)
