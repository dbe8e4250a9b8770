"""A crate on four feet with a ring that can be grasped from all sides."""

from __future__ import annotations

import numpy as np
import pytest
from pydrake.geometry import HalfSpace, Role
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import CoulombFriction, DiscreteContactApproximation
from pydrake.systems.analysis import Simulator

ARM = "package://drake_ltl_models/agents/planar_arm.urdf"
CRATE = "package://drake_ltl_models/objects/crate.sdf"
GRASP_POSTURE = np.radians([78.5, 11.5])
HEIGHT = 0.25
"""Of the origin Oo above the floor it stands on [m]."""


@pytest.fixture
def crate(make_world):
    return make_world(CRATE)


def add_floor(plant):
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform(), HalfSpace(), "floor", CoulombFriction(0.6, 0.6)
    )


def stand(world, instance, position=(0.0, 0.0), yaw=0.0):
    X_WO = RigidTransform(RotationMatrix.MakeZRotation(yaw), [*position, HEIGHT])
    world.plant.SetFreeBodyPose(world.context, world.plant.GetBodyByName("crate", instance), X_WO)
    return X_WO


def test_mass_and_centre_of_mass(crate):
    body = crate.plant.GetBodyByName("crate")
    inertia = body.default_spatial_inertia()
    assert inertia.get_mass() == 0.5
    np.testing.assert_array_equal(inertia.get_com(), [0, 0, 0])
    # solid box of 0.4 x 0.4 x 0.5 m; the file gives twelve digits
    about = 0.5 / 12 * np.array([0.4**2 + 0.5**2, 0.4**2 + 0.5**2, 2 * 0.4**2])
    np.testing.assert_allclose(inertia.CalcRotationalInertia().get_moments(), about, rtol=1e-9)


def test_every_part_has_the_stated_friction(crate):
    inspector = crate.scene_graph.model_inspector()
    for geometry in inspector.GetAllGeometryIds(Role.kProximity):
        properties = inspector.GetProximityProperties(geometry)
        friction = properties.GetProperty("material", "coulomb_friction")
        assert (friction.static_friction(), friction.dynamic_friction()) == (0.6, 0.6)


@pytest.mark.parametrize("role", [Role.kProximity, Role.kIllustration])
def test_size(crate, farthest, role):
    """Within 0.4 x 0.4 x 0.5 m but for the ring and what holds it; r_O is that of the box's corners."""
    stand(crate, crate.instances[0])
    radius = 0.0
    for name, shape, X_WG in crate.geometries(crate.instances[0], role):
        radius = max(radius, farthest(shape, RigidTransform([0, 0, -HEIGHT]) @ X_WG))
        for axis, reach in ((0, 0.2), (1, 0.2), (2, HEIGHT)):
            if axis < 2 and name.startswith(("handle_", "bracket_")):
                continue
            for side in (-1, 1):
                # the farthest point from one far away, less that distance, is the outermost
                p_WA = np.array([0, 0, HEIGHT]) - side * 1e6 * np.eye(3)[axis]
                outermost = farthest(shape, RigidTransform(p_WA).InvertAndCompose(X_WG)) - 1e6
                assert outermost <= reach + 1e-6, name
    assert radius <= np.hypot(0.2 * np.sqrt(2), HEIGHT) + 1e-9


def test_stands_on_its_feet_alone(make_world):
    world = make_world(CRATE, floor=add_floor)
    X_WO = stand(world, world.instances[0])
    pressed = RigidTransform([0, 0, -1e-3]) @ X_WO
    world.plant.SetFreeBodyPose(world.context, world.plant.GetBodyByName("crate"), pressed)
    touching = {name.split("::")[-1] for pair in world.contacts() for name in pair} - {"floor"}
    assert touching == {"foot_0", "foot_1", "foot_2", "foot_3"}


@pytest.mark.parametrize("yaw", [0.0, 0.3])
def test_rests_still(make_world, yaw):
    world = make_world(CRATE, floor=add_floor)
    before = stand(world, world.instances[0], (1.0, -2.0), yaw)
    simulator = Simulator(world.diagram, world.root)
    simulator.AdvanceTo(2.0)
    after = world.plant.GetBodyByName("crate").EvalPoseInWorld(world.context)
    moved = before.InvertAndCompose(after)
    assert np.linalg.norm(moved.translation()[:2]) < 1e-6
    assert abs(moved.translation()[2]) < 1e-3  # it settles into the compliance of the contact
    assert moved.rotation().ToAngleAxis().angle() < np.radians(1e-3)


@pytest.mark.parametrize("psi", np.radians(np.arange(0, 360, 15)))
@pytest.mark.parametrize("side", [1, -1])
def test_an_arm_of_any_heading_grasps_the_ring(make_world, arm_with_heading, psi, side):
    """Its gripper is at Rz(azimuth) X_OG, turned over where the arm reaches backwards, touching nothing."""
    world = make_world(arm_with_heading(psi), CRATE)
    arm, crate = world.instances
    X_WO = stand(world, crate, (0.7, -0.4))
    e = side * np.array([np.cos(psi), np.sin(psi)])
    azimuth = np.arctan2(-e[1], -e[0])
    frame = world.plant.GetFrameByName("grasp_ring")
    X_OG = frame.GetFixedPoseInBodyFrame()
    turned = RotationMatrix.MakeZRotation(0.0 if side > 0 else np.pi)
    expected = RigidTransform(RotationMatrix.MakeZRotation(azimuth)) @ X_OG @ RigidTransform(turned)

    reach = np.sin(GRASP_POSTURE[0]) + 1.0 + 0.3
    for retreat in np.linspace(0.35, 0.0, 8):
        p_WB = X_WO.translation()[:2] - (reach + retreat) * e
        world.plant.SetPositions(world.context, arm, [*p_WB, *(side * GRASP_POSTURE)])
        assert world.contacts() == []
    gripper = world.plant.GetFrameByName("grasp")
    X_OE = X_WO.InvertAndCompose(gripper.CalcPoseInWorld(world.context))
    # the posture is given to a tenth of a degree, which leaves the gripper 0.63 mm low
    np.testing.assert_allclose(X_OE.translation(), expected.translation(), atol=1e-3)
    np.testing.assert_allclose(X_OE.rotation().matrix(), expected.rotation().matrix(), atol=1e-9)


def test_three_arms_grasp_at_once(make_world, arm_with_heading):
    """Headings 0, 60 and 120 degrees: the middle one reaches backwards, all stand 120 degrees apart."""
    headings = np.radians([0, 60, 120])
    sides = (1, -1, 1)
    world = make_world(*(arm_with_heading(psi) for psi in headings), CRATE)
    *arms, crate = world.instances
    stand(world, crate)
    for arm, psi, side in zip(arms, headings, sides, strict=True):
        p_WB = -(np.sin(GRASP_POSTURE[0]) + 1.3) * side * np.array([np.cos(psi), np.sin(psi)])
        world.plant.SetPositions(world.context, arm, [*p_WB, *(side * GRASP_POSTURE)])
    assert world.contacts() == []
    centres = [
        world.plant.GetFrameByName("bounding_centre", arm).CalcPoseInWorld(world.context).translation() for arm in arms
    ]
    distances = [np.linalg.norm(centres[i] - centres[j]) for i, j in ((0, 1), (0, 2), (1, 2))]
    np.testing.assert_allclose(distances, 2.59, atol=0.01)
