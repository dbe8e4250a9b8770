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

The same holds for one member without the others. Their minima are cheap, and two sums of them are bounds too: each
object's own minimum, as often as bodies go its way (itself and the smallest team), which counts no agent's free
ways; and the own minima of all members, objects' ways counted without their teams.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import timedelta
from typing import Any

from ortools.math_opt.python import mathopt

from drake_ltl.errors import InfeasibleError
from drake_ltl.planning.bounded.alone import Alone, Step, alone
from drake_ltl.planning.bounded.conjuncts import automaton, formula_of_each_member
from drake_ltl.planning.bounded.problem import Problem
from drake_ltl.planning.bounded.standing import Standing

_FIRST_SLICE = 1.0
_LEAST_SLICE = 0.05
"""Times for the solver, which cannot go on where it was stopped [s]."""
_TOLERANCE = 1e-6
"""Of the solver, relative to the bound."""
_PHASES = ("prefix", "suffix")
Way = tuple[int, int]


class Counting:
    """The relaxation as a mixed-integer program."""

    def __init__(self, problem: Problem, members: Sequence[Alone | None], only: int | None = None):
        """Form the program.

        Args:
            problem: the problem.
            members: from `lone_members`.
            only: index of a member, to form the program of this one without the others.
        """
        self._problem, self._model = problem, mathopt.Model()
        ways = problem.integer_ways(below=True)
        self._scale = max((cost for row in ways for cost in row), default=0) or 1
        self._costs = [[cost / self._scale for cost in row] for row in ways]
        self._members = members
        self._objective: list[Any] = []
        self._carriers: dict[tuple[int, str, Way], list[tuple[int, Any, Any]]] = {}
        self._objects: list[dict[tuple[str, Way], tuple[Any, Any]]] = []
        if only is None:
            self._add_everyone()
        else:
            self._add_alone(only)
        self._model.minimize(_sum(self._objective))

    def _add_everyone(self) -> None:
        n = self._problem.n_agents
        self._objects = [self._add_alone(n + j) for j in range(self._problem.n_objects)]
        for agent in range(n):
            self._add_agent(agent)
        self._add_teams()

    def bound(self, seconds: float) -> tuple[int, bool]:
        """A lower bound in units of cost, and whether it is all that can be had from this program."""
        limit = timedelta(seconds=max(seconds, 0.01))
        parameters = mathopt.SolveParameters(time_limit=limit)
        result = mathopt.solve(self._model, mathopt.SolverType.HIGHS, params=parameters)
        done = result.termination.reason == mathopt.TerminationReason.OPTIMAL
        dual = result.termination.objective_bounds.dual_bound * self._scale
        if not math.isfinite(dual):
            return 0, done
        # The cost of a lasso is a whole number of units; the solver's tolerance is relative.
        return max(0, math.ceil(dual - 1e-3 - _TOLERANCE * abs(dual))), done

    # ---- the numbers

    def _number(self) -> Any:
        return self._model.add_variable(lb=0.0)

    def _bool(self) -> Any:
        return self._model.add_binary_variable()

    def _add(self, constraint: Any) -> None:
        if constraint is not True:
            self._model.add_linear_constraint(constraint)

    def _possible(self, member: int) -> list[Way]:
        regions, lone = range(self._problem.n_regions), self._members[member]
        return sorted(lone.ways) if lone is not None else [(a, b) for a in regions for b in regions if a != b]

    def _add_costs(self, counts: Mapping[tuple[str, Way], list[Any]]) -> None:
        """What a member's ways cost."""
        for (_, (a, b)), numbers in counts.items():
            self._objective += [self._costs[a][b] * number for number in numbers]

    def _add_alone(self, member: int) -> dict[tuple[str, Way], tuple[Any, Any]]:
        """How often an object (or an agent without objects) goes, and whether, in each phase, each way."""
        counts = {(phase, way): self._number() for phase in _PHASES for way in self._possible(member)}
        whether = {key: self._bool() for key in counts}
        for key, number in counts.items():
            self._add(whether[key] <= number)
        self._add_costs({key: [number] for key, number in counts.items()})
        end = self._add_balance(member, {key: [number] for key, number in counts.items()})
        path = {way: self._number() for way in self._possible(member)}
        self._add_path(path, {self._problem.starts[member]: 1}, dict(enumerate(end)))
        for way, flow in path.items():
            self._add(flow <= whether["prefix", way])
        self._add_own_formula(member, {key: [number] for key, number in counts.items()}, end, whether)
        return {key: (number, whether[key]) for key, number in counts.items()}

    def _add_agent(self, agent: int) -> None:
        """Free ways and ways with each object."""
        counts: dict[tuple[str, Way], list[Any]] = {}
        for phase in _PHASES:
            for way in self._possible(agent):
                carrying = [self._carry(agent, j, phase, way) for j in range(self._problem.n_objects)]
                counts[phase, way] = [self._number(), *(y for y in carrying if y is not None)]
        self._add_costs(counts)
        end = self._add_balance(agent, counts)
        self._add_own_formula(agent, counts, end, {})
        self._add_approach(agent, counts)

    def _carry(self, agent: int, j: int, phase: str, way: Way) -> Any:
        """y_ij <= x_j; None where j does not go."""
        if (phase, way) not in self._objects[j]:
            return None
        times, whether = self._objects[j][phase, way]
        number, ever = self._number(), self._bool()
        self._add(number <= times)
        self._add(ever <= number)
        self._add(ever <= whether)
        self._carriers.setdefault((j, phase, way), []).append((agent, number, ever))
        return number

    def _add_teams(self) -> None:
        """Those who carry are strong enough: each time, and at all."""
        for j, ways in enumerate(self._objects):
            least = least_team(self._problem, j)
            for key, (times, whether) in ways.items():
                team = self._carriers.get((j, *key), [])
                for needed, those in ((times, [y for _, y, _ in team]), (whether, [t for _, _, t in team])):
                    self._add(_sum(those) >= least * needed)
                    if self._problem.sum_rule:
                        zetas, needs = self._problem.powers
                        agents = [i for i, _, _ in team]
                        total = _sum(zetas[i] * y for i, y in zip(agents, those, strict=True))
                        self._add(total >= needs[j] * needed)

    # ---- walks

    def _add_balance(self, member: int, counts: Mapping[tuple[str, Way], list[Any]]) -> list[Any]:
        """Ways add up to walks; where the suffix begins, one literal for each region."""
        end = [self._bool() for _ in range(self._problem.n_regions)]
        self._add(_sum(end) == 1.0)
        for k in range(self._problem.n_regions):
            first = float(k == self._problem.starts[member])
            self._add(_net(counts, "prefix", k) == first - end[k])
            self._add(_net(counts, "suffix", k) == 0.0)
        return end

    def _add_path(self, flow: Mapping[Way, Any], sources: Mapping[Any, Any], sinks: Mapping[Any, Any]) -> None:
        """A flow of at most one unit, from sources to sinks."""
        nodes = {node for ends in flow for node in ends} | set(sources) | set(sinks)
        balance: dict[Any, list[Any]] = {node: [] for node in nodes}
        for (a, b), number in flow.items():
            balance[a].append(number)
            balance[b].append(-number)
        for node, terms in balance.items():
            self._add(_sum(terms) == _sum([sources.get(node, 0.0)]) - sinks.get(node, 0.0))

    def _add_approach(self, agent: int, counts: Mapping[tuple[str, Way], list[Any]]) -> None:
        """An agent that carries out of a region gets there from its start."""
        ways, start = {way for _, way in counts}, self._problem.starts[agent]
        for k in range(self._problem.n_regions):
            carries = [
                ever
                for (_, _, way), team in self._carriers.items()
                for i, _, ever in team
                if i == agent and way[0] == k
            ]
            if k == start or not carries:
                continue
            there = self._model.add_variable(lb=0.0, ub=1.0)
            for ever in carries:
                self._add(there >= ever)
            path = {way: self._number() for way in ways}
            for way, flow in path.items():
                self._add(flow <= _sum([*counts["prefix", way], *counts["suffix", way]]))
            self._add_path(path, {start: there}, {k: there})

    def _add_own_formula(
        self,
        member: int,
        counts: Mapping[tuple[str, Way], list[Any]],
        end: Sequence[Any],
        whether: Mapping[tuple[str, Way], Any],
    ) -> None:
        """Steps of the product with the member's automaton whose ways add up to `counts`."""
        lone = self._members[member]
        if lone is None or lone.settles is None:
            return
        final = {node: self._bool() for node in sorted(lone.nodes)}
        for k, literal in enumerate(end):
            self._add(_sum(final[node] for node in final if node[0] == k) == literal)
        first = {step: self._number() for step in lone.steps}
        again = {step: self._number() for step in lone.steps}
        self._add_flows(lone, final, first, again)
        for way in {way for _, way in counts}:
            same = [s for s in lone.steps if (s.source[0], s.target[0]) == way]
            once = _sum(counts["suffix", way])
            self._add(_sum(first[s] for s in same) == _sum(counts["prefix", way]) + lone.settles * once)
            self._add(_sum(again[s] for s in same) == once)
        self._accept(lone, final, again, whether)

    def _add_flows(self, lone: Alone, final: Mapping, first: Mapping, again: Mapping) -> None:
        for node, literal in final.items():
            leaving = [step for step in lone.steps if step.source == node]
            entering = [step for step in lone.steps if step.target == node]
            balance = _sum(first[s] for s in leaving) - _sum(first[s] for s in entering)
            self._add(balance == float(node == lone.start) - literal)
            self._add(_sum(again[s] for s in leaving) == _sum(again[s] for s in entering))
            self._add(_sum(again[s] for s in leaving) >= literal)

    def _accept(self, lone: Alone, final: Mapping, again: Mapping, whether: Mapping) -> None:
        """Of each mark that is wanted, one step is connected with the beginning of the round, there and back."""
        chosen = [self._bool() for _ in lone.clauses]
        self._add(_sum(chosen) == 1.0)
        for clause, literal in zip(lone.clauses, chosen, strict=True):
            for mark in clause.often:
                self._meet([s for s in lone.steps if mark in s.marks], literal, final, again, whether)
            if len(lone.clauses) == 1:
                for step, number in again.items():
                    if step.marks & clause.never:
                        self._add(number <= 0.0)

    def _meet(self, marked: Sequence[Step], literal: Any, final: Mapping, again: Mapping, whether: Mapping) -> None:
        hits = {step: self._number() for step in marked}
        self._add(_sum(hits.values()) == literal)
        begin = {node: self._number() for node in final}  # `final`, if this clause is the chosen one
        for node, part in begin.items():
            self._add(part <= final[node])
        there = {node: _sum(h for s, h in hits.items() if s.source == node) for node in final}
        back = {node: _sum(h for s, h in hits.items() if s.target == node) for node in final}
        for sources, sinks in ((begin, there), (back, begin)):
            flow = {step: self._number() for step in again}
            self._add_path({(step.source, step.target): number for step, number in flow.items()}, sources, sinks)
            for step, number in flow.items():
                self._cover(step, number, again, whether)
        for step, hit in hits.items():
            self._cover(step, hit, again, whether)

    def _cover(self, step: Step, flow: Any, again: Mapping, whether: Mapping) -> None:
        """Where a path goes, the member goes."""
        self._add(flow <= again[step])
        way = (step.source[0], step.target[0])
        if ("suffix", way) in whether:
            self._add(flow <= whether["suffix", way])


def raise_bound(problem: Problem, members: Sequence[Alone | None], standing: Standing) -> None:
    """Raise the lower bound until nothing better can be proven, or time is over."""

    def bounds(program: Counting) -> Iterator[int]:
        seconds, done = _FIRST_SLICE, False
        while not done and not standing.stopped and not standing.proven and standing.left > _LEAST_SLICE:
            bound, done = program.bound(min(seconds, standing.left))
            yield bound
            seconds *= 4.0

    def told(units: int) -> int:
        standing.raise_bound(float(units * problem.unit))
        return units

    least = {m: max(bounds(Counting(problem, members, m)), default=0) for m in range(len(problem.members))}
    n = problem.n_agents
    told(sum((1 + least_team(problem, j)) * least[n + j] for j in range(problem.n_objects)))
    told(sum(least[i] for i in range(n)) + sum(least[n + j] for j in range(problem.n_objects)))
    while standing.cost is None and not standing.stopped and standing.left > 0.0:
        time.sleep(_LEAST_SLICE)  # the first plan comes first
    if not standing.stopped and not standing.proven:
        for units in bounds(Counting(problem, members)):
            told(units)


def lone_members(problem: Problem) -> list[Alone | None]:
    """What each member can do alone; None where no formula speaks of it alone.

    Raises:
        InfeasibleError: nothing at all, for one of them.
    """
    formulas = formula_of_each_member(problem.scenario)
    every = {(a, b) for a in range(problem.n_regions) for b in range(problem.n_regions) if a != b}
    found: list[Alone | None] = []
    for member, name in enumerate(problem.members):
        ways = every
        if member >= problem.n_agents:
            ways = {way for way in every if _can_go(problem, member - problem.n_agents, way, found)}
        formula = formulas.get(name, "1")
        if formula == "1" and ways == every:
            found.append(None)
            continue
        lone = alone(problem, member, automaton(formula), ways)
        if lone is None:
            raise InfeasibleError(f"no run from the initial state satisfies {formula}, even without the others")
        found.append(lone)
    return found


def _can_go(problem: Problem, obj: int, way: Way, agents: list[Alone | None]) -> bool:
    """Whether those agents that may go this way can carry an object along it."""
    able = [i for i, lone in enumerate(agents[: problem.n_agents]) if lone is None or way in lone.ways]
    if problem.strong_teams is not None:
        return any(team <= set(able) for team in problem.strong_teams[obj])
    return not problem.sum_rule or problem.carries(obj, able)


def least_team(problem: Problem, obj: int) -> int:
    """The least number of agents that can carry an object."""
    if problem.strong_teams is not None:
        return min((len(team) for team in problem.strong_teams[obj]), default=1)
    if not problem.sum_rule:
        return 1
    strongest = sorted(range(problem.n_agents), key=lambda i: -problem.powers[0][i])
    sizes = range(1, problem.n_agents + 1)
    return next((n for n in sizes if problem.carries(obj, strongest[:n])), 1)


def _net(counts: Mapping[tuple[str, Way], list[Any]], phase: str, region: int) -> Any:
    """How much more often a region is left than entered."""
    leaving = [x for (p, (a, _)), numbers in counts.items() if p == phase and a == region for x in numbers]
    entering = [x for (p, (_, b)), numbers in counts.items() if p == phase and b == region for x in numbers]
    return _sum(leaving) - _sum(entering)


def _sum(terms: Iterable[Any]) -> Any:
    return mathopt.LinearSum(terms)
