"""Loads the shipped models into plants and measures their geometry, without the library's own loader."""

from __future__ import annotations

from dataclasses import dataclass
from xml.dom import minidom

import numpy as np
import pytest
from drake_ltl.models import package_xml
from pydrake.geometry import Box, Capsule, Cylinder, Role, SceneGraph, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.framework import Context, Diagram, DiagramBuilder


def _arm_with_heading(heading: float) -> str:
    """The arm's URDF with the yaw of its mount set to `heading` [rad]."""
    document = minidom.parse(str(package_xml().parent / "agents" / "planar_arm.urdf"))
    (mount,) = (j for j in document.getElementsByTagName("joint") if j.getAttribute("name") == "mount")
    mount.getElementsByTagName("origin")[0].setAttribute("rpy", f"0 0 {float(heading)!r}")
    return document.toxml()


def _farthest(shape, X_CG: RigidTransform) -> float:
    """Largest distance [m] of a point of `shape`, posed at X_CG, from the origin of frame C."""
    p = X_CG.translation()
    axis = X_CG.rotation().col(2)
    match shape:
        case Sphere():
            return np.linalg.norm(p) + shape.radius()
        case Capsule():
            ends = (p + s * axis * shape.length() / 2 for s in (-1, 1))
            return max(np.linalg.norm(end) for end in ends) + shape.radius()
        case Cylinder():
            ends = (p + s * axis * shape.length() / 2 for s in (-1, 1))
            return max(np.hypot(end @ axis, _across(end, axis) + shape.radius()) for end in ends)
        case Box():
            signs = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1)
            corners = X_CG.multiply(signs * shape.size()[:, None] / 2)
            return np.linalg.norm(corners, axis=0).max()
    raise TypeError(f"no farthest point known of a {type(shape).__name__}")


def _across(p: np.ndarray, axis: np.ndarray) -> float:
    return float(np.linalg.norm(p - (p @ axis) * axis))


@dataclass
class World:
    """Models in a discrete plant, with a Context to pose them in."""

    diagram: Diagram
    plant: MultibodyPlant
    scene_graph: SceneGraph
    root: Context
    instances: list[ModelInstanceIndex]

    @property
    def context(self) -> Context:
        return self.plant.GetMyMutableContextFromRoot(self.root)

    def query(self):
        """The QueryObject of the present poses."""
        return self.scene_graph.get_query_output_port().Eval(self.scene_graph.GetMyContextFromRoot(self.root))

    def geometries(self, instance: ModelInstanceIndex, role: Role):
        """(name, shape, X_WG) of all geometries of `instance` in `role`."""
        inspector = self.scene_graph.model_inspector()
        for body in self.plant.GetBodyIndices(instance):
            frame = self.plant.GetBodyFrameIdOrThrow(body)
            for geometry in inspector.GetGeometries(frame, role):
                name = inspector.GetName(geometry).split("::")[-1]
                yield name, inspector.GetShape(geometry), self.query().GetPoseInWorld(geometry)

    def contacts(self) -> list[tuple[str, str]]:
        """Names of the geometries that penetrate each other."""
        name = self.scene_graph.model_inspector().GetName
        return [(name(pair.id_A), name(pair.id_B)) for pair in self.query().ComputePointPairPenetration()]


@pytest.fixture
def arm_with_heading():
    """arm_with_heading(heading): the planar arm's URDF as text."""
    return _arm_with_heading


@pytest.fixture
def farthest():
    """farthest(shape, X_CG): the distance of a shape's farthest point from the origin of C."""
    return _farthest


@pytest.fixture
def make_world():
    """make_world(*models, floor=None): `models` are URIs or URDF text; `floor` may add ground."""

    def make(*models: str, floor=None) -> World:
        builder = DiagramBuilder()
        plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.005)
        parser = Parser(plant)
        parser.SetAutoRenaming(True)
        parser.package_map().AddPackageXml(str(package_xml()))
        instances = [
            (parser.AddModelsFromString(m, "urdf") if m.startswith("<") else parser.AddModelsFromUrl(m))[0]
            for m in models
        ]
        if floor is not None:
            floor(plant)
        plant.Finalize()
        diagram = builder.Build()
        return World(diagram, plant, scene_graph, diagram.CreateDefaultContext(), instances)

    return make
