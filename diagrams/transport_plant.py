"""The physical world of a scenario: agents, objects, floor, and one weld for every possible grasp."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import CollisionFilterDeclaration, GeometryId, GeometrySet, HalfSpace, Role, SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CoulombFriction,
    DiscreteContactApproximation,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import ModelInstanceIndex, MultibodyConstraintId
from pydrake.systems.framework import Context, DiagramBuilder

from drake_ltl.multibody.drive_agent import FLOOR_FRICTION
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.multibody.parsing import GRASP_FRAME, HANDLE_PREFIX, AddAgentModel, AddObjectModel
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.program import Weld, all_welds

FRICTION = CoulombFriction(FLOOR_FRICTION, FLOOR_FRICTION)
"""Of the floor."""


@dataclass(frozen=True)
class TransportPlant:
    """A finalized plant and where a scenario's members are in it."""

    plant: MultibodyPlant
    scene_graph: SceneGraph
    agents: Mapping[str, ModelInstanceIndex]
    objects: Mapping[str, ModelInstanceIndex]
    welds: tuple[Weld, ...]
    weld_ids: tuple[MultibodyConstraintId, ...]
    """In the order of `welds`. Welds are active in a new Context: see `ReleaseAll`."""
    floor: GeometryId

    def ReleaseAll(self, plant_context: Context) -> None:
        """Makes every weld inactive; call it before Simulator.Initialize."""
        for weld_id in self.weld_ids:
            self.plant.SetConstraintActiveStatus(plant_context, weld_id, False)

    def SetFloorContact(self, root_context: Context, name: str, touches: bool) -> None:
        """Whether the floor bears an object; call it between advances."""
        bodies = map(self.plant.get_body, self.plant.GetBodyIndices(self.objects[name]))
        geometries = GeometrySet([g for body in bodies for g in self.plant.GetCollisionGeometriesForBody(body)])
        floor, declaration = GeometrySet([self.floor]), CollisionFilterDeclaration()
        (declaration.AllowBetween if touches else declaration.ExcludeBetween)(floor, geometries)
        context = self.scene_graph.GetMyMutableContextFromRoot(root_context)
        self.scene_graph.collision_filter_manager(context).Apply(declaration)


def AddTransportPlant(
    builder: DiagramBuilder,
    scenario: Scenario,
    models: MeasuredModels,
    *,
    sampled_outputs: bool = True,
    visible: bool = True,
) -> TransportPlant:
    """Adds a discrete MultibodyPlant (SAP) and its SceneGraph with everything in the scenario.

    Grippers may touch handles: contact between an agent's end-effector and an object's handle is filtered, and so
    is that between holonomic agents and the floor on which they roll. All other contact is real; differential drives
    move by that of their tyres alone.

    Args:
        sampled_outputs: whether accelerations, reaction forces and contact results are those of the latest step,
            which costs time in every step; else they are worked out anew whenever they are asked for.
        visible: whether shapes that only eyes see are in the scene; a tenth of a step's time is spent on moving them.

    Raises:
        InvalidInputError: a model cannot be used.
    """
    config = MultibodyPlantConfig(
        time_step=scenario.simulation.time_step,
        discrete_contact_approximation="lagged",
    )
    plant, scene_graph = AddMultibodyPlant(config, builder)
    floor = _add_floor(plant)
    agents = {agent.name: AddAgentModel(plant, agent) for agent in scenario.agents}
    objects = {obj.name: AddObjectModel(plant, obj) for obj in scenario.objects}
    welds = all_welds(models)
    weld_ids = tuple(_add_weld(plant, agents, objects, models, weld) for weld in welds)
    plant.SetUseSampledOutputPorts(sampled_outputs)
    plant.Finalize()
    assert plant.get_discrete_contact_approximation() == DiscreteContactApproximation.kLagged
    _filter_contact(plant, scene_graph, floor, agents, objects)
    if not visible:
        _remove_visuals(plant, scene_graph)
    return TransportPlant(plant, scene_graph, agents, objects, welds, weld_ids, floor)


def _add_floor(plant: MultibodyPlant) -> GeometryId:
    """A half-space: crates stand still on it, on a large box they would drift."""
    pose = HalfSpace.MakePose(np.array([0.0, 0.0, 1.0]), np.zeros(3))
    return plant.RegisterCollisionGeometry(plant.world_body(), pose, HalfSpace(), "floor", FRICTION)


def _add_weld(
    plant: MultibodyPlant,
    agents: Mapping[str, ModelInstanceIndex],
    objects: Mapping[str, ModelInstanceIndex],
    models: MeasuredModels,
    weld: Weld,
) -> MultibodyConstraintId:
    frame_E = plant.GetFrameByName(GRASP_FRAME, agents[weld.agent])
    (configuration,) = (g for g in models.grasps[weld.agent, weld.object] if g.name == weld.option)
    body_O = plant.GetBodyByName(models.objects[weld.object].body_name, objects[weld.object])
    return plant.AddWeldConstraint(
        frame_E.body(), frame_E.GetFixedPoseInBodyFrame(), body_O, RigidTransform(configuration.X_OE)
    )


def _filter_contact(
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    floor: GeometryId,
    agents: Mapping[str, ModelInstanceIndex],
    objects: Mapping[str, ModelInstanceIndex],
) -> None:
    inspector = scene_graph.model_inspector()
    arms = [instance for instance in agents.values() if plant.HasFrameNamed(GRASP_FRAME, instance)]
    bodies = [plant.get_body(i) for instance in arms for i in plant.GetBodyIndices(instance)]
    rolling = [geometry for body in bodies for geometry in plant.GetCollisionGeometriesForBody(body)]
    grippers = [
        geometry
        for instance in arms
        for geometry in plant.GetCollisionGeometriesForBody(plant.GetFrameByName(GRASP_FRAME, instance).body())
    ]
    handles = [
        geometry
        for instance in objects.values()
        for index in plant.GetBodyIndices(instance)
        for geometry in plant.GetCollisionGeometriesForBody(plant.get_body(index))
        if inspector.GetName(geometry).split("::")[-1].startswith(HANDLE_PREFIX)
    ]
    manager = scene_graph.collision_filter_manager()
    manager.Apply(CollisionFilterDeclaration().ExcludeBetween(GeometrySet(rolling), GeometrySet([floor])))
    manager.Apply(CollisionFilterDeclaration().ExcludeBetween(GeometrySet(grippers), GeometrySet(handles)))


def _remove_visuals(plant: MultibodyPlant, scene_graph: SceneGraph) -> None:
    """Leaves what can touch something."""
    inspector, source = scene_graph.model_inspector(), plant.get_source_id()
    for geometry in inspector.GetAllGeometryIds():
        if inspector.GetProximityProperties(geometry) is None:
            scene_graph.RemoveGeometry(source, geometry)
            continue
        for role in (Role.kIllustration, Role.kPerception):
            scene_graph.RemoveRole(source, geometry, role)
