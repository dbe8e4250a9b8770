"""Objects that lie, are turned, or have corners in the way of grippers."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RotationMatrix

from drake_ltl.errors import InvalidInputError
from drake_ltl.multibody import AgentModel, MeasureGeometry
from drake_ltl.multibody.object_model import ObjectModel
from drake_ltl.multibody.postures import GOOD_CLEARANCE, LEAST_CLEARANCE, grasp_configurations
from drake_ltl.scenario import loads

SIX = "package://drake_ltl_models/agents/mobile_manipulator.urdf"
FEET = "".join(
    f'<collision name="foot_{i}"><pose>{0.18 * x} {0.18 * y} {0.23 * z} 0 0 0</pose>'
    "<geometry><sphere><radius>0.02</radius></sphere></geometry></collision>"
    for i, (x, y, z) in enumerate(itertools.product((1, -1), repeat=3))
)
BOX = f"""\
<sdf version="1.7"><model name="box"><link name="box">
  <inertial><mass>0.5</mass><inertia><ixx>0.017</ixx><iyy>0.017</iyy><izz>0.013</izz></inertia></inertial>
  <collision name="body"><geometry><box><size>0.38 0.38 0.48</size></box></geometry></collision>{FEET}
</link><frame name="grasp_ring" attached_to="box"><pose degrees="true">0.3 0 0.1 0 90 180</pose></frame></model></sdf>
"""
"""0.4 x 0.4 x 0.5 m, with feet at all corners: it can lie on any face."""


@pytest.fixture
def lying_box(tmp_path, make_object):
    """lying_box(roll, pitch, yaw)"""
    (tmp_path / "box.sdf").write_text(BOX, encoding="utf-8")
    return lambda *orientation: ObjectModel(make_object(tmp_path / "box.sdf", orientation=orientation))


@pytest.fixture(scope="module")
def six(make_agent) -> AgentModel:
    return AgentModel(make_agent(0.7, model=SIX))


@given(angle=st.floats(-7.0, 7.0), yaw=st.floats(-3.0, 3.0), x=st.floats(-5.0, 5.0))
def test_a_turned_robot_is_turned_as_a_whole(six, angle, yaw, x):
    q = np.array([x, 1.0, yaw, 0.1, 0.2, -0.1, 0.3, 0.2, 0.1])
    turn = RigidTransform(RotationMatrix.MakeZRotation(angle), np.zeros(3))
    there = six.turned(q, angle)
    np.testing.assert_allclose(
        six.grasp_pose(there).GetAsMatrix4(), (turn @ six.grasp_pose(q)).GetAsMatrix4(), atol=1e-12
    )
    np.testing.assert_allclose(six.centre(there), turn @ six.centre(q), atol=1e-12)
    np.testing.assert_allclose(six.turned(there, -angle), q, atol=1e-12)


def test_who_can_turn(six, make_agent, changed_model):
    """A yaw joint may turn the other way round; an arm in a vertical plane has none."""
    clockwise = changed_model(
        "agents/mobile_manipulator.urdf",
        {
            '<joint name="yaw" type="continuous">\n    <parent link="slide_y"/>\n    <child link="base"/>\n'
            '    <axis xyz="0 0 1"/>': '<joint name="yaw" type="continuous"><parent link="slide_y"/>'
            '<child link="base"/><axis xyz="0 0 -1"/>'
        },
    )
    other, planar = AgentModel(make_agent(model=clockwise)), AgentModel(make_agent())
    assert (six.yaw_direction, other.yaw_direction, planar.yaw_direction) == (1.0, -1.0, 0.0)
    q = np.full(9, 0.1)
    turn = RotationMatrix.MakeZRotation(0.4)
    turned = other.grasp_pose(other.turned(q, 0.4)).rotation().matrix()
    np.testing.assert_allclose(turned, (turn @ other.grasp_pose(q).rotation()).matrix(), atol=1e-12)
    with pytest.raises(ValueError, match="has no yaw joint"):
        planar.turned(np.zeros(4), 0.1)
    np.testing.assert_array_equal(planar.turned(np.ones(4), 0.0), np.ones(4))


@pytest.mark.parametrize("turns", [-2, 0, 3])
def test_the_nearest_of_all_equal_yaws(six, turns):
    q = np.linspace(0.0, 0.8, 9)
    far = q.copy()
    far[2] += 2.0 * np.pi * turns
    np.testing.assert_allclose(six.nearest_turn(q, far + 0.3), far, atol=1e-12)


@pytest.mark.parametrize(
    ("orientation", "height"),
    [((0, 0, 0.3), 0.25), ((np.pi, 0, 0.3), 0.25), ((np.pi / 2, 0, 1), 0.2), ((0, -np.pi / 2, 0), 0.2)],
)
def test_height_of_what_lies(lying_box, orientation, height):
    assert lying_box(*orientation).height == pytest.approx(height, abs=1e-9)


@pytest.mark.parametrize("orientation", [(0.3, 0.0, 0.0), (np.pi / 2, 0.1, 0.0), (0.0, np.pi / 4, 0.0)])
def test_what_would_fall_over_is_refused(lying_box, orientation):
    with pytest.raises(InvalidInputError) as caught:
        lying_box(*orientation)
    (mistake,) = caught.value.mistakes
    assert mistake.where == "objects.o1.orientation"
    assert "its weight is not above what touches the floor" in mistake.what


@pytest.mark.parametrize("orientation", [(0, 0, 0.9), (np.pi, 0, 0.9), (0, np.pi / 2, 0.9)], ids=str)
def test_grasps_of_what_lies(six, lying_box, orientation):
    """From two sides, level, at the ring; upright and upside down along the heading."""
    box = lying_box(*orientation)
    X_WO = box.pose(np.array([0.0, 0.0, box.height]), orientation[2])
    plus, minus = grasp_configurations(six, box.X_OG, box.height, X_WO.rotation())
    for grasp, sign in ((plus, 1.0), (minus, -1.0)):
        X_WE = six.grasp_pose(grasp.q)
        np.testing.assert_allclose(X_WE.GetAsMatrix4(), (X_WO @ grasp.X_OE).GetAsMatrix4(), atol=1e-4)
        approach = X_WE.rotation().matrix()[:, 2]
        assert abs(approach[2]) < 1e-4
        assert sign * approach[:2] @ [np.cos(0.7), np.sin(0.7)] > 0.1
        np.testing.assert_allclose(np.hypot(*grasp.X_OE.translation()[:2]), 0.3, atol=1e-9)
        if orientation[1] == 0:
            np.testing.assert_allclose(approach[:2], sign * np.array([np.cos(0.7), np.sin(0.7)]), atol=1e-4)


def test_what_is_too_near_is_grasped_from_beside_or_not_at_all(six, make_agent, make_object):
    """An arm in a vertical plane has one way only; who turns takes the first that is clear."""
    crate = ObjectModel(make_object())

    def azimuth(way) -> float:
        return float(np.rad2deg(np.arctan2(way.X_OE.translation()[1], way.X_OE.translation()[0])))

    def near_corner(way) -> float:
        return 0.0 if abs(azimuth(way)) < 45.0 else GOOD_CLEARANCE

    straight = azimuth(grasp_configurations(six, crate.X_OG, crate.height)[1])
    assert straight == pytest.approx(np.rad2deg(0.7), abs=1e-6)
    ways = grasp_configurations(six, crate.X_OG, crate.height, clearance=near_corner)
    assert [way.name for way in ways] == ["plus", "minus"]
    assert azimuth(ways[1]) == pytest.approx(straight + 15.0, abs=1e-6)
    planar = AgentModel(make_agent(0.7))
    assert [way.name for way in grasp_configurations(planar, crate.X_OG, crate.height, None, near_corner)] == ["plus"]
    only_just = grasp_configurations(planar, crate.X_OG, crate.height, None, lambda way: LEAST_CLEARANCE)
    assert len(only_just) == 2


PAIR = """\
name: pair
workspace: {{radius: 20.0}}
regions:
  near: {{centre: [-7.5, 0.0, 0.0], radius: 6.5}}
  far: {{centre: [7.0, 0.5, 0.0], radius: 6.0}}
agents:
  a1: {{model: {model}, position: [-10.0, 2.5], radius: 2.0}}
  a2: {{model: package://drake_ltl_models/agents/planar_arm.urdf, position: [5.0, 2.0], radius: 2.0}}
objects:
  crate:
    model: package://drake_ltl_models/objects/crate.sdf
    position: [-7.0, 0.0]
    heading: 0.4
    headings: {{far: {far}}}
"""


def test_only_who_turns_takes_what_is_to_be_turned():
    models = MeasureGeometry(loads(PAIR.format(model=SIX, far=2.0)))
    assert models.grasps["a2", "crate"] == models.geometry.grasps["a2", "crate"] == ()
    assert [grasp.name for grasp in models.grasps["a1", "crate"]] == ["plus", "minus"]
    for grasp, option in zip(models.grasps["a1", "crate"], models.geometry.grasps["a1", "crate"], strict=True):
        q = models.grasping("a1", "crate", grasp.name, 2.0)
        X_WO = models.objects["crate"].pose(np.array([0.0, 0.0, models.objects["crate"].height]), 2.0)
        X_WE = models.agents["a1"].grasp_pose(q)
        np.testing.assert_allclose(X_WE.GetAsMatrix4(), (X_WO @ grasp.X_OE).GetAsMatrix4(), atol=1e-4)
        turned = option.turned(2.0 - 0.4)
        np.testing.assert_allclose(models.agents["a1"].centre(q), X_WO.translation() + turned.p_OoC_grasp, atol=1e-9)
        np.testing.assert_array_equal(models.postures["a1"][turned.standoff_posture], q[2:])
        assert turned.standoff_posture in models.geometry.postures["a1"]


def test_a_heading_that_nobody_can_turn_to():
    planar = "package://drake_ltl_models/agents/planar_arm.urdf"
    assert MeasureGeometry(loads(PAIR.format(model=planar, far=0.4))).grasps["a1", "crate"]
    with pytest.raises(InvalidInputError) as caught:
        MeasureGeometry(loads(PAIR.format(model=planar, far=2.0)))
    (mistake,) = caught.value.mistakes
    assert mistake.where == "objects.crate.headings"
    assert "no agent can turn crate" in mistake.what
    assert "its heading at the start, 0.4" in mistake.remedy
