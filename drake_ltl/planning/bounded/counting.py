"""A lower bound for lassos of every length: how often each way must be taken, whatever the order.

Of a lasso keep only numbers: how often each agent goes freely from region to region, how often it does so
carrying an object, and how often each object is carried, separately for the prefix (up to the first state of the
suffix) and for one round of the suffix. These numbers obey, for every lasso:

- *Balance.* A member's ways of the prefix lead from its start to the region where the suffix finds it, those of
  the suffix balance in each region.
- *Carrying.* When j goes from region a to b, so do agents whose powers together reach Lambda_j. Hence, summed over
  all its ways from a to b, sum_i zeta_i y_ij >= Lambda_j x_j and sum_i y_ij >= (least size of a team) x_j, while
  no agent carries j more often than j goes: y_ij <= x_j.
- *Own formulas.* A member's run through its regions and its automaton A (`alone`) is a walk. After r rounds of the
  suffix, r = `Conjunct.settles`, A is in a state to which each further round returns. So the steps of prefix and
  r rounds are a flow from the start to one node, and those of one more round are a circulation through this node
  that meets the marks some clause of the acceptance wants and none that it forbids. Their ways add up to those
  of the prefix plus r times those of the suffix, and to those of the suffix.
- *Connection.* There is a path, along ways that are taken, from an object's start to the beginning of its suffix,
  from there to a step with each mark that is wanted, and back; and from an agent's start to each region out of
  which it carries. Paths are flows of one unit, below the numbers and below literals that say whether an object
  goes some way at all; teams must be strong enough for these literals too.

The objective is the cost J itself: each way of each body is counted once, as an agent's free way, as an agent's way
with an object, or as an object's way. An agent that meets its own obligation while carrying is thus counted once,
and the approach to an object is counted as soon as balance and connection need it. So the minimum over all such
numbers is at most the cost of any lasso; capacities, timing and formulas over several members are left out.
Ways for which there is a detour as good are left out too (`detours`).

The same holds for one member without the others (`Alone`), which is much less work.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from drake_ltl.planning.bounded.alone import Alone, Way
from drake_ltl.planning.bounded.detours import without_ways
from drake_ltl.planning.bounded.own_formula import add_own_formula
from drake_ltl.planning.bounded.problem import Problem
from drake_ltl.planning.bounded.program import Program, total
from drake_ltl.planning.bounded.teams import least_team

_TOLERANCE = 1e-6
"""Of the solver, relative to the bound."""
_PHASES = ("prefix", "suffix")


class Counting:
    """The relaxation as a mixed-integer program."""

    def __init__(self, problem: Problem, members: Sequence[Alone | None], ways: Sequence[Sequence[Way]]):
        """Form the program of all members.

        Args:
            problem: the problem.
            members: from `lone_members`.
            ways: of each object, and each agent's free ways: from `needed_ways`.
        """
        self._start(problem, members, ways)
        n = problem.n_agents
        self._objects = [self._add_alone(n + j) for j in range(problem.n_objects)]
        for agent in range(n):
            self._add_agent(agent)
        self._add_teams()

    @classmethod
    def of_one(
        cls,
        problem: Problem,
        members: Sequence[Alone | None],
        ways: Sequence[Sequence[Way]],
        member: int,
        *,
        with_team: bool = False,
    ) -> Counting:
        """The program of one member without the others.

        Args:
            problem: the problem.
            members: from `lone_members`.
            ways: from `needed_ways`.
            member: index of an agent or an object.
            with_team: whether each way of an object counts as often as bodies go it at least: itself and the
                smallest team that may go there and is strong enough. Nobody carries two objects at once, so these
                minima of several objects add up, and agents' free ways come on top.
        """
        program = cls.__new__(cls)
        program._start(problem, members, ways)
        program._add_alone(member, with_team=with_team)
        return program

    def _start(self, problem: Problem, members: Sequence[Alone | None], ways: Sequence[Sequence[Way]]) -> None:
        self._problem, self._program, self._members = problem, Program(), members
        costs = problem.integer_ways(below=True)
        self._scale = max((cost for row in costs for cost in row), default=0) or 1
        self._costs = [[cost / self._scale for cost in row] for row in costs]
        self._needed = ways
        self._objective: list[Any] = []
        self._carriers: dict[tuple[int, str, Way], list[tuple[int, Any, Any]]] = {}
        """(object, phase, way) -> (agent, how often, whether at all)"""
        self._leaves: dict[tuple[int, int], list[Any]] = {}
        """(agent, region) -> whether it carries something out of there"""
        self._objects: list[dict[tuple[str, Way], tuple[Any, Any]]] = []

    def bound(self, seconds: float) -> tuple[int, bool]:
        """A lower bound in units of cost, and whether it is all that can be had from this program."""
        least, done = self._program.least(self._objective, seconds)
        least *= self._scale
        # The cost of a lasso is a whole number of units; the solver's tolerance is relative.
        return max(0, math.ceil(least - 1e-3 - _TOLERANCE * abs(least))), done

    # ---- the numbers

    def _add_costs(self, counts: Mapping[tuple[str, Way], list[Any]]) -> None:
        """What a member's ways cost."""
        for (_, (a, b)), numbers in counts.items():
            self._objective += [self._costs[a][b] * number for number in numbers]

    def _add_alone(self, member: int, *, with_team: bool = False) -> dict[tuple[str, Way], tuple[Any, Any]]:
        """How often an object (or an agent without objects) goes, and whether, in each phase, each way."""
        counts = {(phase, way): self._program.number() for phase in _PHASES for way in self._needed[member]}
        whether = {key: self._program.literal() for key in counts}
        for key, number in counts.items():
            self._program.add(whether[key] <= number)
        for (phase, way), number in counts.items():
            bodies = 1 + (self._least_team(member - self._problem.n_agents, way) if with_team else 0)
            self._add_costs({(phase, way): [bodies * number]})
        end = self._add_balance(member, {key: [number] for key, number in counts.items()})
        path = {way: self._program.number() for way in self._needed[member]}
        self._program.add_path(path, {self._problem.starts[member]: 1}, dict(enumerate(end)))
        for way, flow in path.items():
            self._program.add(flow <= whether["prefix", way])
        if (lone := without_ways(self._members[member], self._needed[member])) is not None:
            add_own_formula(self._program, lone, {key: [n] for key, n in counts.items()}, end, whether)
        return {key: (number, whether[key]) for key, number in counts.items()}

    def _add_agent(self, agent: int) -> None:
        """Free ways and ways with each object."""
        n, lone = self._problem.n_agents, self._members[agent]
        free = self._needed[agent]
        able = {way for ways in self._needed[n:] for way in ways if lone is None or way in lone.ways}
        counts: dict[tuple[str, Way], list[Any]] = {}
        for phase in _PHASES:
            for way in sorted(able.union(free)):
                carrying = [self._carry(agent, j, phase, way) for j in range(self._problem.n_objects)]
                counts[phase, way] = [y for y in carrying if y is not None]
            for way in free:
                counts[phase, way].append(self._program.number())
        self._add_costs(counts)
        end = self._add_balance(agent, counts)
        if (less := without_ways(lone, [*able, *free])) is not None:
            add_own_formula(self._program, less, counts, end, {})
        self._add_approach(agent, counts)

    def _carry(self, agent: int, j: int, phase: str, way: Way) -> Any:
        """y_ij <= x_j; None where j does not go."""
        if (phase, way) not in self._objects[j]:
            return None
        times, whether = self._objects[j][phase, way]
        number, ever = self._program.number(), self._program.literal()
        self._program.add(number <= times)
        self._program.add(ever <= number)
        self._program.add(ever <= whether)
        self._carriers.setdefault((j, phase, way), []).append((agent, number, ever))
        self._leaves.setdefault((agent, way[0]), []).append(ever)
        return number

    def _add_teams(self) -> None:
        """Those who carry are strong enough: each time, and at all."""
        for j, ways in enumerate(self._objects):
            for (phase, way), (times, whether) in ways.items():
                team = self._carriers.get((j, phase, way), [])
                for needed, those in ((times, [y for _, y, _ in team]), (whether, [t for _, _, t in team])):
                    self._program.add(total(those) >= self._least_team(j, way) * needed)
                    if self._problem.sum_rule:
                        zetas, needs = self._problem.powers
                        power = (zetas[i] * number for (i, _, _), number in zip(team, those, strict=True))
                        self._program.add(total(power) >= needs[j] * needed)

    def _least_team(self, obj: int, way: Way) -> int:
        return least_team(self._problem, self._members, obj, way)

    # ---- walks

    def _add_balance(self, member: int, counts: Mapping[tuple[str, Way], list[Any]]) -> list[Any]:
        """Ways add up to walks; where the suffix begins, one literal for each region."""
        end = [self._program.literal() for _ in range(self._problem.n_regions)]
        self._program.add(total(end) == 1.0)
        for k in range(self._problem.n_regions):
            first = float(k == self._problem.starts[member])
            self._program.add(_net(counts, "prefix", k) == first - end[k])
            self._program.add(_net(counts, "suffix", k) == 0.0)
        return end

    def _add_approach(self, agent: int, counts: Mapping[tuple[str, Way], list[Any]]) -> None:
        """An agent that carries out of a region gets there from its start."""
        ways, start = {way for _, way in counts}, self._problem.starts[agent]
        for k in range(self._problem.n_regions):
            carries = self._leaves.get((agent, k), [])
            if k == start or not carries:
                continue
            there = self._program.share()
            for ever in carries:
                self._program.add(there >= ever)
            path = {way: self._program.number() for way in ways}
            for way, flow in path.items():
                self._program.add(flow <= total([*counts["prefix", way], *counts["suffix", way]]))
            self._program.add_path(path, {start: there}, {k: there})


def _net(counts: Mapping[tuple[str, Way], list[Any]], phase: str, region: int) -> Any:
    """How much more often a region is left than entered."""
    leaving = [x for (p, (a, _)), numbers in counts.items() if p == phase and a == region for x in numbers]
    entering = [x for (p, (_, b)), numbers in counts.items() if p == phase and b == region for x in numbers]
    return total(leaving) - total(entering)
