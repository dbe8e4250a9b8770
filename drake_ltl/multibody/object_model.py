"""One object alone: its grasp ring, how high it stands, its mass, and the balls that bound it."""

from __future__ import annotations

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from drake_ltl.multibody.collision_balls import body_balls, farthest
from drake_ltl.multibody.parsing import RING_FRAME, AddObjectModel, require_collision_geometry
from drake_ltl.scenario.model import TransportObject


class ObjectModel:
    """What is constant of an object. Its origin Oo is its centre of mass, as the paper's {O}."""

    def __init__(self, obj: TransportObject):
        """Raises InvalidInputError where the model cannot be used (see AddObjectModel) or has no collision geometry."""
        builder = DiagramBuilder()
        plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
        instance = AddObjectModel(plant, obj)
        plant.Finalize()
        (index,) = plant.GetBodyIndices(instance)
        body = plant.get_body(index)
        self.object = obj
        self.X_OG: RigidTransform = plant.GetFrameByName(RING_FRAME, instance).GetFixedPoseInBodyFrame()
        """The grasp ring's frame at azimuth 0."""
        self.mass: float = body.default_mass()
        """[kg]"""
        self.I_OOo_O: np.ndarray = body.default_rotational_inertia().CopyToFullMatrix3()
        """Rotational inertia (3, 3) about Oo in O [kg m^2]."""
        self.balls_O: np.ndarray = body_balls(plant, scene_graph.model_inspector(), body)
        """(n, 4) rows (x, y, z, radius) [m] in O; their convex hull covers the object."""
        require_collision_geometry([self.balls_O], f"objects.{obj.name}.model", obj.model)
        self._inner_balls_O = body_balls(plant, scene_graph.model_inspector(), body, inside=True)
        self._body_name = body.name()

    @property
    def body_name(self) -> str:
        return self._body_name

    @property
    def height(self) -> float:
        """z of Oo when the object stands upright on the floor [m]."""
        return -float((self.balls_O[:, 2] - self.balls_O[:, 3]).min())

    @property
    def radius(self) -> float:
        """Radius about Oo of the smallest ball that covers the object [m]."""
        return farthest(self.balls_O, np.zeros(3))

    @property
    def inner_radius(self) -> float:
        """How far from Oo the object reaches for certain [m]; less than `radius` where it is round."""
        return farthest(self._inner_balls_O, np.zeros(3))
