"""The scene of a mission in Meshcat: workspace, regions and names, robots in their colours, spheres."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from pydrake.geometry import (
    IllustrationProperties,
    Meshcat,
    MeshcatParams,
    MeshcatVisualizer,
    MeshcatVisualizerParams,
    Rgba,
    Role,
    Sphere,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import DiagramBuilder

from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.scenario.model import Region, Scenario
from drake_ltl.systems.plan_supervisor import PlanSupervisor
from drake_ltl.visualization.mission_overlay import PATH, PUBLISH_PERIOD, MissionOverlay, let_through, set_text
from drake_ltl.visualization.palette import (
    FLOOR,
    GRID,
    INK,
    MUTED,
    REGION,
    SKY_BOTTOM,
    SKY_TOP,
    Colour,
    agent_colours,
    mixed,
)

if TYPE_CHECKING:  # diagrams are assembled with this module
    from drake_ltl.diagrams.transport_plant import TransportPlant

ACCENT_PREFIX = "accent"
"""Visual geometries of an agent that begin with this are painted in the agent's colour."""
LAYER = 0.02
"""Rim, floor, grid and regions lie this far above one another [m], all below the wheels, and do not flicker."""
DISC_CORNERS = 128
REGION_DISC_OPACITY, REGION_BALL_OPACITY = 0.55, 0.10
AMBIENT_LIGHT, SUNLIGHT = 2.5, 2.3
CAMERA_ELEVATION = np.deg2rad(54.0)
CAMERA_DISTANCE = 3.1
"""In workspace radii: all of the workspace is seen in a window of 16 : 10."""
FIELD_OF_VIEW = 35.0
"""Vertical [degrees]: narrow, so that what is far is not much smaller."""
NAME_HEIGHT = 0.06
"""Of letters' plates in workspace radii."""


@dataclass(frozen=True)
class MissionVisualizer:
    """The two systems that AddMissionVisualizer adds."""

    bodies: MeshcatVisualizer
    overlay: MissionOverlay


LOCALHOST = "localhost"


def MakeMeshcat(port: int | None = None, host: str = LOCALHOST) -> Meshcat:
    """A Meshcat that only this computer can reach; a free port is taken unless one is given.

    Args:
        host: an address of this computer at which others can reach it, or "*" for all of them. Meshcat has no
            passwords: whoever reaches it sees the run.

    It is made silently: whoever wants it watched tells people its `web_url()`.
    """
    logger = logging.getLogger("drake")
    level = logger.level
    logger.setLevel(logging.WARNING)
    try:
        return Meshcat(MeshcatParams(host=host, port=port))
    finally:
        logger.setLevel(level)


def AddMissionVisualizer(
    builder: DiagramBuilder,
    *,
    transport_plant: TransportPlant,
    supervisor: PlanSupervisor,
    scenario: Scenario,
    models: MeasuredModels,
    meshcat: Meshcat,
) -> MissionVisualizer:
    """Draws the scenario's workspace into `meshcat` and adds what shows the mission there while it runs.

    The agents' accents take the agents' colours in the plant's SceneGraph: call it before the diagram is built.
    """
    _paint_agents(transport_plant)
    DrawWorkspace(meshcat, scenario)
    params = MeshcatVisualizerParams(publish_period=PUBLISH_PERIOD, role=Role.kIllustration, prefix="bodies")
    bodies = MeshcatVisualizer.AddToBuilder(builder, transport_plant.scene_graph, meshcat, params)
    height = NAME_HEIGHT * scenario.workspace_radius
    overlay = builder.AddSystem(MissionOverlay(models, meshcat, name_height=height, name_tilt=CAMERA_ELEVATION))
    builder.Connect(supervisor.get_status_output_port(), overlay.get_status_input_port())
    for name, instance in (transport_plant.agents | transport_plant.objects).items():
        builder.Connect(transport_plant.plant.get_state_output_port(instance), overlay.get_state_input_port(name))
    return MissionVisualizer(bodies, overlay)


def DrawWorkspace(meshcat: Meshcat, scenario: Scenario) -> None:
    """Floor with a grid, regions with their names, background and camera: all that does not move."""
    radius = scenario.workspace_radius
    meshcat.Delete(PATH)
    for path in ("/Grid", "/Axes"):
        meshcat.SetProperty(path, "visible", False)
    meshcat.SetProperty("/Background/<object>", "top_color", list(SKY_TOP))
    meshcat.SetProperty("/Background/<object>", "bottom_color", list(SKY_BOTTOM))
    _place_lights(meshcat)
    _draw_floor(meshcat, radius)
    for region in scenario.regions:
        _draw_region(meshcat, region, NAME_HEIGHT * radius)
    _place_camera(meshcat, radius)


def _draw_floor(meshcat: Meshcat, radius: float) -> None:
    _disc(meshcat, f"{PATH}/floor/disc", radius, -3 * LAYER, Rgba(*FLOOR))
    _disc(meshcat, f"{PATH}/floor/rim", 1.01 * radius, -4 * LAYER, Rgba(*mixed(MUTED, FLOOR, 0.4)))
    spacing = grid_spacing(radius)
    ticks = spacing * np.arange(-np.floor(radius / spacing), np.floor(radius / spacing) + 1)
    half = np.sqrt(np.maximum(radius**2 - ticks**2, 0.0))
    z = np.full_like(ticks, -2 * LAYER)
    start = np.hstack([np.stack([ticks, -half, z]), np.stack([-half, ticks, z])])
    end = np.hstack([np.stack([ticks, half, z]), np.stack([half, ticks, z])])
    meshcat.SetLineSegments(f"{PATH}/floor/grid", start, end, rgba=Rgba(*GRID))


def _draw_region(meshcat: Meshcat, region: Region, name_height: float) -> None:
    path, (x, y, z) = f"{PATH}/regions/{region.name}", region.centre
    disc = np.sqrt(max(region.radius**2 - z**2, 0.0))
    if disc > 0.0:
        colour = Rgba(*mixed(REGION, FLOOR, 1 - REGION_DISC_OPACITY))
        _disc(meshcat, f"{path}/disc", disc, -LAYER, colour, (x, y))
        _ring(meshcat, f"{path}/ring", disc, 0.0, Rgba(*REGION), (x, y))
    meshcat.SetObject(f"{path}/ball", Sphere(region.radius), Rgba(*REGION, REGION_BALL_OPACITY))
    meshcat.SetTransform(f"{path}/ball", RigidTransform(np.array(region.centre)))
    let_through(meshcat, f"{path}/ball")
    set_text(meshcat, f"{path}/name", region.name, name_height, mixed(MUTED, INK, 0.5))
    p_WN = np.array([x, y - region.radius - 0.7 * name_height, 0.02])
    meshcat.SetTransform(f"{path}/name", RigidTransform(RotationMatrix.MakeXRotation(-np.pi / 2), p_WN))


def _disc(meshcat: Meshcat, path: str, radius: float, z: float, rgba: Rgba, at=(0.0, 0.0)) -> None:
    """A flat disc at height z; a cylinder of Meshcat's would show its corners."""
    vertices = np.hstack([np.zeros((3, 1)), _circle(radius)])
    corners = 1 + np.arange(DISC_CORNERS, dtype=np.int32)
    faces = np.stack([np.zeros_like(corners), corners, np.roll(corners, -1)])
    meshcat.SetTriangleMesh(path, vertices, faces, rgba)
    meshcat.SetTransform(path, RigidTransform(np.array([*at, z])))


def _ring(meshcat: Meshcat, path: str, radius: float, z: float, rgba: Rgba, at=(0.0, 0.0)) -> None:
    """A circle of one pixel's width."""
    circle = _circle(radius)
    meshcat.SetLine(path, np.hstack([circle, circle[:, :1]]), rgba=rgba)
    meshcat.SetTransform(path, RigidTransform(np.array([*at, z])))


def _circle(radius: float) -> np.ndarray:
    """(3, DISC_CORNERS) points."""
    angles = 2 * np.pi / DISC_CORNERS * np.arange(DISC_CORNERS)
    return np.stack([radius * np.cos(angles), radius * np.sin(angles), np.zeros(DISC_CORNERS)])


def _place_lights(meshcat: Meshcat) -> None:
    """Even light over the whole workspace: Meshcat's own lamps hang near the origin and light a few metres."""
    for lamp in ("SpotLight", "PointLightNegativeX", "PointLightPositiveX"):
        meshcat.SetProperty(f"/Lights/{lamp}", "visible", False)
    meshcat.SetProperty("/Lights/AmbientLight/<object>", "intensity", AMBIENT_LIGHT)
    meshcat.SetProperty("/Lights/FillLight/<object>", "intensity", SUNLIGHT)
    meshcat.SetProperty("/Lights/FillLight/<object>", "position", [-8.0, 20.0, 12.0])  # y up


def _place_camera(meshcat: Meshcat, radius: float) -> None:
    """Looks from the south; near and far planes fit the workspace, so that thin layers stay apart."""
    target = np.array([0.0, -0.12 * radius, 0.0])
    away = CAMERA_DISTANCE * radius * np.array([0.0, -np.cos(CAMERA_ELEVATION), np.sin(CAMERA_ELEVATION)])
    camera = Meshcat.PerspectiveCamera(fov=FIELD_OF_VIEW, aspect=1.6, near=0.02 * radius, far=30.0 * radius)
    meshcat.SetCamera(camera)
    meshcat.SetCameraPose(target + away, target)


def grid_spacing(radius: float) -> float:
    """A round length [m], a fifth to a twelfth of the radius."""
    power = 10.0 ** np.floor(np.log10(radius / 5))
    return float(power * max(factor for factor in (1, 2, 5) if factor * power <= radius / 5 * (1 + 1e-9)))


def _paint_agents(transport_plant: TransportPlant) -> None:
    plant, scene_graph = transport_plant.plant, transport_plant.scene_graph
    inspector = scene_graph.model_inspector()
    colours: dict[str, Colour] = agent_colours(tuple(transport_plant.agents))
    for name, instance in transport_plant.agents.items():
        for index in plant.GetBodyIndices(instance):
            for geometry in plant.GetVisualGeometriesForBody(plant.get_body(index)):
                if not inspector.GetName(geometry).split("::")[-1].startswith(ACCENT_PREFIX):
                    continue
                properties = IllustrationProperties(inspector.GetIllustrationProperties(geometry))
                properties.UpdateProperty("phong", "diffuse", Rgba(*colours[name]))
                scene_graph.RemoveRole(plant.get_source_id(), geometry, Role.kIllustration)
                scene_graph.AssignRole(plant.get_source_id(), geometry, properties)
