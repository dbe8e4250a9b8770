"""Signed distance between the true collision geometry of two members, by Drake, in a scene with nothing else."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import CollisionFilterDeclaration, GeometryId, GeometrySet
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex, SpatialInertia
from pydrake.systems.framework import DiagramBuilder

from drake_ltl.multibody.object_model import ObjectModel
from drake_ltl.multibody.parsing import GRASP_FRAME, HANDLE_PREFIX, AddAgentModel
from drake_ltl.scenario.model import Agent

FAR = 0.5
"""Distances beyond this are not told apart [m]."""


class PairDistance:
    """An agent and another member alone, with a context to compute in. Not safe to share between threads.

    A gripper is meant to touch handles, so such a pair of geometries does not count (nor do geometries of one member
    among each other); a gripper against the rest of an object does, and all else of an agent against handles.
    """

    def __init__(self, agent: Agent, other: Agent | ObjectModel):
        """Raises InvalidInputError where an agent's model cannot be used (see AddAgentModel)."""
        builder = DiagramBuilder()
        self._plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
        self._agent = AddAgentModel(self._plant, agent)
        self._other = add_member(self._plant, other)
        self._plant.Finalize()
        self._is_object = isinstance(other, ObjectModel)
        own, others = (geometries_of(self._plant, instance) for instance in (self._agent, self._other))
        declaration = CollisionFilterDeclaration()
        declaration.ExcludeWithin(GeometrySet(own)).ExcludeWithin(GeometrySet(others))
        if self._is_object:
            inspector = scene_graph.model_inspector()
            handles = [g for g in others if inspector.GetName(g).split("::")[-1].startswith(HANDLE_PREFIX)]
            declaration.ExcludeBetween(GeometrySet(gripper_of(self._plant, self._agent)), GeometrySet(handles))
        scene_graph.collision_filter_manager().Apply(declaration)
        self._diagram = builder.Build()  # owns the plant
        self._context = self._diagram.CreateDefaultContext()
        self._plant_context = self._plant.GetMyMutableContextFromRoot(self._context)
        self._query = scene_graph.get_query_output_port()
        self._query_context = scene_graph.GetMyContextFromRoot(self._context)

    def __call__(self, q: np.ndarray, other: np.ndarray) -> float:
        """Least signed distance [m], at most FAR; negative where the two overlap, by how deep they do.

        Args:
            q: configuration (n,) of the agent.
            other: that of the other agent; of an object its pose (7,), quaternion (w, x, y, z) and origin in W.
        """
        self._plant.SetPositions(self._plant_context, self._agent, q)
        if self._is_object:
            body = self._plant.get_body(self._plant.GetBodyIndices(self._other)[0])
            X_WO = RigidTransform(Quaternion(other[:4] / np.linalg.norm(other[:4])), other[4:])
            self._plant.SetFreeBodyPose(self._plant_context, body, X_WO)
        else:
            self._plant.SetPositions(self._plant_context, self._other, other)
        pairs = self._query.Eval(self._query_context).ComputeSignedDistancePairwiseClosestPoints(FAR)
        return min((pair.distance for pair in pairs), default=FAR)


def add_member(plant: MultibodyPlant, member: Agent | ObjectModel) -> ModelInstanceIndex:
    """Of an object its collision geometry is enough: its file may be long."""
    if isinstance(member, Agent):
        return AddAgentModel(plant, member)
    instance = plant.AddModelInstance(member.object.name)
    body = plant.AddRigidBody(member.body_name, instance, SpatialInertia.SolidSphereWithMass(1.0, 1.0))
    for part in member.collision:
        plant.RegisterCollisionGeometry(body, part.X_OG, part.shape, part.name, CoulombFriction())
    return instance


def geometries_of(plant: MultibodyPlant, instance: ModelInstanceIndex) -> Sequence[GeometryId]:
    """All collision geometries of a member."""
    bodies = map(plant.get_body, plant.GetBodyIndices(instance))
    return [geometry for body in bodies for geometry in plant.GetCollisionGeometriesForBody(body)]


def gripper_of(plant: MultibodyPlant, agent: ModelInstanceIndex) -> Sequence[GeometryId]:
    """Of the end effector's link; none of an agent without one."""
    if not plant.HasFrameNamed(GRASP_FRAME, agent):
        return []
    return plant.GetCollisionGeometriesForBody(plant.GetFrameByName(GRASP_FRAME, agent).body())
