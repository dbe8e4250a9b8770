"""Who can carry what, and where an agent may go: what is necessary for any plan, without looking for one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations

from drake_ltl.planning.demands import Demand, speaks_of, with_demands
from drake_ltl.planning.relaxation import Problem, Reason, Start
from drake_ltl.scenario.formulas import global_formula, labels
from drake_ltl.scenario.model import Scenario
from drake_ltl.spot_questions import is_contradiction


def able_teams(problem: Problem, obj: str) -> tuple[tuple[str, ...], ...]:
    """The teams that can carry an object and contain no smaller such team. All teams are tried, 2^N."""
    found: list[tuple[str, ...]] = []
    for team in subsets(problem.scenario.agent_names):
        if not any(set(smaller) <= set(team) for smaller in found) and problem.can_carry(obj, frozenset(team)):
            found.append(team)
    return tuple(found)


def may_enter(problem: Problem, agent: str, region: str, reasons: Iterable[Reason]) -> bool:
    """Whether an agent that goes where it likes can ever be in a region, by those of the reasons that are about it
    alone."""
    scenario, reasons = problem.scenario, frozenset(reasons)
    about = [r for r in reasons if isinstance(r, Demand) and speaks_of(scenario, r) == {agent}]
    world = f"{somewhere(scenario, agent)} & F({letter_formula(scenario, agent, region)})"
    if Start(agent) in reasons:
        start = problem.start.agents[scenario.agent_names.index(agent)]
        world += f" & {letter_formula(scenario, agent, start)}"
    return not is_contradiction(f"({global_formula(with_demands(scenario, about))}) & {world}")


def letter_formula(scenario: Scenario, member: str, region: str) -> str:
    """What a member experiences in a region and what not, as a formula without temporal operators."""
    known = sorted(frozenset().union(*(labels(scenario, member, name) for name in scenario.region_names)))
    shown = labels(scenario, member, region)
    return "(" + (" & ".join(p if p in shown else f"!{p}" for p in known) or "1") + ")"


def somewhere(scenario: Scenario, member: str) -> str:
    """The formula that a member is in some region at all times."""
    return f"G({' | '.join(letter_formula(scenario, member, name) for name in scenario.region_names)})"


def subsets(names: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """All but the empty one, small ones first."""
    for size in range(1, len(names) + 1):
        yield from combinations(names, size)
