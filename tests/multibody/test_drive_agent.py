"""Differential drives as agents: their joints, spheres and numbers."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_ltl.errors import InvalidInputError
from drake_ltl.multibody.collision_balls import farthest
from drake_ltl.multibody.crew import CrewModel
from drake_ltl.multibody.differential_drive_model import DIFFERENTIAL_DRIVE
from drake_ltl.multibody.drive_agent import YAW, DriveAgent
from drake_ltl.multibody.radii import agent_radius
from drake_ltl.scenario.model import Agent
from drake_ltl.scenario.model_files import resolve

ARM = "package://drake_ltl_models/agents/planar_arm.urdf"


def agent(name: str = "a1", model: str = DIFFERENTIAL_DRIVE) -> Agent:
    return Agent(name, model, (0.0, 0.0), 0.5, 0.0, has_arm=False)


@pytest.fixture(scope="module")
def drive() -> DriveAgent:
    return DriveAgent(agent(), 40.0)


ROWS = st.lists(st.floats(-3.0, 3.0), min_size=8, max_size=8).map(np.array)


def test_its_joints_are_those_of_a_free_body_and_its_wheels(drive):
    assert drive.joint_names == ("x", "y", "yaw", "z", "pitch", "roll", "left", "right")
    assert (drive.n, drive.wheels, drive.is_redundant, drive.has_arm) == (8, (6, 7), False, False)
    at_start = np.concatenate([[1.0, 2.0], drive.start_arm])
    X_WB = drive.plant.GetFrameByName("base")
    drive.plant.SetPositions(drive._context, at_start)
    pose = X_WB.CalcPoseInWorld(drive._context)
    np.testing.assert_allclose(pose.translation(), [1.0, 2.0, 0.0], atol=2e-4)  # where wheels stand in the floor
    np.testing.assert_allclose(pose.rotation().ToRollPitchYaw().yaw_angle(), 0.5)


@settings(max_examples=20)
@given(q=ROWS)
def test_its_inertia_is_the_reduced_one_when_it_rolls(drive, q):
    """S^T M S of rolling, on the joints as on the free base, wherever it is."""
    q = np.array([*q[:3], 0.0, 0.0, 0.0, *q[6:]])
    r, b, c, s = drive.drive.wheel_radius, drive.drive.half_track, np.cos(q[YAW]), np.sin(q[YAW])
    S = np.zeros((8, 2))
    S[[0, 1, 6, 7], 0] = c, s, 1.0 / r, 1.0 / r
    S[[2, 6, 7], 1] = 1.0, -b / r, b / r
    reduced = S.T @ drive.inertia(q) @ S
    np.testing.assert_allclose(reduced, np.diag([drive.drive.mass, drive.drive.inertia]), atol=1e-9)


@settings(max_examples=20)
@given(q=ROWS, rates=ROWS)
def test_what_its_wheels_leave_unexplained_is_what_acts_along_rolling_motions(drive, q, rates):
    """By the inverse dynamics of the whole body, of which the floor's forces do no work while it rolls."""
    q, (v, omega, *qdd), torque = np.array([*q[:3], 0.0, 0.0, 0.0, *q[6:]]), rates[:4], np.r_[np.zeros(6), rates[6:]]
    r, b, c, s = drive.drive.wheel_radius, drive.drive.half_track, np.cos(q[YAW]), np.sin(q[YAW])
    S = np.zeros((8, 2))
    S[[0, 1, 6, 7], 0] = c, s, 1.0 / r, 1.0 / r
    S[[2, 6, 7], 1] = 1.0, -b / r, b / r
    qdd = S @ qdd + v * omega * np.array([-s, c, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    crew = CrewModel([agent()])
    crew.set_state(q, S @ [v, omega])
    expected = S.T @ (crew.inverse_dynamics(qdd) - torque)
    np.testing.assert_allclose(drive.unexplained(q, qdd, torque)[[0, YAW]], expected, atol=1e-9)


@settings(max_examples=20)
@given(q=ROWS, qd=ROWS)
def test_V_knows_of_its_motion_along_its_heading_alone(drive, q, qd):
    v = qd[:2] @ [np.cos(q[YAW]), np.sin(q[YAW])]
    assert drive.energy(q, qd) == pytest.approx(drive.scale * drive.drive.mass * v**2 / 2)


@settings(max_examples=20)
@given(q=ROWS)
def test_its_sphere_does_not_bounce_or_pitch_with_it(drive, q):
    np.testing.assert_allclose(drive.centre(q), [q[0], q[1], drive.drive.height], atol=1e-12)
    np.testing.assert_allclose(drive.centre_jacobian(q), np.eye(3, 8) * [[1.0], [1.0], [0.0]], atol=1e-12)


@pytest.fixture(scope="module")
def radius(drive) -> float:
    return agent_radius(drive.agent, drive)


@settings(max_examples=20)
@given(q=ROWS)
def test_its_sphere_covers_it_as_it_stands_on_its_tyres(drive, radius, q):
    q = np.array([*q[:3], -1e-3 * abs(q[3]) / 3.0, 1e-3 * q[4], 1e-3 * q[5], *q[6:]])
    assert farthest(drive.inner_volume(q), drive.centre(q)) <= radius


@settings(max_examples=20)
@given(q=ROWS, goal=ROWS)
def test_its_share_of_gamma_is_that_of_its_dipole(drive, q, goal):
    gamma, half = drive.goal_error(q, goal)
    assert gamma == pytest.approx(float(drive.gamma(q, goal)), rel=1e-12, abs=1e-12)
    steps = 1e-5 * np.eye(8)
    slope = (drive.gamma(q + steps, goal) - drive.gamma(q - steps, goal)) / 2e-5
    np.testing.assert_allclose(2.0 * half, slope, atol=1e-7)  # of differences of numbers of some 10


def test_its_far_field_force_leaves_torque_to_turn():
    """Strong fields are divided, weak ones are not; what that leaves unused is damped less."""
    strong, weak = DriveAgent(agent(), 400.0), DriveAgent(agent(), 5.0)
    assert 400.0 / strong.scale == pytest.approx(0.5 * strong.traction)
    assert weak.scale == 1.0
    for drive, force in ((strong, 400.0), (weak, 5.0)):
        assert force / drive.scale / drive.gains.drive_damping == pytest.approx(2.0)  # its cruise [m/s]


def test_a_crew_may_be_mixed(drive):
    arm = Agent("a2", ARM, (0.0, 0.0), 0.0, 1.0)
    crew = CrewModel([agent(), arm])
    assert crew.with_arms == ("a2",)
    assert crew.rows == {"a1": slice(0, 8), "a2": slice(8, 12)}
    q, qd = np.linspace(-1.0, 1.0, 12), np.linspace(2.0, -1.0, 12)
    crew.set_state(q, qd * ([1.0] * 8 + [0.0] * 4))
    assert crew.kinetic_energy() == pytest.approx(drive.kinetic_energy(q[:8], qd[:8]))
    np.testing.assert_allclose(crew.centre("a1"), drive.centre(q[:8]), atol=1e-12)


@pytest.mark.parametrize(
    ("pattern", "by", "says"),
    [
        ("mu_(static|dynamic) value=.1.0.", "mu_\\1 value='0'", "has wheels that cannot drive it"),
        ('(?s)<collision name="left_tyre">.*?</collision>', "", "wheel 'left_wheel' without collision geometry"),
        (r'(?s)(<link name="right_wheel">)\s*<inertial>.*?</inertial>', "\\1", "wheel 'right_wheel' without mass"),
        ('"bounding_centre" link="base"', '"bounding_centre" link="left_wheel"', "put it above the middle"),
        ('(?s)<transmission name="left">.*?</transmission>', "", "give each wheel one"),
        ("</robot>", '<link name="other"/></robot>', "14 degrees of freedom"),
    ],
)
def test_what_cannot_drive_is_refused(tmp_path, pattern, by, says):
    path = tmp_path / "own.urdf"
    path.write_text(re.sub(pattern, by, resolve(DIFFERENTIAL_DRIVE).read_text()))
    with pytest.raises(InvalidInputError) as caught:
        DriveAgent(agent(model=str(path)), 40.0)
    (mistake,) = caught.value.mistakes
    assert mistake.where == "agents.a1.model"
    assert says in str(mistake)
