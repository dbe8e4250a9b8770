"""Planning again in the middle of a mission, from where everything is and with what is left to plan with.

The run so far counts: the automaton has read its letters, and J is the cost of what is still to come. Members that
can no longer be moved stay where they are; those that are in no region are in a region of their own for the planner,
`BETWEEN`, which offers them nothing and which nobody can enter or leave.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drake_ltl.errors import InfeasibleError
from drake_ltl.planning.fits import Content, Fits
from drake_ltl.planning.geometry import Geometry
from drake_ltl.planning.mission import Mission
from drake_ltl.planning.mission_planner import plan_mission
from drake_ltl.planning.plan import State
from drake_ltl.planning.transition_system import TransitionSystem
from drake_ltl.scenario.model import Region, Scenario
from drake_ltl.scenario.starts import AgentStart, ObjectStart, Starts

BETWEEN = "between-regions"
"""No name that a file can have."""
Whereabouts = Mapping[str, str | None]
"""member -> the region that contains its sphere, None if none does."""


@dataclass(frozen=True)
class Situation:
    """Where everything is when a mission is planned again; nobody grasps."""

    agents: Mapping[str, AgentStart]
    """With region `BETWEEN` where in none."""
    objects: Mapping[str, ObjectStart]
    stuck: frozenset[str] = frozenset()
    """Agents and objects that can no longer be moved. All that is in no region must be among them."""
    cannot_grasp: frozenset[str] = frozenset()
    """Agents that can drive, but no longer grasp."""
    blocked: frozenset[str] = frozenset()
    """Regions that nobody may enter; who is there may stay or leave."""


def replan(
    scenario: Scenario, geometry: Geometry, fits: Fits, situation: Situation, seen: Sequence[Whereabouts]
) -> Mission:
    """A mission that goes on from a situation.

    Args:
        scenario: the problem as it was at the beginning.
        geometry: of its models.
        fits: P_{s,0}.
        situation: where the mission stands now.
        seen: where everything was in each state before, from the initial one.

    Raises:
        InfeasibleError: nothing that is still possible lets the whole run satisfy the formulas.
        NoPlacesError: what would was tried, but there are no places for the bodies.
        SearchLimitError: there are too many transitions to be enumerated.
    """
    wider = with_between(scenario)
    outside = {name for name, start in (situation.agents | situation.objects).items() if start.region == BETWEEN}
    if not outside <= situation.stuck:
        raise InfeasibleError(f"{', '.join(sorted(outside - situation.stuck))} cannot be brought back to a region")
    return plan_mission(
        wider,
        geometry,
        Starts(situation.agents, situation.objects),
        fits=_Fits(fits, frozenset(outside)),
        seen=[_state(wider, where) for where in seen],
        possible=lambda system: _possible(system, situation),
    )


def with_between(scenario: Scenario) -> Scenario:
    """The scenario with the region `BETWEEN`, far below the floor: nobody is there."""
    below = Region(BETWEEN, (0.0, 0.0, -10.0 * scenario.workspace_radius), 1e-3)
    members = (*scenario.agent_names, *scenario.object_names)
    services = {name: {**scenario.services.get(name, {}), BETWEEN: ()} for name in members}
    return replace(scenario, regions=(*scenario.regions, below), services=services)


@dataclass(frozen=True)
class _Fits:
    """P_s, and in `BETWEEN` just those that are there."""

    fits: Fits
    outside: frozenset[str]

    def __call__(self, region: Region, content: Content) -> bool:
        if region.name != BETWEEN:
            return self.fits(region, content)
        return not content.holds and self.outside.issuperset((*content.free_agents, *content.objects))


def _state(scenario: Scenario, where: Whereabouts) -> State:
    """As far as letters are concerned: grasps do not show in them."""
    return State(
        tuple(where[name] or BETWEEN for name in scenario.agent_names),
        tuple(where[name] or BETWEEN for name in scenario.object_names),
        (None,) * len(scenario.agents),
    )


def _possible(system: TransitionSystem, situation: Situation) -> NDArray[np.bool_]:
    """Transitions (E,) in which what is stuck does nothing, who cannot grasp does not grasp, and nobody comes to a
    region that is blocked."""
    scenario, n_regions = system.scenario, len(system.scenario.regions)
    kept = np.ones(system.n_transitions, dtype=bool)
    for index, name in enumerate(scenario.agent_names):
        before, after = (system.options[ends, index] for ends in (system.sources, system.targets))
        if name in situation.stuck:
            kept &= before == after
        if name in situation.stuck | situation.cannot_grasp:
            kept &= after < n_regions
    for index, name in enumerate(scenario.object_names):
        if name in situation.stuck:
            kept &= system.places[system.sources, index] == system.places[system.targets, index]
            kept &= (system.options[system.targets] != n_regions + index).all(axis=1)
    where = np.hstack([system.agent_regions, system.places])
    for region in map(scenario.region_names.index, situation.blocked):
        kept &= ((where[system.targets] != region) | (where[system.sources] == region)).all(axis=1)
    return kept
