"""One agent's dynamics and kinematics, against differences and a plant of its own."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.multibody.tree import MultibodyForces

from drake_ltl.errors import InvalidInputError
from drake_ltl.multibody import AgentModel
from drake_ltl.multibody.collision_balls import farthest

HEADING = 0.7
STEP = 1e-6
vector4 = arrays(float, 4, elements=st.floats(-1.5, 1.5))


@pytest.fixture(scope="module")
def model(make_agent) -> AgentModel:
    return AgentModel(make_agent(HEADING))


@pytest.fixture(scope="module")
def plant(arm_plant):
    return arm_plant(HEADING)


def at(plant, q, qd=None):
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    if qd is not None:
        plant.SetVelocities(context, qd)
    return context


@pytest.mark.parametrize(
    "changes",
    [
        {'<axis xyz="1 0 0"/>': '<axis xyz="0 0 1"/>'},
        {'<axis xyz="0 1 0"/>\n    <limit lower="-1000"': '<axis xyz="1 1 0"/>\n    <limit lower="-1000"'},
    ],
    ids=["a lift", "askew"],
)
def test_a_base_that_is_not_holonomic_is_refused(make_agent, changed_model, changes):
    path = changed_model("agents/planar_arm.urdf", changes)
    with pytest.raises(InvalidInputError) as caught:
        AgentModel(make_agent(model=str(path)))
    (mistake,) = caught.value.mistakes
    assert mistake.where == "agents.a1.model"
    assert "x, y, q1, q2" in mistake.what
    assert "prismatic" in mistake.remedy


@pytest.mark.parametrize("name", ["planar_arm", "mobile_manipulator", "mobile_manipulator_7"])
def test_no_joint_is_damped_more_than_its_inertia_allows(make_agent, name):
    """K dt (B^-1)_jj at a time step of 5 ms, in postures that were not asked before: above 1 it would chatter."""
    robot = AgentModel(make_agent(model=f"package://drake_ltl_models/agents/{name}.urdf"))
    K = robot.damping(18.0, 100.0)
    np.testing.assert_array_equal(K[:2], [18.0, 18.0])
    for q in np.random.default_rng(5).uniform(-0.3, 0.3, size=(50, robot.n)):
        assert np.max(K * 0.005 * np.diag(np.linalg.inv(robot.inertia(q)))) < 0.65


def test_who_is_redundant(make_agent):
    robot = AgentModel(make_agent(model="package://drake_ltl_models/agents/mobile_manipulator.urdf"))
    assert robot.is_redundant
    assert not AgentModel(make_agent()).is_redundant
    assert np.all(robot.gamma_weights[6:] < robot.gamma_weights[5])  # of the wrist, which is light


def test_effort_limits_are_in_the_order_of_joints(make_agent):
    np.testing.assert_array_equal(AgentModel(make_agent()).effort_limits, [300.0, 300.0, 200.0, 200.0])


def test_joints(model):
    assert model.n == 4
    assert model.joint_names == ("x", "y", "q1", "q2")
    np.testing.assert_array_equal(model.gamma_weights[:2], [1.0, 1.0])
    assert np.all(model.gamma_weights > 0.0)


@given(q=vector4)
def test_gravity_is_the_slope_of_the_potential_energy(model, plant, q):
    slope = [
        plant.CalcPotentialEnergy(at(plant, q + STEP * e)) - plant.CalcPotentialEnergy(at(plant, q - STEP * e))
        for e in np.eye(4)
    ]
    np.testing.assert_allclose(model.gravity(q), np.array(slope) / (2 * STEP), atol=1e-6)


def test_gravity_by_hand(model):
    """The arm level: 0.5 kg at 0.5 m, then 0.45 kg at 1.425 m and 0.05 kg at 1.906 m from the shoulder."""
    q = np.array([3.0, -2.0, np.pi / 2, 0.0])
    elbow = 0.45 * 0.425 + 0.05 * (0.85 + 0.0563716)
    expected = -9.81 * np.array([0.0, 0.0, 0.5 * 0.5 + 0.5 * 1.0 + elbow, elbow])
    np.testing.assert_allclose(model.gravity(q), expected, atol=1e-9)


@given(q=vector4, qd=vector4)
def test_inertia_and_kinetic_energy(model, plant, q, qd):
    energy = plant.CalcKineticEnergy(at(plant, q, qd))
    assert model.kinetic_energy(q, qd) == pytest.approx(energy, rel=1e-9, abs=1e-12)
    B = model.inertia(q)
    np.testing.assert_allclose(B, B.T, atol=1e-12)
    assert qd @ B @ qd / 2 == pytest.approx(energy, rel=1e-9, abs=1e-12)


@given(q=vector4, qd=vector4, qdd=vector4)
def test_inverse_dynamics(model, plant, q, qd, qdd):
    context = at(plant, q, qd)
    forces = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, forces)
    np.testing.assert_allclose(
        model.inverse_dynamics(q, qd, qdd), plant.CalcInverseDynamics(context, qdd, forces), atol=1e-10
    )


@given(q=vector4)
def test_centre_and_its_jacobian(model, plant, q):
    frame = plant.GetFrameByName("bounding_centre")
    np.testing.assert_allclose(model.centre(q), frame.CalcPoseInWorld(at(plant, q)).translation(), atol=1e-12)
    columns = [(model.centre(q + STEP * e) - model.centre(q - STEP * e)) / (2 * STEP) for e in np.eye(4)]
    np.testing.assert_allclose(model.centre_jacobian(q), np.transpose(columns), atol=1e-9)


@given(q=vector4)
def test_grasp_pose_and_its_jacobian(model, plant, q):
    X_WE = model.grasp_pose(q)
    assert X_WE.IsNearlyEqualTo(plant.GetFrameByName("grasp").CalcPoseInWorld(at(plant, q)), 1e-12)
    J = model.grasp_jacobian(q)
    for e, column in zip(np.eye(4), J.T, strict=True):
        ahead, behind = model.grasp_pose(q + STEP * e), model.grasp_pose(q - STEP * e)
        v = (ahead.translation() - behind.translation()) / (2 * STEP)
        spin = (ahead.rotation().matrix() - behind.rotation().matrix()) / (2 * STEP) @ X_WE.rotation().matrix().T
        w = np.array([spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]]) / 2
        np.testing.assert_allclose(column, [*w, *v], atol=1e-9)


def test_volume_covers_the_gripper_and_the_base(model):
    q = np.array([1.0, 2.0, 0.4, 0.3])
    balls = model.volume(q)
    corners = np.array([[1 + a, 2 + b, z] for a in (-0.25, 0.25) for b in (-0.25, 0.25) for z in (0.01, 0.2)])
    gaps = np.linalg.norm(balls[None, :, :3] - corners[:, None], axis=-1).min(axis=1)
    np.testing.assert_allclose(gaps, 0.0, atol=1e-9)
    tip = model.grasp_pose(q).translation()
    assert farthest(balls, model.centre(q)) >= np.linalg.norm(tip - model.centre(q)) - 0.01


@given(first=vector4, second=vector4)
def test_calls_leave_no_trace(model, first, second):
    """One model serves several systems."""
    before = model.gravity(first), model.centre(first), model.inverse_dynamics(first, second, second)
    model.inverse_dynamics(second, first, first)
    model.volume(second)
    after = model.gravity(first), model.centre(first), model.inverse_dynamics(first, second, second)
    for a, b in zip(before, after, strict=True):
        np.testing.assert_array_equal(a, b)


def test_reaches_of_many_postures_are_those_of_each(make_agent):
    model = AgentModel(make_agent(heading=0.4))
    arms = np.random.default_rng(3).uniform(*model.arm_limits, (7, model.n - 2))
    for inner, volume in ((False, model.volume), (True, model.inner_volume)):
        each = [farthest(volume(q), model.centre(q)) for q in np.column_stack([np.zeros((7, 2)), arms])]
        # Sums in another order: a few units in the last place of a metre.
        np.testing.assert_allclose(model.reaches(arms, inner=inner), each, rtol=0.0, atol=1e-14)
