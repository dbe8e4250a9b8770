"""A lasso without its steps: what has to be done, by whom and in which order.

J is a sum over ways, so it does not depend on what happens at the same time. What is left of a lasso that matters to
its cost are its errands, in one order for the prefix and one for the suffix: an object is carried by a team from one
region to the next, or an agent visits a region for the sake of a formula. Between its errands an agent goes the
cheapest way (`routes`); grasps, releases and waiting follow from the order (`timetable`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from drake_ltl.planning.bounded.alone import Way
from drake_ltl.planning.bounded.problem import Problem, Run
from drake_ltl.planning.plan import State


@dataclass(frozen=True)
class Errand:
    """A transport, or one agent's visit."""

    start: int
    goal: int
    """Indices of regions; a visit ends where it starts."""
    team: frozenset[int]
    object: int | None = None
    """What is carried; None for a visit."""

    @property
    def way(self) -> Way:
        return self.start, self.goal


Agenda = tuple[tuple[Errand, ...], tuple[Errand, ...]]
"""Errands of the prefix and of the suffix, in their order."""


def visit(agent: int, region: int) -> Errand:
    """An agent comes to a region."""
    return Errand(region, region, frozenset({agent}))


def agenda_of(problem: Problem, run: Run) -> Agenda:
    """The errands of a lasso; each free move counts as a visit where it ends."""
    states, loop = run
    steps = list(pairwise((*states, states[loop])))
    phases = [tuple(errand for step in part for errand in _errands(problem, *step)) for part in _split(steps, loop)]
    return phases[0], phases[1]


def _split(steps: list, loop: int) -> tuple[list, list]:
    return steps[:loop], steps[loop:]


def _errands(problem: Problem, before: State, after: State) -> Iterator[Errand]:
    index, names = problem.scenario.region_names.index, problem.scenario.object_names
    for i, (a, b, grasp) in enumerate(zip(before.agents, after.agents, before.grasps, strict=True)):
        if a != b and grasp is None:
            yield visit(i, index(b))
    for j, (a, b) in enumerate(zip(before.objects, after.objects, strict=True)):
        if a != b:
            team = frozenset(i for i, grasp in enumerate(before.grasps) if grasp == names[j])
            yield Errand(index(a), index(b), team, j)
