"""Signed distances between the true collision geometries of all members, by Drake, in a scene without a floor.

`PairDistance` has two members; here all are in one scene, so that Drake looks closer only where members are close.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import CollisionFilterDeclaration, GeometryId, GeometrySet
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from drake_ltl.multibody.object_model import ObjectModel
from drake_ltl.multibody.pair_distance import add_member, geometries_of, gripper_of
from drake_ltl.multibody.parsing import HANDLE_PREFIX
from drake_ltl.scenario.model import Agent


class SceneDistance:
    """Everybody, with a context to compute in. Not safe to share between threads.

    As in `PairDistance` grippers against handles do not count, nor geometries of one member among each other.
    """

    def __init__(self, agents: Sequence[Agent], objects: Sequence[ObjectModel]):
        """Raises InvalidInputError where an agent's model cannot be used (see AddAgentModel)."""
        builder = DiagramBuilder()
        self._plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
        self._agents = {agent.name: add_member(self._plant, agent) for agent in agents}
        self._objects = {obj.object.name: add_member(self._plant, obj) for obj in objects}
        self._plant.Finalize()
        self._owner: dict[GeometryId, str] = {}
        declaration, inspector = CollisionFilterDeclaration(), scene_graph.model_inspector()
        for name, instance in (self._agents | self._objects).items():
            own = geometries_of(self._plant, instance)
            self._owner |= dict.fromkeys(own, name)
            declaration.ExcludeWithin(GeometrySet(own))
        handles = [
            geometry
            for geometry, name in self._owner.items()
            if name in self._objects and inspector.GetName(geometry).split("::")[-1].startswith(HANDLE_PREFIX)
        ]
        grippers = [g for instance in self._agents.values() for g in gripper_of(self._plant, instance)]
        declaration.ExcludeBetween(GeometrySet(grippers), GeometrySet(handles))
        scene_graph.collision_filter_manager().Apply(declaration)
        self._diagram = builder.Build()  # owns the plant
        self._context = self._diagram.CreateDefaultContext()
        self._plant_context = self._plant.GetMyMutableContextFromRoot(self._context)
        self._query = scene_graph.get_query_output_port()
        self._query_context = scene_graph.GetMyContextFromRoot(self._context)

    def __call__(
        self, q: Mapping[str, np.ndarray], poses: Mapping[str, np.ndarray], within: float
    ) -> dict[tuple[str, str], float]:
        """Least signed distance [m] of every two members that are no farther apart than `within` [m].

        Args:
            q: agent -> configuration (n_i,).
            poses: object -> quaternion (w, x, y, z) and origin in W (7,).
        """
        for name, instance in self._agents.items():
            self._plant.SetPositions(self._plant_context, instance, q[name])
        for name, instance in self._objects.items():
            pose = poses[name]
            body = self._plant.get_body(self._plant.GetBodyIndices(instance)[0])
            X_WO = RigidTransform(Quaternion(pose[:4] / np.linalg.norm(pose[:4])), pose[4:])
            self._plant.SetFreeBodyPose(self._plant_context, body, X_WO)
        least: dict[tuple[str, str], float] = {}
        for pair in self._query.Eval(self._query_context).ComputeSignedDistancePairwiseClosestPoints(within):
            a, b = sorted((self._owner[pair.id_A], self._owner[pair.id_B]))
            least[a, b] = min(pair.distance, least.get((a, b), np.inf))
        return least
