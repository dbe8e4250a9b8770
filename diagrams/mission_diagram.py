"""The whole mission as one Drake diagram: plant, navigation field, controllers, switches and supervisor."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

import numpy as np
from drake_ltl.diagrams.fault_parts import AddDrives, AddFaultMonitors, AddSensors, FaultParts
from drake_ltl.diagrams.monitors import MONITORS, AddMonitors
from drake_ltl.diagrams.quiet import without_half_space_warning
from drake_ltl.diagrams.separate_controllers import AddSeparateControllers
from drake_ltl.diagrams.transport_plant import AddTransportPlant, TransportPlant
from pydrake.geometry import Meshcat
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, LeafSystem, OutputPort
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput, MatrixGain, VectorLogSink

from drake_ltl.monitoring.violation import Violation
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.planning.mission import Layout, Mission
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.doors import Doors
from drake_ltl.systems.drives import Drives
from drake_ltl.systems.fault_monitors import FaultMonitor
from drake_ltl.systems.mission_controller import MissionController
from drake_ltl.systems.monitors import Monitor
from drake_ltl.systems.plan_supervisor import PlanSupervisor
from drake_ltl.systems.program import MissionProgram, mission_program, start_configuration
from drake_ltl.systems.state_places import StatePlaces
from drake_ltl.systems.supervision import Supervision
from drake_ltl.visualization.meshcat_scene import AddMissionVisualizer


@dataclass(frozen=True)
class MissionDiagram:
    """A built diagram and the parts of it that a runner or a user talks to."""

    diagram: Diagram
    transport_plant: TransportPlant
    support: ConstantVectorSource
    """Bears objects that rest, see `execution.resting`."""
    supervisor: PlanSupervisor
    logs: Mapping[str, VectorLogSink]
    """`state`, `torque` (of all agents as commanded, stacked; V may stand behind) and the supervisor's `record`, at
    every step of the plant."""
    program: MissionProgram
    scenario: Scenario
    models: MeasuredModels
    monitors: Mapping[str, Monitor] = field(default_factory=dict)
    """By name; none if the diagram was made without."""
    drives: Drives | None = None
    """Where faults are looked for."""
    doors: Doors | None = None
    """Likewise."""
    fault_monitors: tuple[FaultMonitor, ...] = ()

    def CreateStartContext(self) -> Context:
        """A context with every body at its start, at rest, and every weld inactive."""
        with without_half_space_warning():
            context = self.diagram.CreateDefaultContext()
        plant = self.transport_plant.plant
        plant_context = plant.GetMyMutableContextFromRoot(context)
        self.transport_plant.ReleaseAll(plant_context)
        _place(self, plant_context, self.program.mission.steps[0].before)
        return context

    def violations(self, root_context: Context) -> tuple[Violation, ...]:
        """All that the monitors have seen so far, in order of time."""
        contexts = [(monitor, monitor.GetMyContextFromRoot(root_context)) for monitor in self.monitors.values()]
        found = [violation for monitor, context in contexts for violation in monitor.violations(context)]
        return tuple(sorted(found, key=lambda violation: violation.time))


def MakeMissionDiagram(
    mission: Mission,
    scenario: Scenario,
    models: MeasuredModels,
    *,
    num_steps: int,
    meshcat: Meshcat | None = None,
    builder: DiagramBuilder | None = None,
    separate_controllers: bool = False,
    own_controllers: Mapping[str, LeafSystem] | None = None,
    monitors: bool | Collection[str] = True,
    program: MissionProgram | None = None,
    holds: Mapping[str, int] | None = None,
    faults: FaultParts | None = None,
) -> MissionDiagram:
    """Assembles the diagram that carries out the mission's first `num_steps` steps and then holds.

    Args:
        meshcat: shows the mission while it runs; None runs it unseen.
        builder: one to which a user has added systems already; it is built here.
        separate_controllers: one system for each control law, agent and object, with switches among them, for those
            who want to see them or put another in place of one; a run takes twice as long. By default one system has
            all laws, to the same effect but for rounding.
        own_controllers: systems that take the place of separate controllers, by the names of these
            (`transition_<agent>`, `hold_<agent>`, `reach_<agent>`, `transport_<object>`), with the same ports.
        monitors: whether systems watch that nothing goes wrong, or the names of those that do (docs/monitors.md).
        program: what is carried out in place of the mission's steps.
        holds: agent -> index of the weld with which it begins.
        faults: with drives that can fail, sensors as the scenario has them, and monitors that notice.

    Raises:
        InvalidInputError: there is no controller of such a name, or a port is missing or of another size.
    """
    unseen = meshcat is None and builder is None  # who brings a builder may look at the scene with systems of their own
    builder = DiagramBuilder() if builder is None else builder
    transport_plant = AddTransportPlant(builder, scenario, models, sampled_outputs=False, visible=not unseen)
    transport_plant.plant.set_name("plant")
    plant, support = transport_plant.plant, _add_support(builder, transport_plant)
    program = program or mission_program(mission, models, scenario)
    ignored = frozenset() if faults is None else faults.ignored
    supervision = Supervision(program, scenario, models, num_steps, holds=holds, ignored=ignored)
    places = StatePlaces.of(plant, transport_plant.agents, transport_plant.objects)
    supervisor = builder.AddSystem(PlanSupervisor(places, supervision, models, scenario.controller.period))
    seen, age = plant.get_state_output_port(), None
    if faults is not None:
        seen, age = AddSensors(builder, scenario, transport_plant)
    builder.Connect(seen, supervisor.get_state_input_port())
    parts = (builder, program, scenario, models, transport_plant, supervisor)
    if separate_controllers or own_controllers:
        torque = controls = AddSeparateControllers(*parts, own_controllers)
    else:
        torque, controls = _add_controller(*parts, places, seen)
    driving, drives, doors, fault_monitors = torque, None, None, ()
    if faults is not None:
        drives, doors = AddDrives(builder, models, torque), builder.AddSystem(Doors(scenario.region_names))
        driving = drives.get_delivered_output_port()
        fault_monitors = AddFaultMonitors(
            builder, faults, scenario, models, transport_plant, supervisor, seen, age, torque, drives, doors
        )
    _drive(builder, transport_plant, driving)
    if meshcat is not None:
        AddMissionVisualizer(
            builder,
            transport_plant=transport_plant,
            supervisor=supervisor,
            scenario=scenario,
            models=models,
            meshcat=meshcat,
        )
    watching = {}
    if monitors:
        watching = AddMonitors(
            builder,
            MONITORS if monitors is True else frozenset(monitors),
            transport_plant=transport_plant,
            supervisor=supervisor,
            torque=torque,
            controls=controls,
            program=program,
            scenario=scenario,
            models=models,
        )
    logs = {
        "state": LogVectorOutput(transport_plant.plant.get_state_output_port(), builder),
        "torque": LogVectorOutput(torque, builder),
        "record": LogVectorOutput(supervisor.get_record_output_port(), builder),
    }
    for name, log in logs.items():
        log.set_name(f"log_{name}")
    diagram = builder.Build()
    diagram.set_name(scenario.name)
    return MissionDiagram(
        diagram,
        transport_plant,
        support,
        supervisor,
        logs,
        program,
        scenario,
        models,
        watching,
        drives,
        doors,
        fault_monitors,
    )


def _add_support(builder: DiagramBuilder, transport_plant: TransportPlant) -> ConstantVectorSource:
    """What bears objects that rest, in place of the floor: generalized forces, zero until `execution.Resting` looks."""
    plant = transport_plant.plant
    support = builder.AddSystem(ConstantVectorSource(np.zeros(plant.num_velocities())))
    support.set_name("support")
    builder.Connect(support.get_output_port(), plant.get_applied_generalized_force_input_port())
    return support


def _add_controller(
    builder: DiagramBuilder,
    program: MissionProgram,
    scenario: Scenario,
    models: MeasuredModels,
    transport_plant: TransportPlant,
    supervisor: PlanSupervisor,
    places: StatePlaces,
    state: OutputPort,
) -> tuple[OutputPort, OutputPort]:
    """All control laws in one system. Returns the torques of all agents' joints, stacked (sum n_i,), and the same with
    V behind."""
    controller = builder.AddSystem(MissionController(places, program, scenario, models))
    builder.Connect(state, controller.get_state_input_port())
    builder.Connect(supervisor.get_progress_output_port(), controller.get_progress_input_port())
    return controller.get_torque_output_port(), controller.get_controls_output_port()


def _drive(builder: DiagramBuilder, transport_plant: TransportPlant, torque: OutputPort) -> None:
    """Connects all agents' torques; the plant cuts them off at the effort limits."""
    plant = transport_plant.plant
    numbers = np.arange(plant.num_velocities(), dtype=float)
    rows = np.concatenate([plant.GetVelocitiesFromArray(i, numbers) for i in transport_plant.agents.values()])
    by_torque = plant.MakeActuationMatrix()[rows.astype(int)].T  # a file's transmissions may have any order
    more = torque.size() - by_torque.shape[1]  # V, which moves nothing
    actuation = builder.AddSystem(MatrixGain(np.column_stack([by_torque, np.zeros((len(by_torque), more))])))
    actuation.set_name("actuation")
    builder.Connect(torque, actuation.get_input_port())
    builder.Connect(actuation.get_output_port(), plant.get_actuation_input_port())


def _place(mission_diagram: MissionDiagram, plant_context: Context, layout: Layout) -> None:
    plant, parts = mission_diagram.transport_plant.plant, mission_diagram.transport_plant
    for name, stand in layout.agents.items():
        plant.SetPositions(plant_context, parts.agents[name], start_configuration(stand, name, mission_diagram.models))
    for name, p_WO in layout.objects.items():
        body = plant.GetBodyByName(mission_diagram.models.objects[name].body_name, parts.objects[name])
        X_WO = mission_diagram.models.objects[name].pose(np.asarray(p_WO), layout.headings[name])
        plant.SetFreeBodyPose(plant_context, body, X_WO)
