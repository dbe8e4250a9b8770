"""A plan as each member experiences it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from drake_ltl.planning.plan import Plan, State
from drake_ltl.scenario.formulas import offers
from drake_ltl.scenario.model import Scenario


@dataclass(frozen=True)
class Station:
    """One member in one state of a plan."""

    region: str
    grasps: tuple[str, ...]
    """The object that an agent grasps, if any; the agents that grasp an object."""
    letter: frozenset[str]
    """L_i or L_j^O: what the member experiences, under the names of its own formula."""

    def __str__(self) -> str:
        """`pi1`, or `pi1[o2]` while grasping."""
        return self.region + (f"[{', '.join(self.grasps)}]" if self.grasps else "")


@dataclass(frozen=True)
class Projection:
    """The lasso prefix (suffix)^omega of one member, with as many stations as the plan has states."""

    member: str
    prefix: tuple[Station, ...]
    suffix: tuple[Station, ...]

    def __str__(self) -> str:
        """`a2: pi3 pi1 (pi1[o2] pi3[o2])`; the part in parentheses is repeated for ever."""
        return " ".join([f"{self.member}:", *map(str, self.prefix), f"({' '.join(map(str, self.suffix))})"])


def project(plan: Plan, scenario: Scenario, member: str) -> Projection:
    """The plan as one agent or object experiences it.

    Raises:
        KeyError: no agent or object has that name.
    """
    station = _reader(scenario, member)
    return Projection(member, tuple(map(station, plan.prefix)), tuple(map(station, plan.suffix)))


def project_all(plan: Plan, scenario: Scenario) -> tuple[Projection, ...]:
    """One projection for each agent, then one for each object."""
    return tuple(project(plan, scenario, member) for member in scenario.agent_names + scenario.object_names)


def projections_to_json(plan: Plan, scenario: Scenario) -> dict[str, Any]:
    """{"agents": {a1: {"prefix": [{"region", "grasps", "letter"}...], "suffix": [...]}}, "objects": {...}}

    `grasps` lists the object that an agent grasps, or the agents that grasp an object; `letter` is sorted.
    """
    by_name = {projection.member: _to_json(projection) for projection in project_all(plan, scenario)}
    return {
        "agents": {name: by_name[name] for name in scenario.agent_names},
        "objects": {name: by_name[name] for name in scenario.object_names},
    }


def _reader(scenario: Scenario, member: str) -> Callable[[State], Station]:
    """Reads one member's station off a state."""
    agents, objects = scenario.agent_names, scenario.object_names

    def agent(state: State) -> Station:
        held = state.grasps[agents.index(member)]
        return station(state.agents[agents.index(member)], () if held is None else (held,))

    def obj(state: State) -> Station:
        holders = tuple(name for name, held in zip(agents, state.grasps, strict=True) if held == member)
        return station(state.objects[objects.index(member)], holders)

    def station(region: str, grasps: tuple[str, ...]) -> Station:
        return Station(region, grasps, frozenset(offers(scenario.services, member, region)))

    if member not in agents + objects:
        raise KeyError(f"{member!r} is no agent or object; they are {', '.join(agents + objects)}")
    return agent if member in agents else obj


def _to_json(projection: Projection) -> dict[str, Any]:
    def stations(part: tuple[Station, ...]) -> list[dict[str, Any]]:
        return [{"region": s.region, "grasps": list(s.grasps), "letter": sorted(s.letter)} for s in part]

    return {"prefix": stations(projection.prefix), "suffix": stations(projection.suffix)}
