"""chi: what a transition costs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import pairwise

from drake_ltl.planning.plan import State
from drake_ltl.scenario.model import Scenario

Chi = Callable[[State, State], float]
"""chi: the cost of a transition, at least zero."""


def region_costs(scenario: Scenario) -> dict[tuple[str, str], float]:
    """What one body's way from region to region costs, by the scenario's `cost`.

    Returns the distance of the two regions' centres [m], or its square [m^2].
    """
    costs = {}
    for start in scenario.regions:
        for goal in scenario.regions:
            squares = [(a - b) ** 2 for a, b in zip(start.centre, goal.centre, strict=True)]
            square = math.fsum(squares)
            costs[start.name, goal.name] = square if scenario.cost == "squared_distance" else math.sqrt(square)
    return costs


def sum_of_ways(scenario: Scenario) -> Chi:
    """The cost of the paper's examples: the regions' costs, summed over all agents and objects."""
    costs = region_costs(scenario)

    def chi(before: State, after: State) -> float:
        ways = zip(before.agents + before.objects, after.agents + after.objects, strict=True)
        return math.fsum(costs[way] for way in ways)

    return chi


def path_cost(states: Iterable[State], chi: Chi) -> float:
    """Sum of chi along consecutive states."""
    return math.fsum(chi(before, after) for before, after in pairwise(states))
