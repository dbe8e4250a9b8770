"""One object alone: its grasp ring, how high it stands, its mass, and the balls that bound it."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import Shape
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.multibody.collision_balls import body_balls, farthest
from drake_ltl.multibody.parsing import RING_FRAME, AddObjectModel, require_collision_geometry
from drake_ltl.scenario.model import TransportObject
from drake_ltl.scenario.model_files import resolve

TOUCH = 2e-3
"""What is no higher than this touches the floor too [m]."""
FIRM = 5e-3
"""How far what touches the floor reaches beyond the centre of mass on all sides [m]."""


@dataclass(frozen=True)
class CollisionShape:
    """One shape of an object's collision geometry."""

    name: str
    shape: Shape
    X_OG: RigidTransform
    """Where it is in {O}."""


class ObjectModel:
    """What is constant of an object. Its origin Oo is its centre of mass, as the paper's {O}."""

    def __init__(self, obj: TransportObject):
        """Raises InvalidInputError where the model cannot be used (see AddObjectModel), has no collision geometry, or
        cannot lie on the floor as the scenario says."""
        builder = DiagramBuilder()
        plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
        instance = AddObjectModel(plant, obj)
        plant.Finalize()
        (index,) = plant.GetBodyIndices(instance)
        body = plant.get_body(index)
        self.object = obj
        self.R_lying = RollPitchYaw(*obj.orientation[:2], 0.0).ToRotationMatrix()
        """R_WO at heading 0."""
        self.X_OG: RigidTransform = plant.GetFrameByName(RING_FRAME, instance).GetFixedPoseInBodyFrame()
        """The grasp ring's frame at azimuth 0."""
        self.mass: float = body.default_mass()
        """[kg], as its model has it, and V."""
        self.borne_mass: float = self.mass
        """[kg], for which its carriers make up: its mass, unless it was weighed (see `weighing`)."""
        self.I_OOo_O: np.ndarray = body.default_rotational_inertia().CopyToFullMatrix3()
        """Rotational inertia (3, 3) about Oo in O [kg m^2]."""
        self.balls_O: np.ndarray = body_balls(plant, scene_graph.model_inspector(), body)
        """(n, 4) rows (x, y, z, radius) [m] in O; their convex hull covers the object."""
        require_collision_geometry([self.balls_O], f"objects.{obj.name}.model", obj.model)
        inspector = scene_graph.model_inspector()
        self.collision: tuple[CollisionShape, ...] = tuple(
            CollisionShape(
                inspector.GetName(geometry).split("::")[-1],
                inspector.CloneGeometryInstance(geometry).shape(),
                inspector.GetPoseInFrame(geometry),
            )
            for geometry in plant.GetCollisionGeometriesForBody(body)
        )
        """What can be touched of it."""
        self._inner_balls_O = body_balls(plant, scene_graph.model_inspector(), body, inside=True)
        self._body_name = body.name()
        self._require_rest()

    def weighing(self, mass: float) -> ObjectModel:
        """The same of an object that was found to weigh so much [kg], which its carriers bear from then on."""
        model = copy(self)
        model.borne_mass = mass
        return model

    @property
    def body_name(self) -> str:
        return self._body_name

    @property
    def height(self) -> float:
        """z of Oo when the object lies on the floor as it does at the start [m]."""
        return -float((self._lying_balls[:, 2] - self.balls_O[:, 3]).min())

    def pose(self, p_WO: np.ndarray, heading: float) -> RigidTransform:
        """X_WO of the object with its origin at p_WO (3,) [m], turned to a heading [rad]."""
        return RigidTransform(RotationMatrix.MakeZRotation(heading) @ self.R_lying, p_WO)

    @property
    def _lying_balls(self) -> np.ndarray:
        """Centres (n, 3) of the balls from Oo, in W at heading 0."""
        return self.balls_O[:, :3] @ self.R_lying.matrix().T

    def _require_rest(self) -> None:
        """An object that is not upright must lie where it lies: its weight above what touches the floor."""
        roll, pitch, _ = self.object.orientation
        if roll == pitch == 0.0:
            return
        low = self._lying_balls[:, 2] - self.balls_O[:, 3] + self.height
        feet = self._lying_balls[low <= TOUCH, :2]
        directions = np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False)
        ahead = feet @ np.array([np.cos(directions), np.sin(directions)])  # (feet, directions)
        if ahead.max(axis=0).min() < FIRM:
            raise InvalidInputError(
                [
                    Mistake(
                        f"objects.{self.object.name}.orientation",
                        f"{resolve(self.object.model).name} cannot lie with roll {roll:.6g} and pitch {pitch:.6g} rad: "
                        "its weight is not above what touches the floor",
                        "turn one of its faces down; with roll and pitch 0 it stands upright",
                    )
                ]
            )

    def inertial_wrench(self, quaternion: np.ndarray, A_WO: np.ndarray) -> np.ndarray:
        """What accelerates the object from rest, turned so (4,), by A_WO (6,) (rotational; translational): (6,) at Oo
        [N m; N]."""
        R_WO = RotationMatrix(Quaternion(quaternion / np.sqrt(quaternion @ quaternion))).matrix()
        return np.concatenate([R_WO @ self.I_OOo_O @ R_WO.T @ A_WO[:3], self.mass * A_WO[3:]])

    def kinetic_energy(self, quaternion: np.ndarray, V_WO: np.ndarray) -> float:
        """Of the object turned so (4,) that moves at V_WO (6,) (rotational; translational) [J]."""
        R_WO = RotationMatrix(Quaternion(quaternion / np.sqrt(quaternion @ quaternion))).matrix()
        w_O, v = V_WO[:3] @ R_WO, V_WO[3:]
        return 0.5 * float(self.mass * (v @ v) + w_O @ self.I_OOo_O @ w_O)

    @property
    def radius(self) -> float:
        """Radius about Oo of the smallest ball that covers the object [m]."""
        return farthest(self.balls_O, np.zeros(3))

    @property
    def inner_radius(self) -> float:
        """How far from Oo the object reaches for certain [m]; less than `radius` where it is round."""
        return farthest(self._inner_balls_O, np.zeros(3))
