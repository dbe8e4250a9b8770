"""Differential drives on a floor as one Drake diagram: plant, navigation field and controllers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from drake_ltl.diagrams.quiet import without_half_space_warning
from pydrake.geometry import HalfSpace, Meshcat, MeshcatVisualizer, SceneGraph
from pydrake.multibody.plant import AddMultibodyPlant, CoulombFriction, MultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, VectorLogSink

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.multibody.differential_drive_model import (
    DIFFERENTIAL_DRIVE,
    AddDifferentialDrive,
    DifferentialDriveModel,
)
from drake_ltl.navigation import RegionBall, StaticBody, Traveller, step_relations
from drake_ltl.navigation.dipolar_field import DipolarField
from drake_ltl.navigation.dipole import Dipole
from drake_ltl.navigation.unicycle import DEFAULT_GAINS, UnicycleGains
from drake_ltl.systems.differential_drive_controller import DifferentialDriveController
from drake_ltl.systems.drive_field import DriveField

FLOOR = CoulombFriction(1.0, 1.0)
"""Rubber on a dry floor, as the tyres of the shipped model have it."""
SUNK = 1e-4
"""How deep the wheels start in the floor, which is about how deep they stand in it [m]."""

Pose = tuple[float, float, float]
"""x [m], y [m], heading [rad]."""


@dataclass(frozen=True)
class Drive:
    """One differential drive: where it starts and where it goes."""

    name: str
    start: Pose
    goal: Pose
    model: str = DIFFERENTIAL_DRIVE


@dataclass(frozen=True)
class DriveSettings:
    """What all drives share."""

    workspace_radius: float = 8.0
    """[m], about the world's origin."""
    force: float = 20.0
    """k [N]."""
    kappa: float = 12.0
    ratio: float = 0.25
    """Of the dipoles, as their reach."""
    reach: float = 1.0
    """[m]"""
    gains: UnicycleGains = DEFAULT_GAINS
    time_step: float = 0.005
    """[s]"""


@dataclass(frozen=True)
class DriveDiagram:
    """A built diagram and the parts of it that a user talks to."""

    diagram: Diagram
    plant: MultibodyPlant
    scene_graph: SceneGraph
    instances: Mapping[str, ModelInstanceIndex]
    models: Mapping[str, DifferentialDriveModel]
    field: DipolarField
    controllers: Mapping[str, DifferentialDriveController]
    logs: Mapping[str, VectorLogSink]
    """`lyapunov`, and for every drive `state_<name>`, `torque_<name>` and `stage_<name>`, at each step of the plant."""
    drives: tuple[Drive, ...]
    obstacles: tuple[StaticBody, ...]

    def CreateStartContext(self) -> Context:
        """A context with every drive on its wheels at its start, at rest."""
        with without_half_space_warning():
            context = self.diagram.CreateDefaultContext()
        plant_context = self.plant.GetMyMutableContextFromRoot(context)
        for drive in self.drives:
            q = self.models[drive.name].positions(*drive.start, z=-SUNK)
            self.plant.SetPositions(plant_context, self.instances[drive.name], q)
        return context


def MakeDriveDiagram(
    drives: Sequence[Drive],
    settings: DriveSettings | None = None,
    *,
    obstacles: Sequence[StaticBody] = (),
    meshcat: Meshcat | None = None,
) -> DriveDiagram:
    """Assembles the diagram in which `drives` go to their goals, around each other and around `obstacles`.

    Raises:
        InvalidInputError: names that are not distinct, models that cannot be used, spheres that overlap at the start or
            at the goal, or leave the workspace.
    """
    settings = settings or DriveSettings()
    builder = DiagramBuilder()
    models = {drive.name: DifferentialDriveModel(drive.name, drive.model) for drive in drives}
    field = _make_field(drives, models, settings, obstacles)
    config = MultibodyPlantConfig(time_step=settings.time_step, discrete_contact_approximation="lagged")
    plant, scene_graph = AddMultibodyPlant(config, builder)
    plant.set_name("plant")
    pose = HalfSpace.MakePose(np.array([0.0, 0.0, 1.0]), np.zeros(3))
    plant.RegisterCollisionGeometry(plant.world_body(), pose, HalfSpace(), "floor", FLOOR)
    instances = {drive.name: AddDifferentialDrive(plant, drive.name, drive.model) for drive in drives}
    plant.Finalize()
    drive_field = builder.AddSystem(DriveField(field, models))
    period = settings.time_step  # not at every step of the simulator, of which a viewer adds some of its own
    logs = {"lyapunov": LogVectorOutput(drive_field.get_lyapunov_output_port(), builder, period)}
    controllers = {}
    for name, dipole in zip(models, field.dipoles, strict=True):
        state = plant.get_state_output_port(instances[name])
        controller = builder.AddSystem(DifferentialDriveController(models[name], dipole, settings.gains))
        builder.Connect(state, drive_field.get_state_input_port(name))
        builder.Connect(state, controller.get_state_input_port())
        builder.Connect(drive_field.get_force_output_port(name), controller.get_force_input_port())
        builder.Connect(controller.get_torque_output_port(), plant.get_actuation_input_port(instances[name]))
        logs[f"state_{name}"] = LogVectorOutput(state, builder, period)
        logs[f"torque_{name}"] = LogVectorOutput(controller.get_torque_output_port(), builder, period)
        logs[f"stage_{name}"] = LogVectorOutput(controller.get_stage_output_port(), builder, period)
        controllers[name] = controller
    for name, log in logs.items():
        log.set_name(f"log_{name}")
    if meshcat is not None:
        MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat)
    diagram = builder.Build()
    diagram.set_name("differential_drives")
    return DriveDiagram(
        diagram, plant, scene_graph, instances, models, field, controllers, logs, tuple(drives), tuple(obstacles)
    )


def _make_field(
    drives: Sequence[Drive],
    models: Mapping[str, DifferentialDriveModel],
    settings: DriveSettings,
    obstacles: Sequence[StaticBody],
) -> DipolarField:
    home = RegionBall("workspace", (0.0, 0.0, 0.0), settings.workspace_radius)
    travellers = [
        Traveller(
            drive.name,
            models[drive.name].radius,
            home.name,
            home.name,
            (*drive.start[:2], models[drive.name].height),
            (*drive.goal[:2], models[drive.name].height),
        )
        for drive in drives
    ]
    step = step_relations(
        travellers=travellers,
        static_objects=obstacles,
        regions=[home],
        workspace_radius=settings.workspace_radius,
    )
    if violated := step.relations.violated(step.start):
        raise InvalidInputError([Mistake("start", f"violates {v}", "place the bodies apart") for v in violated])
    dipoles = [Dipole(drive.goal[:2], drive.goal[2], settings.ratio, settings.reach) for drive in drives]
    return DipolarField.of(step, dipoles, force=settings.force, kappa=settings.kappa)
