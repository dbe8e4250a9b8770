"""The physical world of a scenario."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from drake_ltl.diagrams.transport_plant import AddTransportPlant
from pydrake.geometry import HalfSpace
from pydrake.math import RigidTransform
from pydrake.multibody.plant import DiscreteContactApproximation
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_ltl.systems.program import all_welds


@pytest.fixture(scope="module")
def parts(case_ii, models):
    builder = DiagramBuilder()
    parts = AddTransportPlant(builder, case_ii, models)
    return parts, builder.Build()


def geometries(parts, name: str) -> dict[str, object]:
    """name -> id of the collision geometries of a member."""
    plant, inspector = parts.plant, parts.scene_graph.model_inspector()
    instance = (parts.agents | parts.objects)[name]
    return {
        f"{plant.get_body(body).name()}/{inspector.GetName(g).split('::')[-1]}": g
        for body in plant.GetBodyIndices(instance)
        for g in plant.GetCollisionGeometriesForBody(plant.get_body(body))
    }


def collide(parts, a, b) -> bool:
    return not parts.scene_graph.model_inspector().CollisionFiltered(a, b)


def floor_of(parts):
    inspector = parts.scene_graph.model_inspector()
    (floor,) = (g for g in inspector.GetAllGeometryIds() if isinstance(inspector.GetShape(g), HalfSpace))
    return floor


def test_the_plant_is_discrete_and_can_weld(parts, case_ii):
    plant = parts[0].plant
    assert plant.time_step() == case_ii.simulation.time_step
    assert plant.get_discrete_contact_approximation() != DiscreteContactApproximation.kTamsi


def test_members_go_by_their_names(parts, case_ii):
    plant = parts[0].plant
    for name, instance in (parts[0].agents | parts[0].objects).items():
        assert plant.GetModelInstanceName(instance) == name
    assert tuple(parts[0].agents) == case_ii.agent_names
    assert tuple(parts[0].objects) == case_ii.object_names


def test_there_is_one_weld_for_every_grasp(parts, models):
    assert parts[0].welds == all_welds(models)
    assert len(set(parts[0].weld_ids)) == len(parts[0].welds) == parts[0].plant.num_constraints()


def test_welds_can_all_be_released(parts):
    plant = parts[0].plant
    context = plant.CreateDefaultContext()
    assert any(plant.GetConstraintActiveStatus(context, weld) for weld in parts[0].weld_ids)
    parts[0].ReleaseAll(context)
    assert not any(plant.GetConstraintActiveStatus(context, weld) for weld in parts[0].weld_ids)


def test_grippers_may_touch_handles_alone(parts):
    """... of any object; everything else of an arm touches everything of an object."""
    for agent, obj in itertools.product(("a1", "a2", "a3"), ("o1", "o2")):
        for (arm, a), (part, b) in itertools.product(
            geometries(parts[0], agent).items(), geometries(parts[0], obj).items()
        ):
            is_grip = arm.startswith("end_effector/") and part.startswith("crate/handle")
            assert collide(parts[0], a, b) is not is_grip, (arm, part)


def test_agents_touch_each_other(parts):
    for one, other in itertools.combinations(("a1", "a2", "a3"), 2):
        for a, b in itertools.product(geometries(parts[0], one).values(), geometries(parts[0], other).values()):
            assert collide(parts[0], a, b)


def test_agents_roll_and_objects_stand_on_the_floor(parts):
    floor = floor_of(parts[0])
    for agent in parts[0].agents:
        assert not any(collide(parts[0], floor, g) for g in geometries(parts[0], agent).values())
    for obj in parts[0].objects:
        assert all(collide(parts[0], floor, g) for g in geometries(parts[0], obj).values())


def test_an_object_on_the_floor_stays_where_it_is(case_ii, models):
    """The prototype's crates drifted on a box; on the half-space they stand still."""
    builder = DiagramBuilder()
    parts = AddTransportPlant(builder, case_ii, models)
    simulator = Simulator(builder.Build())
    plant = parts.plant
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    parts.ReleaseAll(context)
    for instance in parts.agents.values():
        plant.get_actuation_input_port(instance).FixValue(context, np.zeros(4))
    for k, instance in enumerate(parts.agents.values()):
        plant.SetPositions(context, instance, [10.0 * k, 10.0, 1.0, 0.5])
    bodies = {name: plant.GetBodyByName("crate", instance) for name, instance in parts.objects.items()}
    start = {}
    for k, (name, body) in enumerate(bodies.items()):
        start[name] = RigidTransform([3.0 * k, -5.0, models.objects[name].height])
        plant.SetFreeBodyPose(context, body, start[name])
    simulator.AdvanceTo(2.0)
    for name, body in bodies.items():
        moved = start[name].inverse() @ body.EvalPoseInWorld(context)
        assert np.linalg.norm(moved.translation()) < 1e-3  # feet press in by less than that
        assert moved.rotation().ToAngleAxis().angle() < 1e-3
