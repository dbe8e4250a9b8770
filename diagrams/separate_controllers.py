"""Control laws as one system for each law, agent and object, and switches that select among them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from drake_ltl.diagrams.transport_plant import TransportPlant
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import Multiplexer, PortSwitch

from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.hold_controller import HoldController
from drake_ltl.systems.navigation_field import NavigationField
from drake_ltl.systems.plan_supervisor import PlanSupervisor
from drake_ltl.systems.program import MissionProgram
from drake_ltl.systems.reach_controller import ReachController
from drake_ltl.systems.transition_controller import TransitionController
from drake_ltl.systems.transport_controller import TransportController


def AddSeparateControllers(
    builder: DiagramBuilder,
    program: MissionProgram,
    scenario: Scenario,
    models: MeasuredModels,
    transport_plant: TransportPlant,
    supervisor: PlanSupervisor,
) -> OutputPort:
    """Adds navigation field, controllers and switches.

    Returns the torques of all agents' joints, stacked, then V (sum n_i + 1,).
    """
    plant = transport_plant.plant
    field = builder.AddSystem(NavigationField(program, scenario, models))
    for name, instance in (transport_plant.agents | transport_plant.objects).items():
        builder.Connect(plant.get_state_output_port(instance), field.get_state_input_port(name))
    builder.Connect(supervisor.get_step_output_port(), field.get_step_input_port())
    builder.Connect(supervisor.get_anchor_output_port(), field.get_anchor_input_port())
    transports = {
        name: _add_transport(builder, name, scenario, models, transport_plant, supervisor, field)
        for name in transport_plant.objects
    }
    stack = builder.AddSystem(Multiplexer([*(model.n for model in models.agents.values()), 1]))
    stack.set_name("controls")
    for index, agent in enumerate(transport_plant.agents):
        torque = _add_agent(builder, agent, scenario, models, transport_plant, supervisor, field, transports)
        builder.Connect(torque, stack.get_input_port(index))
    builder.Connect(field.get_lyapunov_output_port(), stack.get_input_port(len(models.agents)))
    return stack.get_output_port()


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

    Returns the switch's output: the torque (n,) of every joint.
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
    return switch.get_output_port()
