"""The differential drive: a free base on two driven wheels and two casters."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from drake_ltl.models import package_xml
from pydrake.geometry import Cylinder, Ellipsoid, HalfSpace, Role
from pydrake.multibody.plant import CoulombFriction
from pydrake.multibody.tree import CalcSpatialInertia
from pydrake.systems.analysis import Simulator

URI = "package://drake_ltl_models/bases/differential_drive.urdf"


def floor(plant) -> None:
    pose = HalfSpace.MakePose(np.array([0.0, 0.0, 1.0]), np.zeros(3))
    plant.RegisterCollisionGeometry(plant.world_body(), pose, HalfSpace(), "floor", CoulombFriction(1.0, 1.0))


@pytest.fixture
def robot(make_world):
    return make_world(URI)


def test_wheels_are_all_that_is_driven(robot):
    plant = robot.plant
    actuators = [plant.get_joint_actuator(index) for index in plant.GetJointActuatorIndices()]
    assert {actuator.joint().name(): actuator.effort_limit() for actuator in actuators} == {"left": 2.5, "right": 2.5}
    assert plant.num_velocities() == 8


def test_inertias_are_those_of_the_solid_chassis_and_wheels(robot):
    plant, inspector = robot.plant, robot.scene_graph.model_inspector()
    parts = {"base": (Cylinder(0.25, 0.14), 8.0), "left_wheel": (Cylinder(0.1, 0.04), 0.5)}
    for name, (shape, mass) in (parts | {"right_wheel": parts["left_wheel"]}).items():
        inertia = plant.GetBodyByName(name).default_spatial_inertia()
        assert inertia.get_mass() == mass
        moments = np.sort(inertia.CalcRotationalInertia().get_moments() - _of_offset(inertia))
        expected = np.sort(CalcSpatialInertia(shape, 1.0).CalcRotationalInertia().get_moments())
        expected *= mass / CalcSpatialInertia(shape, 1.0).get_mass()
        np.testing.assert_allclose(moments, expected, rtol=1e-5)  # six digits
    chassis = plant.GetCollisionGeometriesForBody(plant.GetBodyByName("base"))[0]
    assert inspector.GetShape(chassis).radius() == 0.25


def _of_offset(inertia) -> np.ndarray:
    """Moments about the body's origin that are due to where the centre of mass is (Steiner)."""
    x, y, z = inertia.get_com()
    return inertia.get_mass() * np.array([y**2 + z**2, x**2 + z**2, x**2 + y**2])


@pytest.mark.parametrize("role", [Role.kProximity, Role.kIllustration])
def test_bounding_sphere_covers_it(robot, farthest, role):
    X_WC = robot.plant.GetFrameByName("bounding_centre").CalcPoseInWorld(robot.context)
    shapes = [(shape, X_WG) for _, shape, X_WG in robot.geometries(robot.instances[0], role)]
    shapes = [(shape, X_WG) for shape, X_WG in shapes if not isinstance(shape, Ellipsoid)]  # tyres: in their wheels
    assert max(farthest(shape, X_WC.InvertAndCompose(X_WG)) for shape, X_WG in shapes) <= 0.27


def test_stands_still_on_its_wheels(make_world):
    world = make_world(URI, floor=floor)
    plant, simulator = world.plant, Simulator(world.diagram, world.root)
    plant.get_actuation_input_port().FixValue(world.context, np.zeros(2))
    simulator.AdvanceTo(1.0)
    base = plant.GetBodyByName("base")
    X_WB, V_WB = base.EvalPoseInWorld(world.context), base.EvalSpatialVelocityInWorld(world.context)
    np.testing.assert_allclose(X_WB.translation(), 0.0, atol=1e-3)  # it sinks in by 0.1 mm
    assert X_WB.rotation().col(2)[2] > np.cos(2e-3)  # casters hang 0.2 mm above the floor, 0.19 m off the axle
    assert np.linalg.norm(V_WB.translational()) < 1e-4


def test_what_is_tinted_is_named_so():
    root = ElementTree.parse(package_xml().parent / "bases" / "differential_drive.urdf").getroot()
    visuals = root.findall(".//visual")
    tinted = {v.get("name") for v in visuals if v.find("material").get("name") == "accent"}
    assert tinted
    assert {v.get("name") for v in visuals if v.get("name").startswith("accent_")} == tinted
