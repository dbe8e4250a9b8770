"""Transitions of Def. 5 (iii) by factors: what each agent does, times which objects are moved by whom.

Which pairs (before, after) of options an agent has depends on where the objects are, but how many it has does not.
So all transitions in which certain teams move certain objects form a full box: an axis for each agent and one for
the places of the objects, and codes, costs and numbers of actions are sums over the axes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.costs import region_costs
from drake_ltl.planning.power import CanCarry
from drake_ltl.planning.weights import evened
from drake_ltl.scenario.model import Scenario

CHUNK = 1 << 18
"""Boxes are cut so that pieces have about so many transitions, which a cache holds."""


@dataclass(frozen=True, eq=False)
class Pairs:
    """What one agent may do, for each of C ways to place the objects; P pairs of options."""

    before: NDArray[np.int64]
    """(P, C): k < K for free in region k, K + j for grasping object j."""
    after: NDArray[np.int64]
    """(P, C)"""
    costs: NDArray[np.float64]
    """(P,): of the agent's own way."""
    acts: NDArray[np.int64]
    """(P,): 1 if the agent does anything."""
    objects: NDArray[np.int64]
    """(P,): the object concerned, -1 if none."""

    def __getitem__(self, rows: NDArray) -> Pairs:
        return Pairs(self.before[rows], self.after[rows], self.costs[rows], self.acts[rows], self.objects[rows])


@dataclass(frozen=True, eq=False)
class Box:
    """All transitions in which some teams move some objects."""

    moved: tuple[int, ...]
    """The objects."""
    pairs: tuple[Pairs, ...]
    """For each agent; a team's members keep their grasp."""
    places: NDArray[np.int64]
    """(n,): where the objects are before, as an index into the C ways."""
    goals: NDArray[np.int64]
    """(n,): and after."""
    costs: NDArray[np.float64]
    """(n,): of the ways of objects and teams."""
    acts: int
    """Number of agents that carry."""

    @property
    def size(self) -> int:
        return len(self.places) * math.prod(len(pairs.costs) for pairs in self.pairs)

    def pieces(self) -> Iterator[Box]:
        """The box cut along its last axis."""
        each = max(1, CHUNK * len(self.places) // max(self.size, 1))
        for start in range(0, len(self.places), each):
            cut = slice(start, start + each)
            yield Box(self.moved, self.pairs, self.places[cut], self.goals[cut], self.costs[cut], self.acts)

    def codes(self, n_options: int, n_places: int) -> tuple[NDArray, NDArray]:
        """Codes of the states before and after, (size,): mixed-radix numbers, agents first.

        They are added up as short integers and returned as those by which NumPy finds values fastest.
        """
        kind = np.int32 if n_options ** len(self.pairs) * n_places < 2**31 else np.int64
        before, after = self.places.astype(kind)[None], self.goals.astype(kind)[None]
        unit = n_places
        for pairs in reversed(self.pairs):
            first, second = (x[:, self.places].astype(kind) * kind(unit) for x in (pairs.before, pairs.after))
            before = (first[:, None] + before).reshape(-1, len(self.places))
            after = (second[:, None] + after).reshape(-1, len(self.places))
            unit *= n_options
        return before.reshape(-1).astype(np.intp), after.reshape(-1).astype(np.intp)

    def total(self) -> tuple[NDArray, NDArray]:
        """Costs and numbers of actions, (size,)."""
        costs, acts = self.costs, np.full(len(self.places), self.acts, dtype=np.int16)
        for pairs in reversed(self.pairs):
            costs = np.add.outer(pairs.costs, costs).reshape(-1)
            acts = np.add.outer(pairs.acts.astype(np.int16), acts).reshape(-1)
        return costs, acts


def ways_to_place(scenario: Scenario) -> NDArray[np.int64]:
    """(C, M): region of each object, for all C = K^M ways to place them."""
    n_regions, n_objects = len(scenario.regions), len(scenario.objects)
    return np.indices((n_regions,) * n_objects).reshape(n_objects, n_regions**n_objects).T


def boxes(scenario: Scenario, can_carry: CanCarry) -> Iterator[Box]:
    """All transitions, P_s left aside; the box in which no object is moved comes first."""
    places, pairs, matrix = ways_to_place(scenario), _pairs(scenario), way_costs(scenario)
    n_agents, n_objects = len(scenario.agents), len(scenario.objects)
    strong = cache(lambda j, team: _is_strong(scenario, can_carry, j, team))
    for carries in product(range(-1, n_objects), repeat=n_agents):
        teams = {j: tuple(i for i in range(n_agents) if carries[i] == j) for j in range(n_objects) if j in carries}
        if not all(strong(j, team) for j, team in teams.items()):
            continue
        others = pairs[np.array([j not in teams for j in pairs.objects.tolist()])]
        holding = {j: pairs[(pairs.objects == j) & (pairs.acts == 0)] for j in teams}
        yield Box(
            tuple(teams),
            tuple(others if j < 0 else holding[j] for j in carries),
            *_ways(places, {j: len(team) for j, team in teams.items()}, matrix),
            sum(len(team) for team in teams.values()),
        )


def n_choices(scenario: Scenario) -> int:
    """Number of transitions in which no object is moved, P_s left aside: most of them."""
    n_regions, n_objects = len(scenario.regions), len(scenario.objects)
    return n_regions**n_objects * (n_regions**2 + 3 * n_objects) ** len(scenario.agents)


def _is_strong(scenario: Scenario, can_carry: CanCarry, j: int, team: tuple[int, ...]) -> bool:
    return bool(can_carry(scenario.objects[j].name, frozenset(scenario.agents[i].name for i in team)))


def way_costs(scenario: Scenario) -> NDArray[np.float64]:
    """(K, K): what one body's way costs, rounded (`weights.evened`) so that sums over all members can be compared."""
    table, names = region_costs(scenario), scenario.region_names
    costs = np.array([[table[start, goal] for goal in names] for start in names])
    return evened(costs, float(costs.max()) * (len(scenario.agents) + len(scenario.objects)))


def _pairs(scenario: Scenario) -> Pairs:
    """(iii)(1) to (iii)(3): a free agent travels anywhere or grasps an object of its region; one that grasps goes
    on, or releases the object where it is."""
    places, matrix = ways_to_place(scenario), way_costs(scenario)
    n_places, n_objects, n_regions = *places.shape, len(matrix)
    start, goal = (np.repeat(x.reshape(-1, 1), n_places, axis=1) for x in np.indices(matrix.shape))
    holding = np.repeat(n_regions + np.arange(n_objects)[:, None], n_places, axis=1)
    return Pairs(
        before=np.concatenate([start, places.T, holding, holding]),
        after=np.concatenate([goal, holding, holding, places.T]),
        costs=np.concatenate([matrix.reshape(-1), np.zeros(3 * n_objects)]),
        acts=np.concatenate([1 - np.eye(n_regions, dtype=int).reshape(-1), np.repeat([1, 0, 1], n_objects)]),
        objects=np.concatenate([np.full(n_regions**2, -1), np.tile(np.arange(n_objects), 3)]),
    )


def _ways(places: NDArray, teams: dict[int, int], matrix: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Places before and after, and costs, where exactly the given objects move, with teams of given sizes."""
    n_places, n_objects = places.shape
    n_regions = len(matrix)
    before = after = np.arange(n_places)
    costs = np.zeros(n_places)
    for j, size in teams.items():
        unit = n_regions ** (n_objects - 1 - j)
        by = np.arange(1, n_regions)  # regions further on, cyclically: never the same one
        start = places[before, j]
        goal = (start[:, None] + by) % n_regions
        after = (after[:, None] + unit * (goal - start[:, None])).reshape(-1)
        costs = (costs[:, None] + (1 + size) * matrix[start[:, None], goal]).reshape(-1)
        before = np.repeat(before, n_regions - 1)
    return before, after, costs
