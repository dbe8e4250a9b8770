"""Facts in words, and what follows from them: who could carry what where, who has no room."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from drake_ltl.planning.abilities import able_teams, may_enter, subsets
from drake_ltl.planning.demands import Demand, in_words, speaks_of
from drake_ltl.planning.fits import Content
from drake_ltl.planning.power import sum_rule
from drake_ltl.planning.relaxation import Power, Problem, Reason, Room, Start
from drake_ltl.scenario.model import Scenario

MOST_AGENTS = 10
"""Teams are tried one by one up to this number of agents."""

_MOST_NAMED = 4
"""Of many teams, so many are named."""


def reason_in_words(problem: Problem, reason: Reason) -> str:
    """A formula or a fact on one line."""
    scenario, start = problem.scenario, problem.start
    if isinstance(reason, Demand):
        return in_words(scenario, reason)
    if isinstance(reason, Power):
        if not _adds_up(problem):
            return f"{reason.object} can be carried by some teams only"
        return f"{reason.object} needs power {_need(scenario, reason.object):g}"
    if isinstance(reason, Room):
        return _room(scenario, reason.region)
    if reason.member in scenario.object_names:
        return f"{reason.member} starts in {start.objects[scenario.object_names.index(reason.member)]}"
    agent = scenario.agent_names.index(reason.member)
    grasp = start.grasps[agent]
    return f"{reason.member} starts in {start.agents[agent]}" + (f", grasping {grasp}" if grasp else "")


def remarks(problem: Problem, reasons: Sequence[Reason]) -> tuple[str, ...]:
    """What follows from the facts among some reasons: one line each, without full stop."""
    if len(problem.scenario.agents) > MOST_AGENTS:
        return ()
    carrying = [line for r in reasons if isinstance(r, Power) for line in _carrying(problem, r.object, reasons)]
    crowding = [line for r in reasons if isinstance(r, Room) for line in _crowding(problem, r.region, reasons)]
    return (*carrying, *(_ungrasped(problem, reasons) if any(isinstance(r, Room) for r in reasons) else ()), *crowding)


def _ungrasped(problem: Problem, reasons: Sequence[Reason]) -> Iterator[str]:
    """Who cannot hold an object anywhere: it is not for want of room in this region or that."""
    concerned = set().union(*(_members(problem.scenario, r) for r in reasons))
    for obj in (name for name in problem.scenario.object_names if name in concerned):
        unable = [agent for agent in problem.scenario.agent_names if not _can_hold(problem, agent, obj)]
        if unable:
            yield f"{' and '.join(unable)} cannot grasp {obj} in any region"


def _can_hold(problem: Problem, agent: str, obj: str) -> bool:
    content = Content((), (obj,), ((agent, obj),))
    return any(problem.fits(region, content) for region in problem.scenario.regions)


def _carrying(problem: Problem, obj: str, reasons: Sequence[Reason]) -> Iterator[str]:
    scenario = problem.scenario
    teams = able_teams(problem, obj)
    if not teams:
        yield _weakness(problem, scenario.agent_names, obj)
        return
    weak = False
    for region in scenario.region_names:
        there = tuple(agent for agent in scenario.agent_names if may_enter(problem, agent, region, reasons))
        if not any(set(team) <= set(there) for team in teams):
            weak = True
            yield (
                f"{_weakness(problem, there, obj)} in {region}; no other may enter it"
                if there
                else (f"no agent may enter {region}")
            )
    if not weak:
        yield f"{obj} can be carried by {_some([_sum(team) for team in teams])} only"


def _weakness(problem: Problem, team: Sequence[str], obj: str) -> str:
    """Such as `a2 + a3 give 5, too little for o2`; without numbers if not they are what counts."""
    if not _adds_up(problem):
        return f"{_sum(team)} cannot carry {obj}"
    power = math.fsum(agent.power for agent in problem.scenario.agents if agent.name in team)
    return f"{_sum(team)} {'give' if len(team) > 1 else 'gives'} {power:g}, too little for {obj}"


def _crowding(problem: Problem, region: str, reasons: Sequence[Reason]) -> Iterator[str]:
    """Smallest crowds that have no room in a region, of the members that the reasons speak of."""
    scenario, place = problem.scenario, problem.scenario.region(region)
    concerned = set().union(*(_members(scenario, r) for r in reasons))
    members = [m for m in scenario.agent_names + scenario.object_names if m in concerned]
    crowds: list[tuple[str, ...]] = []
    for crowd in subsets(members[:MOST_AGENTS]):
        agents = tuple(m for m in crowd if m in scenario.agent_names)
        objects = tuple(m for m in crowd if m in scenario.object_names)
        if any(set(smaller) <= set(crowd) for smaller in crowds):
            continue
        if not problem.fits(place, Content(agents, objects)):
            crowds.append(crowd)
    if crowds:
        yield f"{region} has no room for {_some([_sum(crowd) for crowd in crowds])}"
    for obj in (name for name in scenario.object_names if name in concerned):
        tight = [
            f"{_sum(team)} with {obj}"
            for team in able_teams(problem, obj)
            if all(_can_hold(problem, agent, obj) for agent in team)
            and not all(problem.fits(place, content) for content in _with_object(team, obj))
        ]
        if tight:
            yield f"{region} has no room for {_some(tight)}"


def _with_object(team: tuple[str, ...], obj: str) -> tuple[Content, Content]:
    """A team that holds an object, and one that carries it."""
    holds = tuple((agent, obj) for agent in team)
    return Content((), (obj,), holds), Content((), (obj,), holds, frozenset({obj}))


def _members(scenario: Scenario, reason: Reason) -> frozenset[str]:
    if isinstance(reason, Demand):
        return speaks_of(scenario, reason)
    if isinstance(reason, Power):
        return frozenset({reason.object})
    return frozenset({reason.member}) if isinstance(reason, Start) else frozenset()


def _adds_up(problem: Problem) -> bool:
    """Whether the teams that can carry are those of the sum rule; of many agents, some teams are tried."""
    scenario, rule = problem.scenario, sum_rule(problem.scenario)
    names = scenario.agent_names
    teams = [*subsets(names[:MOST_AGENTS]), names]
    trials = [(obj, frozenset(team)) for obj in scenario.object_names for team in teams]
    return all(problem.can_carry(*trial) == rule(*trial) for trial in trials)


def _need(scenario: Scenario, obj: str) -> float:
    return scenario.objects[scenario.object_names.index(obj)].power_needed


def _sum(names: Sequence[str]) -> str:
    return " + ".join(names)


def _some(items: Sequence[str]) -> str:
    more = len(items) - _MOST_NAMED
    return ", or ".join(items[:_MOST_NAMED]) + (f", or {more} more" if more > 0 else "")


def _room(scenario: Scenario, region: str) -> str:
    rule = scenario.fits
    if rule is None:
        return f"{region} has room for what fits within {scenario.region(region).radius:g} m of its centre"
    return (
        f"{region} has room for {rule.capacity:g}: {rule.agent:g} per agent, {rule.grasping:g} if it grasps, "
        f"{rule.object:g} per object"
    )
