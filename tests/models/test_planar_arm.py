"""The paper's agent: state x, y, q1, q2, two links of 1 m, 0.5 kg each for the base and the links."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from drake_ltl.models import package_xml
from pydrake.geometry import Box, Capsule, Cylinder, Role
from pydrake.math import RigidTransform
from pydrake.multibody.tree import CalcSpatialInertia, PrismaticJoint, RevoluteJoint, WeldJoint

ARM = "package://drake_ltl_models/agents/planar_arm.urdf"
GRASP_POSTURE = np.radians([78.5, 11.5])
"""(q1, q2) with link 2 horizontal, towards +x of the mount; its negative points towards -x."""
MOVABLE = ["x", "y", "q1", "q2"]


@pytest.fixture
def arm(make_world):
    return make_world(ARM)


def movable_joints(world):
    joints = [world.plant.get_joint(index) for index in world.plant.GetJointIndices(world.instances[0])]
    return [joint for joint in joints if joint.num_positions() > 0]


def test_state_is_x_y_q1_q2(arm):
    joints = movable_joints(arm)
    assert [joint.name() for joint in joints] == MOVABLE
    assert [type(joint) for joint in joints] == [PrismaticJoint] * 2 + [RevoluteJoint] * 2
    assert [joint.position_start() for joint in joints] == [0, 1, 2, 3]
    assert [joint.default_damping() for joint in joints] == [0, 0, 0, 0]


def test_every_joint_is_actuated_within_limits(arm):
    plant = arm.plant
    actuators = [plant.get_joint_actuator(index) for index in plant.GetJointActuatorIndices()]
    assert [actuator.name() for actuator in actuators] == MOVABLE
    assert [actuator.joint().name() for actuator in actuators] == MOVABLE
    assert [actuator.effort_limit() for actuator in actuators] == [300, 300, 200, 200]


def test_joint_limits_contain_both_grasp_postures(arm):
    lower, upper = arm.plant.GetPositionLowerLimits(), arm.plant.GetPositionUpperLimits()
    np.testing.assert_array_equal(upper, -lower)
    assert np.all(upper[:2] >= 1000)
    assert np.all(upper[2:] > GRASP_POSTURE + 0.1)  # overshoot of a controller


@pytest.mark.parametrize(
    ("joint", "parent", "child"), [("mount", "base", "turret"), ("wrist", "link2", "end_effector")]
)
def test_fixed_joints_stay_joints(arm, joint, parent, child):
    fixed = arm.plant.GetJointByName(joint)
    assert isinstance(fixed, WeldJoint)
    assert (fixed.parent_body().name(), fixed.child_body().name()) == (parent, child)


def test_masses(arm):
    def mass(*bodies):
        return sum(arm.plant.GetBodyByName(body).default_mass() for body in bodies)

    assert mass("slide", "base", "turret") == pytest.approx(0.5)
    assert mass("link1") == pytest.approx(0.5)
    assert mass("link2", "end_effector") == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("body", "solids"),
    [
        ("base", [(Box(0.5, 0.5, 0.19), [0, 0, 0.105])]),
        ("link1", [(Capsule(0.04, 1.0), [0, 0, 0.5])]),
        ("link2", [(Cylinder(0.034, 0.85), [0, 0, 0.425])]),
        (
            "end_effector",
            [
                (Box(0.122, 0.05, 0.1), [0, 0, 0.05]),
                (Box(0.014, 0.03, 0.062), [0.023, 0, 0.131]),
                (Box(0.014, 0.03, 0.062), [-0.023, 0, 0.131]),
            ],
        ),
    ],
)
def test_inertia_is_that_of_the_solid(arm, body, solids):
    parts = [CalcSpatialInertia(shape, 1.0).Shift(-np.array(p, dtype=float)) for shape, p in solids]
    expected = sum((part.CopyToFullMatrix6() for part in parts), np.zeros((6, 6)))
    actual = arm.plant.GetBodyByName(body).default_spatial_inertia()
    expected *= actual.get_mass() / expected[5, 5]
    # the file gives six digits
    np.testing.assert_allclose(actual.CopyToFullMatrix6(), expected, rtol=1e-5, atol=1e-9)


def random_postures(world, number):
    """Base at the origin, arm anywhere within its limits, their corners included."""
    lower, upper = world.plant.GetPositionLowerLimits()[2:], world.plant.GetPositionUpperLimits()[2:]
    corners = [(a, b) for a in (lower[0], upper[0]) for b in (lower[1], upper[1])]
    samples = np.random.default_rng(0).uniform(lower, upper, size=(number, 2))
    for q in [*corners, *samples]:
        world.plant.SetPositions(world.context, [0.0, 0.0, *q])
        yield q


def test_mass_matrix_is_well_conditioned(arm):
    for q in random_postures(arm, 200):
        assert np.linalg.cond(arm.plant.CalcMassMatrix(arm.context)) < 100, q


@pytest.mark.parametrize("heading", [0.0, np.pi / 3, 2 * np.pi / 3, -1.0])
@pytest.mark.parametrize("side", [1, -1])
def test_kinematics_at_the_grasp_posture(make_world, arm_with_heading, heading, side):
    """Link 2 is horizontal, 0.4 m above the floor, along the heading or against it."""
    world = make_world(arm_with_heading(heading))
    e = np.array([np.cos(heading), np.sin(heading), 0.0]) * side
    world.plant.SetPositions(world.context, [3.0, -2.0, *(side * GRASP_POSTURE)])
    q1 = GRASP_POSTURE[0]
    p_WB = np.array([3.0, -2.0, 0.0])
    X_WG = world.plant.GetFrameByName("grasp").CalcPoseInWorld(world.context)
    X_WC = world.plant.GetFrameByName("bounding_centre").CalcPoseInWorld(world.context)
    X_WL = world.plant.GetFrameByName("link2").CalcPoseInWorld(world.context)
    up = np.array([0, 0, 1.0])
    np.testing.assert_allclose(X_WL.translation(), p_WB + np.sin(q1) * e + (0.2 + np.cos(q1)) * up, atol=1e-12)
    np.testing.assert_allclose(X_WG.translation(), X_WL.translation() + e, atol=1e-12)
    np.testing.assert_allclose(X_WG.rotation().col(2), e, atol=1e-12)
    np.testing.assert_allclose(X_WC.translation() - p_WB, 0.784 * e + 0.3595 * up, atol=1e-4)
    assert X_WG.translation()[2] == pytest.approx(0.40, abs=1e-3)


def test_heading_leaves_the_base_axes_alone(make_world, arm_with_heading):
    world = make_world(arm_with_heading(1.2))
    world.plant.SetPositions(world.context, [1.0, 2.0, 0.3, 0.4])
    X_WB = world.plant.GetFrameByName("base").CalcPoseInWorld(world.context)
    assert X_WB.IsExactlyEqualTo(RigidTransform([1.0, 2.0, 0.0]))


@pytest.mark.parametrize("heading", [0.0, np.pi / 4])
@pytest.mark.parametrize("role", [Role.kProximity, Role.kIllustration])
def test_bounding_sphere_covers_every_configuration(make_world, arm_with_heading, farthest, heading, role):
    """The heading pi / 4 brings the corners of the base into the arm's plane."""
    world = make_world(arm_with_heading(heading))
    radius = 0.0
    for _ in random_postures(world, 300):
        X_WC = world.plant.GetFrameByName("bounding_centre").CalcPoseInWorld(world.context)
        for _, shape, X_WG in world.geometries(world.instances[0], role):
            radius = max(radius, farthest(shape, X_WC.InvertAndCompose(X_WG)))
    assert radius <= 1.22


def test_nothing_of_the_arm_touches_itself(arm):
    for q in random_postures(arm, 300):
        assert arm.contacts() == [], q


def test_flips_over_the_vertical_above_the_floor(arm, farthest):
    """From one grasp posture to its mirror image in a straight line of joint space."""
    for s in np.linspace(-1, 1, 21):
        arm.plant.SetPositions(arm.context, [0, 0, *(s * GRASP_POSTURE)])
        # the farthest point from one far above, less that distance, is the lowest
        X_WA = RigidTransform([0, 0, 1e6])
        for name, shape, X_WG in arm.geometries(arm.instances[0], Role.kProximity):
            lowest = 1e6 - farthest(shape, X_WA.InvertAndCompose(X_WG))
            assert lowest > (0.009 if name == "base" else 0.1), name


def test_gripper_is_symmetric_under_half_a_turn(arm):
    """Arms that reach forwards and backwards hold the same handle with the gripper turned over."""
    X_WG = arm.plant.GetFrameByName("grasp").CalcPoseInWorld(arm.context)
    body = arm.plant.GetBodyFrameIdOrThrow(arm.plant.GetBodyByName("end_effector").index())
    inspector = arm.scene_graph.model_inspector()
    solids = {
        tuple(np.round(X_WG.InvertAndCompose(arm.query().GetPoseInWorld(geometry)).translation(), 9) + 0.0)
        + tuple(inspector.GetShape(geometry).size())
        for geometry in inspector.GetGeometries(body, Role.kProximity)
    }
    assert len(solids) == 3
    assert {(-x + 0.0, -y + 0.0, *rest) for x, y, *rest in solids} == solids


def test_what_is_tinted_is_named_so():
    """Agents are told apart by the material `accent`; its visuals are named `accent_*`."""
    root = ElementTree.parse(package_xml().parent / "agents" / "planar_arm.urdf").getroot()
    visuals = root.findall(".//visual")
    tinted = {v.get("name") for v in visuals if v.find("material").get("name") == "accent"}
    assert tinted
    assert {v.get("name") for v in visuals if v.get("name").startswith("accent_")} == tinted
    assert len(root.findall("material[@name='accent']/color")) == 1
