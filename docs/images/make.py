"""Makes the pictures of the documentation from a recording: python docs/images/make.py out/recording.npz

case_ii.png shows a team on its way, rendered by Drake; case_ii_steps.png is the overview of all steps; field.png is a
navigation function, crossing.png and courier.png are of examples: these need no recording (see there).
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

import courier
import crossing
import field
import matplotlib.image
import numpy as np
from drake_ltl.diagrams import AddTransportPlant
from pydrake.geometry import (
    Box,
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    GeometryInstance,
    LightParameter,
    MakeRenderEngineVtk,
    PerceptionProperties,
    RenderCameraCore,
    RenderEngineVtkParams,
    RenderLabel,
    Rgba,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.sensors import CameraInfo, RgbdSensor

from drake_ltl.execution.recording import Recording
from drake_ltl.multibody import MeasureGeometry
from drake_ltl.scenario import loads
from drake_ltl.visualization.figures import write_report_figures

HERE = Path(__file__).parent


def main(path: str) -> None:
    """Writes the pictures next to this script."""
    field.main()
    crossing.main()
    courier.main()
    recording = Recording.load(path)
    carrying = np.flatnonzero((recording.mode >= 3).sum(axis=1) >= 2)
    image = render(recording, int(carrying[len(carrying) // 8]))
    matplotlib.image.imsave(HERE / "case_ii.png", image)
    with tempfile.TemporaryDirectory() as folder:
        write_report_figures(recording, loads(recording.scenario), folder)
        shutil.copy(Path(folder) / "steps.png", HERE / "case_ii_steps.png")


def render(recording: Recording, sample: int) -> np.ndarray:
    """(h, w, 3) picture of the team that carries something at that sample."""
    scenario = loads(recording.scenario)
    builder = DiagramBuilder()
    parts = AddTransportPlant(builder, scenario, MeasureGeometry(scenario))
    lights = [
        LightParameter(type="directional", direction=direction, frame="world", intensity=intensity)
        for direction, intensity in (([0.5, 0.3, -1.0], 1.0), ([1.0, -0.6, -0.3], 0.5))
    ]
    engine = MakeRenderEngineVtk(RenderEngineVtkParams(default_clear_color=[0.93, 0.95, 0.97], lights=lights))
    parts.scene_graph.AddRenderer("vtk", engine)
    mode = recording.mode[sample].max() - 3
    target = recording.object_origin[recording.objects[mode]][sample]
    _add_ground(parts, target)
    core = RenderCameraCore("vtk", CameraInfo(1100, 420, 0.32), ClippingRange(0.1, 100.0), RigidTransform())
    camera = RgbdSensor(
        parts.scene_graph.world_frame_id(),
        _look_at(target + np.array([-4.6, -1.6, 3.6]), target + np.array([0.5, 0.0, 0.1])),
        ColorRenderCamera(core),
        DepthRenderCamera(core, DepthRange(0.1, 50.0)),
    )
    builder.AddSystem(camera)
    builder.Connect(parts.scene_graph.get_query_output_port(), camera.query_object_input_port())
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    plant_context = parts.plant.GetMyMutableContextFromRoot(context)
    for name, instance in parts.agents.items():
        parts.plant.SetPositions(plant_context, instance, recording.q[name][sample])
    for name, instance in parts.objects.items():
        parts.plant.SetPositions(plant_context, instance, recording.pose[name][sample])
    image = camera.color_image_output_port().Eval(camera.GetMyContextFromRoot(context))
    return image.data[:, :, :3].copy()


def _add_ground(parts, target: np.ndarray) -> None:
    """A slab to stand on; the plant's floor is a half-space, which has no picture."""
    source = parts.scene_graph.RegisterSource("ground")
    slab = GeometryInstance(RigidTransform([target[0], target[1], -0.05]), Box(80.0, 80.0, 0.1), "ground")
    perception = PerceptionProperties()
    perception.AddProperty("phong", "diffuse", Rgba(0.85, 0.87, 0.89))
    perception.AddProperty("label", "id", RenderLabel.kDontCare)
    slab.set_perception_properties(perception)
    parts.scene_graph.RegisterAnchoredGeometry(source, slab)


def _look_at(p_WE: np.ndarray, p_WT: np.ndarray) -> RigidTransform:
    """X_WC of a camera at p_WE that looks at p_WT: z forward, y down."""
    z = (p_WT - p_WE) / np.linalg.norm(p_WT - p_WE)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    return RigidTransform(RotationMatrix(np.column_stack([x, np.cross(z, x), z])), p_WE)


if __name__ == "__main__":
    main(*sys.argv[1:])
