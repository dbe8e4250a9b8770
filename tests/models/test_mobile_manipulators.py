"""The mobile manipulators: x, y, yaw and an arm of six or seven joints."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from drake_ltl.models import package_xml
from pydrake.geometry import Box, Cylinder, Role
from pydrake.multibody.tree import CalcSpatialInertia, JacobianWrtVariable, PrismaticJoint, RevoluteJoint, WeldJoint

NAMES = {6: "mobile_manipulator", 7: "mobile_manipulator_7"}


@pytest.fixture(scope="module", params=NAMES, ids=["six", "seven"])
def arm_joints(request) -> int:
    return request.param


@pytest.fixture
def robot(make_world, arm_joints):
    return make_world(f"package://drake_ltl_models/agents/{NAMES[arm_joints]}.urdf")


def movable_joints(world):
    joints = [world.plant.get_joint(index) for index in world.plant.GetJointIndices(world.instances[0])]
    return [joint for joint in joints if joint.num_positions() > 0]


def random_postures(world, number):
    """Base at the origin, at any yaw; the arm anywhere within its limits."""
    lower, upper = world.plant.GetPositionLowerLimits()[2:], world.plant.GetPositionUpperLimits()[2:]
    lower, upper = np.maximum(lower, -np.pi), np.minimum(upper, np.pi)
    for q in np.random.default_rng(0).uniform(lower, upper, size=(number, len(lower))):
        world.plant.SetPositions(world.context, [0.0, 0.0, *q])
        yield q


def test_state_is_x_y_yaw_and_the_arm(robot, arm_joints):
    joints = movable_joints(robot)
    assert [joint.name() for joint in joints] == ["x", "y", "yaw", *(f"q{k + 1}" for k in range(arm_joints))]
    assert [type(joint) for joint in joints] == [PrismaticJoint] * 2 + [RevoluteJoint] * (1 + arm_joints)
    assert [joint.position_start() for joint in joints] == list(range(3 + arm_joints))
    assert isinstance(robot.plant.GetJointByName("wrist"), WeldJoint)


def test_every_joint_is_actuated_within_limits(robot, arm_joints):
    plant = robot.plant
    actuators = [plant.get_joint_actuator(index) for index in plant.GetJointActuatorIndices()]
    assert [actuator.joint().name() for actuator in actuators] == [joint.name() for joint in movable_joints(robot)]
    strong = arm_joints - 3  # turret, shoulder, elbow, and the roll of the upper arm if there is one
    assert [a.effort_limit() for a in actuators] == [300, 300, 60, *[60] * strong, *[30] * 3]
    reflected = [a.default_rotor_inertia() * a.default_gear_ratio() ** 2 for a in actuators]
    np.testing.assert_allclose(reflected, [0, 0, 0, *[0.04] * strong, *[0.02] * 3])


def test_the_base_may_turn_for_ever(robot):
    lower, upper = robot.plant.GetPositionLowerLimits(), robot.plant.GetPositionUpperLimits()
    assert np.isinf([lower[2], upper[2]]).all()
    assert np.all(lower[3:] < 0.0)
    assert np.all(upper[3:] > 0.0)


def test_masses(robot):
    masses = {name: robot.plant.GetBodyByName(name).default_mass() for name in ("base", "slide_x", "slide_y")}
    assert masses == {"base": 4.0, "slide_x": 0.0, "slide_y": 0.0}
    assert robot.plant.CalcTotalMass(robot.context) == pytest.approx(5.65)


def test_inertias_are_those_of_the_solid_collision_shapes(robot):
    plant, inspector = robot.plant, robot.scene_graph.model_inspector()
    checked = set()
    for index in plant.GetBodyIndices(robot.instances[0]):
        body = plant.get_body(index)
        geometries = plant.GetCollisionGeometriesForBody(body)
        if body.name() == "end_effector" or not geometries:
            continue  # that of the planar arm, tested there
        shape, X_BG = inspector.GetShape(geometries[0]), inspector.GetPoseInFrame(geometries[0])
        assert isinstance(shape, (Box, Cylinder))
        assert X_BG.rotation().IsExactlyIdentity()
        expected = CalcSpatialInertia(shape, 1.0).Shift(-X_BG.translation()).CopyToFullMatrix6()
        actual = body.default_spatial_inertia()
        expected *= actual.get_mass() / expected[5, 5]
        np.testing.assert_allclose(actual.CopyToFullMatrix6(), expected, rtol=1e-5, atol=1e-9)  # six digits
        checked.add(body.name())
    assert len(checked) >= 7


def test_zero_is_level_and_ready_to_grasp(robot, arm_joints):
    robot.plant.SetPositions(robot.context, [3.0, -2.0, np.pi / 2, *[0.0] * arm_joints])
    X_WG = robot.plant.GetFrameByName("grasp").CalcPoseInWorld(robot.context)
    np.testing.assert_allclose(X_WG.translation(), [3.0, -2.0 + 0.829, 0.4], atol=1e-3)
    np.testing.assert_allclose(X_WG.rotation().col(2), [0.0, 1.0, 0.0], atol=1e-3)
    X_WC = robot.plant.GetFrameByName("bounding_centre").CalcPoseInWorld(robot.context)
    np.testing.assert_allclose(X_WC.translation(), [3.0, -1.95, 0.38], atol=1e-9)


def test_jacobian_has_full_rank_throughout(robot):
    """Six independent twists in every posture, thanks to the base; and B is well conditioned."""
    plant, world = robot.plant, robot.plant.world_frame()
    frame = plant.GetFrameByName("grasp")
    least = np.inf
    for _ in random_postures(robot, 500):
        J = plant.CalcJacobianSpatialVelocity(robot.context, JacobianWrtVariable.kV, frame, np.zeros(3), world, world)
        least = min(least, np.linalg.svd(J, compute_uv=False)[-1])
        assert np.linalg.cond(plant.CalcMassMatrix(robot.context)) < 1000
    assert least > 0.01


@pytest.mark.parametrize("role", [Role.kProximity, Role.kIllustration])
def test_bounding_sphere_covers_every_configuration(robot, farthest, role):
    radius = 0.0
    for _ in random_postures(robot, 500):
        X_WC = robot.plant.GetFrameByName("bounding_centre").CalcPoseInWorld(robot.context)
        for _, shape, X_WG in robot.geometries(robot.instances[0], role):
            radius = max(radius, farthest(shape, X_WC.InvertAndCompose(X_WG)))
    assert 0.7 < radius <= 0.87


def test_nothing_touches_itself_around_the_grasp(robot, arm_joints):
    rng = np.random.default_rng(0)
    for q in [np.zeros(arm_joints), *rng.uniform(-0.3, 0.3, size=(200, arm_joints))]:
        robot.plant.SetPositions(robot.context, [0.0, 0.0, 0.0, *q])
        assert robot.contacts() == [], q


def test_gripper_is_symmetric_under_half_a_turn(robot):
    plant = robot.plant
    X_WG = plant.GetFrameByName("grasp").CalcPoseInWorld(robot.context)
    body = plant.GetBodyFrameIdOrThrow(plant.GetBodyByName("end_effector").index())
    solids = set()
    for geometry in robot.scene_graph.model_inspector().GetGeometries(body, Role.kProximity):
        X_GA = X_WG.InvertAndCompose(robot.query().GetPoseInWorld(geometry))
        np.testing.assert_allclose(X_GA.rotation().matrix(), np.eye(3), atol=1e-9)
        solids.add(tuple(np.round(X_GA.translation(), 9) + 0.0))
    assert len(solids) == 3
    assert {(-x + 0.0, -y + 0.0, z) for x, y, z in solids} == solids


def test_what_is_tinted_is_named_so(arm_joints):
    """Agents are told apart by the material `accent`; its visuals are named `accent_*`."""
    root = ElementTree.parse(package_xml().parent / "agents" / f"{NAMES[arm_joints]}.urdf").getroot()
    visuals = root.findall(".//visual")
    tinted = {v.get("name") for v in visuals if v.find("material").get("name") == "accent"}
    assert tinted
    assert {v.get("name") for v in visuals if v.get("name").startswith("accent_")} == tinted
