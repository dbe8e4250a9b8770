"""Control laws as one system for each law, agent and object, and switches that select among them."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from drake_ltl.diagrams.transport_plant import TransportPlant
from pydrake.systems.framework import DiagramBuilder, InputPort, LeafSystem, OutputPort, System
from pydrake.systems.primitives import Multiplexer, PortSwitch

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.multibody.agent_model import AgentModel
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.drive_controllers import DriveController, DriveHoldController
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
    own_controllers: Mapping[str, LeafSystem] | None = None,
) -> OutputPort:
    """Adds navigation field, controllers and switches.

    Args:
        own_controllers: systems that take the place of the controllers of these names, and have the same ports.

    Returns the torques of all agents' joints, stacked, then V (sum n_i + 1,).

    Raises:
        InvalidInputError: there is no controller of such a name, or a port is missing or of another size.
    """
    chosen = _Choice(own_controllers or {}, scenario)
    plant = transport_plant.plant
    field = builder.AddSystem(NavigationField(program, scenario, models))
    for name, instance in (transport_plant.agents | transport_plant.objects).items():
        builder.Connect(plant.get_state_output_port(instance), field.get_state_input_port(name))
    builder.Connect(supervisor.get_step_output_port(), field.get_step_input_port())
    builder.Connect(supervisor.get_anchor_output_port(), field.get_anchor_input_port())
    transports = {
        name: _add_transport(builder, name, scenario, models, transport_plant, supervisor, field, chosen)
        for name in transport_plant.objects
    }
    stack = builder.AddSystem(Multiplexer([*(model.n for model in models.agents.values()), 1]))
    stack.set_name("controls")
    for index, agent in enumerate(transport_plant.agents):
        torque = _add_agent(builder, agent, scenario, models, transport_plant, supervisor, field, transports, chosen)
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
    chosen: _Choice,
) -> System:
    settings = scenario.controller
    damping = np.repeat([settings.team_rotation_damping, settings.team_damping], 3)
    usual = TransportController(models.objects[name], models.agents, damping, settings.speed_limit)
    controller = builder.AddSystem(chosen(usual))
    plant = transport_plant.plant
    port = controller.GetInputPort  # by name: a user's system has no accessors of ours
    builder.Connect(plant.get_state_output_port(transport_plant.objects[name]), port(f"state_{name}"))
    builder.Connect(field.get_gradient_output_port(name), port("gradient"))
    builder.Connect(supervisor.get_shares_output_port(name), port("shares"))
    for agent, instance in transport_plant.agents.items():
        if not models.agents[agent].has_arm:
            continue
        builder.Connect(plant.get_state_output_port(instance), port(f"state_{agent}"))
        if models.agents[agent].is_redundant:
            builder.Connect(supervisor.get_anchor_output_port(agent), port(f"anchor_{agent}"))
    return controller


def _add_agent(
    builder: DiagramBuilder,
    agent: str,
    scenario: Scenario,
    models: MeasuredModels,
    transport_plant: TransportPlant,
    supervisor: PlanSupervisor,
    field: NavigationField,
    transports: Mapping[str, System],
    chosen: _Choice,
) -> OutputPort:
    """The agent's own controllers and the switch that selects among them, in the order of signals.Mode.

    Returns the switch's output: the torque (n,) of every joint.
    """
    model, reach = models.agents[agent], supervisor.get_reach_output_port(agent)
    state = transport_plant.plant.get_state_output_port(transport_plant.agents[agent])
    laws = {name: builder.AddSystem(chosen(law)) for name, law in _laws(model, scenario).items()}
    builder.Connect(supervisor.get_hold_output_port(agent), laws["hold"].GetInputPort("hold"))
    builder.Connect(field.get_gradient_output_port(agent), laws["transition"].GetInputPort("gradient"))
    builder.Connect(reach, field.get_reach_input_port(agent))
    if model.has_arm:
        builder.Connect(reach, laws["reach"].GetInputPort("reach"))
    else:
        builder.Connect(supervisor.get_course_output_port(agent), laws["transition"].GetInputPort("course"))

    switch = builder.AddSystem(PortSwitch(model.n))
    switch.set_name(f"switch_{agent}")
    builder.Connect(supervisor.get_mode_output_port(agent), switch.get_port_selector_input_port())
    for name, law in laws.items():
        builder.Connect(state, law.GetInputPort("state"))
        builder.Connect(law.GetOutputPort("torque"), switch.DeclareInputPort(name))
    for obj, transport in transports.items() if model.has_arm else ():
        builder.Connect(transport.GetOutputPort(f"torque_{agent}"), switch.DeclareInputPort(f"transport_{obj}"))
    return switch.get_output_port()


def _laws(model: AgentModel, scenario: Scenario) -> dict[str, LeafSystem]:
    """What an agent does by itself; a differential drive holds or travels and does nothing else."""
    settings = scenario.controller
    if not model.has_arm:
        return {"hold": DriveHoldController(model), "transition": DriveController(model, settings.speed_limit)}
    damping = model.damping(settings.base_damping, settings.arm_damping)
    return {
        "hold": HoldController(model),
        "transition": TransitionController(model, damping, settings.speed_limit, scenario.simulation.time_step),
        "reach": ReachController(model),
    }


class _Choice:
    """A user's controller where there is one of that name, else the usual one."""

    def __init__(self, own: Mapping[str, LeafSystem], scenario: Scenario):
        self._own = own
        laws = {True: ("hold", "transition", "reach"), False: ("hold", "transition")}
        known = [f"{law}_{agent.name}" for agent in scenario.agents for law in laws[agent.has_arm]]
        known += [f"transport_{obj}" for obj in scenario.object_names]
        unknown = [name for name in own if name not in known]
        if unknown:
            remedy = f"write one of {', '.join(known)}"
            raise InvalidInputError(
                [Mistake(f"own_controllers[{n!r}]", "no controller has it", remedy) for n in unknown]
            )

    def __call__(self, usual: System) -> System:
        name = usual.get_name()
        if name not in self._own:
            return usual
        own = self._own[name]
        mistakes = [*_port_mistakes(name, own, usual, "input"), *_port_mistakes(name, own, usual, "output")]
        if mistakes:
            raise InvalidInputError(mistakes)
        own.set_name(name)
        return own


def _port_mistakes(name: str, own: System, usual: System, kind: str) -> list[Mistake]:
    """Each port that the usual controller has and this one lacks, or has in another size."""
    wanted, found = _sizes(usual, kind), _sizes(own, kind)
    return [
        Mistake(
            f"own_controllers[{name!r}]",
            f"its {kind} ports are {found or 'none'}",
            f"declare a vector {kind} port {port!r} of size {size}",
        )
        for port, size in wanted.items()
        if found.get(port) != size
    ]


def _sizes(system: System, kind: str) -> dict[str, int]:
    count: int = getattr(system, f"num_{kind}_ports")()
    get: Callable[[int], InputPort | OutputPort] = getattr(system, f"get_{kind}_port")
    return {get(i).get_name(): get(i).size() for i in range(count)}
