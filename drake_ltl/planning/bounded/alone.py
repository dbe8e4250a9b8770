"""What one member can do alone: its regions times the automaton of the formulas that speak of it alone."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import networkx as nx

from drake_ltl.planning.bounded.conjuncts import Clause, Conjunct
from drake_ltl.planning.bounded.problem import Problem

Way = tuple[int, int]
"""Two different regions."""
Node = tuple[int, int]
"""(region, state of the automaton after reading the letter there)"""


@dataclass(frozen=True)
class Step:
    """Going to a region, or staying, while the automaton reads."""

    source: Node
    target: Node
    marks: frozenset[int]


@dataclass(frozen=True)
class Alone:
    """All steps of a member that lie on accepted lassos, when all others are left out."""

    start: Node
    steps: tuple[Step, ...]
    clauses: tuple[Clause, ...]
    settles: int | None

    @cached_property
    def nodes(self) -> set[Node]:
        """(region, state) pairs, the start included."""
        return {self.start} | {node for step in self.steps for node in (step.source, step.target)}

    @cached_property
    def ways(self) -> frozenset[Way]:
        """Pairs of different regions between which it may go."""
        return frozenset((s.source[0], s.target[0]) for s in self.steps if s.source[0] != s.target[0])


def alone(problem: Problem, member: int, conjunct: Conjunct, ways: Iterable[tuple[int, int]]) -> Alone | None:
    """The steps of one member, or None if no lasso of its own is accepted.

    Args:
        problem: the problem.
        member: its index; agents come first.
        conjunct: automaton that speaks of this member alone.
        ways: pairs of different regions between which it can go at all.
    """
    name, region = problem.members[member], problem.starts[member]
    state, _ = conjunct.read(conjunct.initial, problem.labels[name, region])
    if state is None:
        return None
    goals: dict[int, list[int]] = {k: [k] for k in range(problem.n_regions)}
    for a, b in ways:
        goals[a].append(b)
    start, steps = (region, state), []
    met, fresh = {start}, [start]
    while fresh:
        k, q = fresh.pop()
        for goal in goals[k]:
            target, marks = conjunct.read(q, problem.labels[name, goal])
            if target is None:
                continue
            steps.append(Step((k, q), (goal, target), marks))
            if (goal, target) not in met:
                met.add((goal, target))
                fresh.append((goal, target))
    return _trimmed(start, steps, conjunct)


def _trimmed(start: Node, steps: list[Step], conjunct: Conjunct) -> Alone | None:
    """Without steps from which no accepting circle can be reached."""
    graph = nx.DiGraph((step.source, step.target) for step in steps)
    goals = {node for clause in conjunct.clauses for node in _accepting(steps, clause)}
    useful = goals.union(*(nx.ancestors(graph, node) for node in goals))
    if start not in useful:
        return None
    kept = tuple(step for step in steps if step.source in useful and step.target in useful)
    return Alone(start, kept, conjunct.clauses, conjunct.settles)


def _accepting(steps: list[Step], clause: Clause) -> set[Node]:
    """Nodes on circles that meet all marks of a clause it wants, and none it does not."""
    allowed = [step for step in steps if not step.marks & clause.never]
    graph = nx.DiGraph((step.source, step.target) for step in allowed)
    found = set()
    for component in nx.strongly_connected_components(graph):
        inner = [s.marks for s in allowed if s.source in component and s.target in component]
        if inner and clause.often <= frozenset().union(*inner):
            found |= component
    return found
