"""Proofs that there is no plan, for teams too large to be enumerated: what each member can do alone rules all out."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

from drake_ltl.planning.abilities import letter_formula, may_enter, somewhere
from drake_ltl.planning.demands import Demand, speaks_of
from drake_ltl.planning.plan import State
from drake_ltl.planning.relaxation import Power, Problem, Reason, Start
from drake_ltl.scenario.formulas import global_formula
from drake_ltl.scenario.model import Scenario
from drake_ltl.spot_questions import is_contradiction

MOST_AGENTS = 16
"""Teams are tried one by one up to this number of agents, large ones first."""


class Refutation:
    """Looks at words alone: each member is somewhere, begins where it starts, and an object enters or leaves a
    region only if the agents that may ever be there can carry it. If no such word satisfies the formulas, there is
    no plan; otherwise nothing is said. What a region has room for is left aside.
    """

    def __init__(self, problem: Problem):
        self._problem = problem
        self._entered: dict[tuple[str, str, frozenset[Reason]], bool] = {}
        self._carried: dict[tuple[str, tuple[str, ...], bool], bool] = {}

    def refutes(self, kept: frozenset[Reason]) -> bool:
        """Whether the problem with only these reasons is proven to have no plan."""
        problem = self._problem.with_only(kept)
        demands = [reason for reason in kept if isinstance(reason, Demand)]
        concerned = frozenset().union(*(speaks_of(problem.scenario, demand) for demand in demands))
        world = " & ".join(self._world(problem, kept, concerned)) or "1"
        return is_contradiction(f"({global_formula(problem.scenario)}) & {world}")

    def _world(self, problem: Problem, kept: frozenset[Reason], concerned: frozenset[str]) -> Iterator[str]:
        scenario = problem.scenario
        for member in sorted(concerned):
            yield somewhere(scenario, member)
            if Start(member) in kept:
                yield letter_formula(scenario, member, _start(scenario, problem.start, member))
            if member in scenario.object_names:
                yield from self._closed(problem, kept, member)

    def _closed(self, problem: Problem, kept: frozenset[Reason], obj: str) -> Iterator[str]:
        """For each region where nobody can carry an object: it is there always or never.

        Left out for regions that look the same to the object: it may go from one of them to the other.
        """
        scenario = problem.scenario
        letters = [letter_formula(scenario, obj, region) for region in scenario.region_names]
        for region, letter in zip(scenario.region_names, letters, strict=True):
            if letters.count(letter) > 1:
                continue
            there = tuple(agent for agent in scenario.agent_names if self._may_enter(agent, region, kept))
            if not self._some_team_carries(problem, obj, there, Power(obj) in kept):
                yield f"(G{letter} | G!{letter})"

    def _may_enter(self, agent: str, region: str, kept: frozenset[Reason]) -> bool:
        about = frozenset(r for r in kept if _is_about(self._problem.scenario, r, agent))
        key = agent, region, about
        if key not in self._entered:
            self._entered[key] = may_enter(self._problem, agent, region, about)
        return self._entered[key]

    def _some_team_carries(self, problem: Problem, obj: str, agents: tuple[str, ...], needs_power: bool) -> bool:
        """Whether any team of some agents can carry an object; taken for granted if there are too many teams."""
        key = obj, agents, needs_power
        if key not in self._carried:
            teams = (frozenset(team) for size in range(len(agents), 0, -1) for team in combinations(agents, size))
            self._carried[key] = len(agents) > MOST_AGENTS or any(problem.can_carry(obj, team) for team in teams)
        return self._carried[key]


def _is_about(scenario: Scenario, reason: Reason, agent: str) -> bool:
    return reason == Start(agent) or (isinstance(reason, Demand) and speaks_of(scenario, reason) == {agent})


def _start(scenario: Scenario, start: State, member: str) -> str:
    members = scenario.agent_names + scenario.object_names
    return (start.agents + start.objects)[members.index(member)]
