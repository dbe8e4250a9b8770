"""What a differential drive's model says of itself, and which models are refused."""

from __future__ import annotations

import numpy as np
import pytest
from drake_ltl.models import package_xml
from hypothesis import given
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import MultibodyPlant

from drake_ltl.errors import InvalidInputError
from drake_ltl.multibody.differential_drive_model import AddDifferentialDrive, DifferentialDriveModel

TEXT = (package_xml().parent / "bases" / "differential_drive.urdf").read_text(encoding="utf-8")
SMALL = st.floats(-0.05, 0.05)
RATE = st.floats(-2.0, 2.0)


@pytest.fixture(scope="module")
def model() -> DifferentialDriveModel:
    return DifferentialDriveModel("a1")


@pytest.fixture(scope="module")
def plant() -> MultibodyPlant:
    plant = MultibodyPlant(0.0)
    AddDifferentialDrive(plant, "a1")
    plant.Finalize()
    return plant


def test_sizes(model):
    assert (model.wheel_radius, model.half_track, model.height) == pytest.approx((0.1, 0.2, 0.1))
    assert model.effort == 2.5
    assert np.hypot(0.25, 0.09) <= model.radius <= 0.27  # the chassis' upper rim, but for its polygon


def test_reduced_inertias_count_the_wheels_turning(model):
    spin, across, mass = 0.0025, 0.00131667, 0.5
    assert model.mass == pytest.approx(8.0 + 2.0 * mass + 2.0 * spin / 0.1**2, rel=1e-9)
    expected = 0.25 + 2.0 * (across + mass * 0.2**2) + 2.0 * spin * (0.2 / 0.1) ** 2
    assert model.inertia == pytest.approx(expected, rel=1e-9)


@given(roll=SMALL, pitch=SMALL, yaw=st.floats(-3.1, 3.1), w=st.tuples(RATE, RATE, RATE), v=st.tuples(RATE, RATE, RATE))
def test_planar_state_is_that_of_the_axle(model, plant, roll, pitch, yaw, w, v):
    """Against Drake's own kinematics of the frame `bounding_centre`, which is the middle of the axle."""
    context = plant.CreateDefaultContext()
    base = plant.GetBodyByName("base")
    plant.SetFreeBodyPose(context, base, RigidTransform(RollPitchYaw(roll, pitch, yaw), [1.0, -2.0, 0.01]))
    plant.SetFreeBodySpatialVelocity(context, base, SpatialVelocity(w, v))
    for side, rate in (("left", 3.0), ("right", -4.0)):
        plant.GetJointByName(side).set_angular_rate(context, rate)
    frame = plant.GetFrameByName("bounding_centre")
    velocity = frame.CalcSpatialVelocityInWorld(context).translational()[:2]
    x_axis = base.EvalPoseInWorld(context).rotation().matrix()[:, 0].copy()  # the pose itself does not last
    h = x_axis[:2] / np.linalg.norm(x_axis[:2])
    state = model.planar_state(plant.GetPositionsAndVelocities(context))
    np.testing.assert_allclose(state.p, frame.CalcPoseInWorld(context).translation()[:2], atol=1e-12)
    np.testing.assert_allclose([np.cos(state.theta), np.sin(state.theta)], h, atol=1e-12)
    assert state.v == pytest.approx(h @ velocity, abs=1e-12)
    assert state.aside == pytest.approx(h[0] * velocity[1] - h[1] * velocity[0], abs=1e-12)
    assert state.omega == w[2]
    pitching = h[0] * w[1] - h[1] * w[0]
    np.testing.assert_allclose(state.wheels, [3.0 + pitching, -4.0 + pitching], atol=1e-12)


def test_positions_are_those_of_a_pose_in_the_plane(model):
    state = model.planar_state(np.concatenate([model.positions(1.0, 2.0, -2.5), np.zeros(8)]))
    np.testing.assert_allclose([*state.p, state.theta], [1.0, 2.0, -2.5], atol=1e-12)


def test_actuation_is_in_the_file_s_order(tmp_path):
    names = ('<transmission name="left">', '<transmission name="right">')
    blocks = [TEXT[TEXT.index(name) :].split("</transmission>")[0] + "</transmission>" for name in names]
    text = TEXT.replace(blocks[0], "@").replace(blocks[1], blocks[0]).replace("@", blocks[1])
    path = tmp_path / "swapped.urdf"
    path.write_text(text)
    np.testing.assert_array_equal(DifferentialDriveModel("a1", str(path)).actuation(1.0, 2.0), [2.0, 1.0])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('<joint name="left" type="continuous">', '<joint name="left" type="fixed">', "'left'"),
        ('name="left"', 'name="port"', "no wheel on a revolute joint 'left'"),
        ('<frame name="bounding_centre"', '<frame name="middle"', "no frame 'bounding_centre'"),
        ('xyz="0 0.2 0.1"', 'xyz="0 0.25 0.1"', "its wheels at"),
        ('xyz="0 0.2 0.1"', 'xyz="0.1 0.2 0.1"', "its wheels at"),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 -1 0"/>', "axes are not y"),
        ('<origin xyz="0 0 0.12"/>\n      <mass', '<origin xyz="0.05 0 0.12"/>\n      <mass', "centre of mass"),
        ('link="base" xyz="0 0 0.1"', 'link="base" xyz="0.1 0 0.1"', "'bounding_centre' at"),
        ('a="0.1" b="0.02" c="0.1"', 'a="0.12" b="0.02" c="0.12"', "reaches down to z"),
        ("<robot", "<robt", "does not parse"),
    ],
)
def test_what_the_law_cannot_drive_is_refused(tmp_path, old, new, message):
    assert old in TEXT
    path = tmp_path / "changed.urdf"
    path.write_text(TEXT.replace(old, new))
    with pytest.raises(InvalidInputError, match=message) as caught:
        DifferentialDriveModel("a1", str(path))
    for mistake in caught.value.mistakes:
        assert mistake.where == "a1.model"
        assert "\n" not in str(mistake)


@pytest.mark.parametrize("model", ["no/such.urdf", "package://other/a.urdf", "http://a/b.urdf"])
def test_files_that_are_none_are_refused(model):
    with pytest.raises(InvalidInputError, match=r"a1\.model"):
        DifferentialDriveModel("a1", model)
