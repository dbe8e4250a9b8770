"""The whole mission as one Drake diagram: plant, navigation field, controllers, switches and supervisor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from drake_ltl.diagrams.quiet import without_half_space_warning
from drake_ltl.diagrams.transport_plant import AddTransportPlant, TransportPlant
from pydrake.geometry import Meshcat
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import LogVectorOutput, MatrixGain, PortSwitch, VectorLogSink

from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.planning.mission import Layout, Mission
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.hold_controller import HoldController
from drake_ltl.systems.navigation_field import NavigationField
from drake_ltl.systems.plan_supervisor import PlanSupervisor
from drake_ltl.systems.program import MissionProgram, mission_program, start_configuration
from drake_ltl.systems.reach_controller import ReachController
from drake_ltl.systems.supervision import Supervision
from drake_ltl.systems.transition_controller import TransitionController
from drake_ltl.systems.transport_controller import TransportController
from drake_ltl.visualization.meshcat_scene import AddMissionVisualizer


@dataclass(frozen=True)
class MissionDiagram:
    """A built diagram and the parts of it that a runner or a user talks to."""

    diagram: Diagram
    transport_plant: TransportPlant
    supervisor: PlanSupervisor
    field: NavigationField
    logs: Mapping[str, VectorLogSink]
    """`state`, `lyapunov`, `torque_<agent>` as commanded, and the supervisor's `status`, `step` and `reach_<agent>`, at
    every step of the plant."""
    program: MissionProgram
    scenario: Scenario
    models: MeasuredModels

    def CreateStartContext(self) -> Context:
        """A context with every body at its start, at rest, and every weld inactive."""
        with without_half_space_warning():
            context = self.diagram.CreateDefaultContext()
        plant = self.transport_plant.plant
        plant_context = plant.GetMyMutableContextFromRoot(context)
        self.transport_plant.ReleaseAll(plant_context)
        _place(self, plant_context, self.program.mission.steps[0].before)
        return context


def MakeMissionDiagram(
    mission: Mission,
    scenario: Scenario,
    models: MeasuredModels,
    *,
    num_steps: int,
    meshcat: Meshcat | None = None,
    builder: DiagramBuilder | None = None,
) -> MissionDiagram:
    """Assembles the diagram that carries out the mission's first `num_steps` steps and then holds.

    Args:
        meshcat: shows the mission while it runs; None runs it unseen.
        builder: one to which a user has added systems already; it is built here.
    """
    builder = DiagramBuilder() if builder is None else builder
    transport_plant = AddTransportPlant(builder, scenario, models)
    transport_plant.plant.set_name("plant")
    program = mission_program(mission, models, scenario)
    supervision = Supervision(program, scenario, models, num_steps)
    supervisor = builder.AddSystem(PlanSupervisor(supervision, models, scenario.controller.period))
    field = builder.AddSystem(NavigationField(program, scenario, models))
    _connect_states(builder, transport_plant, supervisor, field)
    builder.Connect(supervisor.get_step_output_port(), field.get_step_input_port())
    builder.Connect(supervisor.get_anchor_output_port(), field.get_anchor_input_port())
    transports = {
        name: _add_transport(builder, name, scenario, models, transport_plant, supervisor, field)
        for name in transport_plant.objects
    }
    torques = {
        agent: _add_agent(builder, agent, scenario, models, transport_plant, supervisor, field, transports)
        for agent in transport_plant.agents
    }
    if meshcat is not None:
        AddMissionVisualizer(
            builder,
            transport_plant=transport_plant,
            supervisor=supervisor,
            scenario=scenario,
            models=models,
            meshcat=meshcat,
        )
    logs = {
        "state": LogVectorOutput(transport_plant.plant.get_state_output_port(), builder),
        "lyapunov": LogVectorOutput(field.get_lyapunov_output_port(), builder),
        "status": LogVectorOutput(supervisor.get_status_output_port(), builder),
        "step": LogVectorOutput(supervisor.get_step_output_port(), builder),
    }
    for agent in transport_plant.agents:
        logs[f"reach_{agent}"] = LogVectorOutput(supervisor.get_reach_output_port(agent), builder)
        logs[f"torque_{agent}"] = LogVectorOutput(torques[agent], builder)
    for name, log in logs.items():
        log.set_name(f"log_{name}")
    diagram = builder.Build()
    diagram.set_name(scenario.name)
    return MissionDiagram(diagram, transport_plant, supervisor, field, logs, program, scenario, models)


def _connect_states(
    builder: DiagramBuilder, transport_plant: TransportPlant, supervisor: PlanSupervisor, field: NavigationField
) -> None:
    for name, instance in (transport_plant.agents | transport_plant.objects).items():
        state = transport_plant.plant.get_state_output_port(instance)
        builder.Connect(state, supervisor.get_state_input_port(name))
        builder.Connect(state, field.get_state_input_port(name))


def _add_transport(
    builder: DiagramBuilder,
    name: str,
    scenario: Scenario,
    models: MeasuredModels,
    transport_plant: TransportPlant,
    supervisor: PlanSupervisor,
    field: NavigationField,
) -> TransportController:
    settings = scenario.controller
    damping = np.repeat([settings.team_rotation_damping, settings.team_damping], 3)
    controller = builder.AddSystem(
        TransportController(models.objects[name], models.agents, damping, settings.speed_limit)
    )
    plant = transport_plant.plant
    builder.Connect(
        plant.get_state_output_port(transport_plant.objects[name]), controller.get_object_state_input_port()
    )
    builder.Connect(field.get_gradient_output_port(name), controller.get_gradient_input_port())
    builder.Connect(supervisor.get_shares_output_port(name), controller.get_shares_input_port())
    for agent, instance in transport_plant.agents.items():
        builder.Connect(plant.get_state_output_port(instance), controller.get_agent_state_input_port(agent))
        if models.agents[agent].is_redundant:
            builder.Connect(supervisor.get_anchor_output_port(agent), controller.get_anchor_input_port(agent))
    return controller


def _add_agent(
    builder: DiagramBuilder,
    agent: str,
    scenario: Scenario,
    models: MeasuredModels,
    transport_plant: TransportPlant,
    supervisor: PlanSupervisor,
    field: NavigationField,
    transports: Mapping[str, TransportController],
) -> OutputPort:
    """The agent's own controllers and the switch that selects among them, in the order of signals.Mode.

    Returns the switch's output: the torque (n,) of every joint, before the plant cuts it off at the effort limits.
    """
    model, settings = models.agents[agent], scenario.controller
    state = transport_plant.plant.get_state_output_port(transport_plant.agents[agent])
    damping = model.damping(settings.base_damping, settings.arm_damping)

    hold = builder.AddSystem(HoldController(model))
    builder.Connect(supervisor.get_hold_output_port(agent), hold.get_hold_input_port())
    transition = builder.AddSystem(TransitionController(model, damping, settings.speed_limit))
    builder.Connect(field.get_gradient_output_port(agent), transition.get_gradient_input_port())
    reach = builder.AddSystem(ReachController(model))
    builder.Connect(supervisor.get_reach_output_port(agent), reach.get_reach_input_port())
    builder.Connect(supervisor.get_reach_output_port(agent), field.get_reach_input_port(agent))
    for controller in (hold, transition, reach):
        builder.Connect(state, controller.get_state_input_port())

    switch = builder.AddSystem(PortSwitch(model.n))
    switch.set_name(f"switch_{agent}")
    builder.Connect(supervisor.get_mode_output_port(agent), switch.get_port_selector_input_port())
    for controller in (hold, transition, reach):
        port = switch.DeclareInputPort(controller.get_name().removesuffix(f"_{agent}"))
        builder.Connect(controller.get_torque_output_port(), port)
    for obj, transport in transports.items():
        builder.Connect(transport.get_torque_output_port(agent), switch.DeclareInputPort(f"transport_{obj}"))
    actuation = builder.AddSystem(MatrixGain(model.plant.MakeActuationMatrix().T))
    actuation.set_name(f"actuation_{agent}")  # from joints to actuators: the file's transmissions may have any order
    builder.Connect(switch.get_output_port(), actuation.get_input_port())
    builder.Connect(
        actuation.get_output_port(),
        transport_plant.plant.get_actuation_input_port(transport_plant.agents[agent]),
    )
    return switch.get_output_port()


def _place(mission_diagram: MissionDiagram, plant_context: Context, layout: Layout) -> None:
    plant, parts = mission_diagram.transport_plant.plant, mission_diagram.transport_plant
    for name, stand in layout.agents.items():
        plant.SetPositions(plant_context, parts.agents[name], start_configuration(stand, name, mission_diagram.models))
    for name, p_WO in layout.objects.items():
        body = plant.GetBodyByName(mission_diagram.models.objects[name].body_name, parts.objects[name])
        X_WO = mission_diagram.models.objects[name].pose(np.asarray(p_WO), layout.headings[name])
        plant.SetFreeBodyPose(plant_context, body, X_WO)
