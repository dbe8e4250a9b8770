"""Puts the monitors into a mission's diagram. Nothing takes anything from them: without them a run is the same."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from functools import partial

import numpy as np
from drake_ltl.diagrams.transport_plant import TransportPlant
from pydrake.systems.framework import DiagramBuilder, OutputPort

from drake_ltl.errors import SearchLimitError
from drake_ltl.monitoring.duties import Duty, Members, duties, expected_start, regions_of
from drake_ltl.monitoring.prefixes import prefixes
from drake_ltl.monitoring.spheres import Rule, apart, arrived, forbidden, staying, workspace
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.planning.plan_json import action_to_json
from drake_ltl.scenario.formulas import labels, offers
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.monitors.body_monitors import GeometryMonitor, WeldMonitor
from drake_ltl.systems.monitors.control_monitors import LyapunovMonitor, TorqueMonitor
from drake_ltl.systems.monitors.member_centres import MemberCentres, anchored_centres
from drake_ltl.systems.monitors.mission_monitor import Look, MissionMonitor
from drake_ltl.systems.monitors.sphere_monitor import ArrivalMonitor, SphereMonitor
from drake_ltl.systems.monitors.word_monitor import Watched, WordMonitor
from drake_ltl.systems.plan_supervisor import PlanSupervisor
from drake_ltl.systems.program import MissionProgram, start_configuration
from drake_ltl.systems.state_places import StatePlaces

LONGEST_PERIODS = {
    "spheres": 0.2,
    "arrival": 0.2,
    "word": 0.2,
    "lyapunov": 0.2,
    "torque": 0.05,
    "weld": 0.1,
    "geometry": 0.4,
}
"""Time between two looks of each monitor is at most this [s], see `periods`. At 1 m/s a body moves by 16 cm between two
looks at spheres: two of 0.5 m then come at most 4 mm nearer to each other than at both looks."""
MONITORS = frozenset(LONGEST_PERIODS)
"""Names of all."""


def periods(time_step: float) -> dict[str, float]:
    """Time between two looks of each monitor [s].

    A power of two times the plant's step: k such periods are the very same number as some steps of the plant, to the
    last bit. Else the Simulator would take two steps at what is one instant.
    """
    return {
        name: time_step * 2.0 ** max(0, math.floor(math.log2(longest / time_step) + 1e-9))
        for name, longest in LONGEST_PERIODS.items()
    }


def AddMonitors(
    builder: DiagramBuilder,
    names: Collection[str] = MONITORS,
    *,
    transport_plant: TransportPlant,
    supervisor: PlanSupervisor,
    torque: OutputPort,
    controls: OutputPort,
    program: MissionProgram,
    scenario: Scenario,
    models: MeasuredModels,
) -> dict[str, MissionMonitor]:
    """Adds monitors, by name.

    Args:
        names: of those that are added.
        torque: of all agents' joints, stacked; V may stand behind.
        controls: the same, with V behind.

    Raises:
        ValueError: there is no monitor of such a name.
    """
    if unknown := sorted(set(names) - MONITORS):
        raise ValueError(f"no monitors are called {', '.join(unknown)}; there are {', '.join(sorted(MONITORS))}")
    plant = transport_plant.plant
    places = StatePlaces.of(plant, transport_plant.agents, transport_plant.objects)
    centres = builder.AddSystem(MemberCentres(plant, transport_plant.agents, transport_plant.objects))
    builder.Connect(plant.get_body_poses_output_port(), centres.get_body_poses_input_port())
    period = periods(scenario.simulation.time_step)
    all_of_them = [
        *_sphere_monitors(program, scenario, models, period),
        *([_word_monitor(program, scenario, models, period)] if "word" in names else []),  # translates formulas
        LyapunovMonitor("lyapunov", period["lyapunov"], program, sum(places.sizes)),
        TorqueMonitor("torque", period["torque"], program, *_motors(models), size=torque.size()),
        WeldMonitor("weld", period["weld"], program, places, models, scenario.tolerances),
        GeometryMonitor("geometry", period["geometry"], program, places, models, scenario.agents),
    ]
    signals = {
        "centres": centres.get_centres_output_port(),
        "torque": torque,
        "controls": controls,
        "state": plant.get_state_output_port(),
    }
    made = [monitor for monitor in all_of_them if monitor.kind in names]
    for monitor in made:
        builder.AddSystem(monitor)
        signal = monitor.get_signal_input_port()
        builder.Connect(signals[signal.get_name()], signal)
        builder.Connect(supervisor.get_progress_output_port(), monitor.get_progress_input_port())
    return {monitor.kind: monitor for monitor in made}


def _sphere_monitors(
    program: MissionProgram, scenario: Scenario, models: MeasuredModels, period: Mapping[str, float]
) -> list[MissionMonitor]:
    """Those that look at where spheres are."""
    members = _members(scenario, models)
    start = expected_start(members, scenario, _start_centres(program, models))
    todo = duties(start, [[action_to_json(action) for action in step.actions] for step in program.steps])
    size = 3 * len(members.names)

    def rule(duty: Duty) -> Rule:
        where = [ways(duty, members, scenario) for ways in (forbidden, workspace, staying)]
        return Rule.joined([apart(duty, members), *where])

    return [
        SphereMonitor(period["spheres"], program, todo, size, rule),
        ArrivalMonitor(
            period["arrival"],
            program,
            todo,
            size,
            arrived=partial(arrived, members=members, scenario=scenario),
            end_centres=_end_centres(models),
        ),
    ]


def _word_monitor(
    program: MissionProgram, scenario: Scenario, models: MeasuredModels, period: Mapping[str, float]
) -> WordMonitor:
    members = _members(scenario, models)
    watched, unwatched = _watched(scenario)
    return WordMonitor(
        "word",
        period["word"],
        program,
        3 * len(members.names),
        watched=watched,
        end_centres=_end_centres(models),
        regions=partial(regions_of, members, scenario),
        unwatched=unwatched,
    )


def _members(scenario: Scenario, models: MeasuredModels) -> Members:
    geometry = models.geometry
    return Members(
        scenario.agent_names,
        scenario.object_names,
        dict(geometry.agent_radius),
        dict(geometry.object_radius),
        dict(geometry.team_radius),
    )


def _start_centres(program: MissionProgram, models: MeasuredModels) -> np.ndarray:
    """(N + M, 3) [m] in W, as bodies are placed at the start."""
    layout = program.mission.steps[0].before
    q = {name: start_configuration(stand, name, models) for name, stand in layout.agents.items()}
    centres = [model.centre(q[name]) for name, model in models.agents.items()]
    return np.array([*centres, *(layout.objects[name] for name in models.objects)])


def _end_centres(models: MeasuredModels) -> Callable[[Look], np.ndarray]:
    """Centres when the last step ended: the supervisor's anchor is of that very instant, until another interval of the
    step begins. When all is done nothing moves any more, and now will do."""
    return lambda look: (
        look.signal if look.done or look.progress.interval else anchored_centres(models, look.progress.anchor)
    )


def _motors(models: MeasuredModels) -> tuple[list[tuple[str, str]], np.ndarray]:
    """(agent, joint) of each torque, and what their motors give."""
    joints = [(name, joint) for name, model in models.agents.items() for joint in model.joint_names]
    return joints, np.concatenate([model.effort_limits for model in models.agents.values()])


def _watched(scenario: Scenario) -> tuple[tuple[Watched, ...], dict[str, str]]:
    """Each formula with its monitors, and those formulas whose monitors are too large, with the reason."""

    def own(member: str, regions: Mapping[str, str | None]) -> frozenset[str]:
        region = regions[member]
        return frozenset() if region is None else frozenset(offers(scenario.services, member, region))

    def everybody(regions: Mapping[str, str | None]) -> frozenset[str]:
        shown = [labels(scenario, member, region) for member, region in regions.items() if region is not None]
        return frozenset().union(*shown)

    formulas = [
        (member.name, member.spec, partial(own, member.name)) for member in (*scenario.agents, *scenario.objects)
    ]
    watched, unwatched = [], {}
    for name, formula, letter in (*formulas, ("", scenario.spec, everybody)):
        try:
            watched.append(Watched(name, formula, prefixes(formula), letter))
        except SearchLimitError as error:
            unwatched[f"{name}: {formula}" if name else formula] = str(error)
    return tuple(watched), unwatched
