"""The transitions of Def. 5 (iii) between merged states, crowd by crowd, never listed.

Once it is said which objects are moved, a transition is a sum: each crowd gets from one formation to another at a
cost of its own, and so do the objects. What agents cost that carry is added per agent that grasps.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.factored.states import MergedStates
from drake_ltl.planning.factors import way_costs
from drake_ltl.planning.power import CanCarry
from drake_ltl.planning.weights import ACTION_LIMIT, in_units

CHUNK = 1 << 16
CACHED = 1 << 15
"""Numbers worked on at once: so that memory stays small, so that a cache holds them."""


@dataclass(frozen=True, eq=False)
class Moves:
    """All transitions in which certain objects are moved, G ways to say where to from each place."""

    states: MergedStates
    moved: tuple[int, ...]
    allowed: NDArray[np.bool_]
    """(P, F): whether such a transition may begin in a state; also whether it may end there."""
    single: NDArray[np.float64]
    """(P, O, O): weight for one agent to get from option to option."""
    goals: NDArray[np.int64]
    """(P, G): places after."""
    steps: NDArray[np.float64]
    """(P, G): weight of the step and of the objects' ways."""
    escorts: tuple[NDArray[np.float64], ...]
    """For each object that is moved, (P, G): weight of each agent that carries it."""

    @cached_property
    def ahead(self) -> tuple[NDArray[np.float64], ...]:
        """For each crowd (P, n, n): weight to get from formation to formation."""
        return tuple(crowd.least_ways(self.single) for crowd in self.states.crowds)

    @cached_property
    def back(self) -> tuple[NDArray[np.float64], ...]:
        """The same from after to before."""
        return tuple(np.ascontiguousarray(ways.transpose(0, 2, 1)) for ways in self.ahead)

    @cached_property
    def origins(self) -> NDArray[np.int64]:
        """(P, G): from where the way g leads to a place."""
        origins = np.empty_like(self.goals)
        np.put_along_axis(origins, self.goals, np.arange(len(origins))[:, None], axis=0)
        return origins

    def weigh(self, places: NDArray, way: int, formations: NDArray) -> NDArray[np.float64]:
        """What way number `way` from some places costs besides what the crowds do, if they end in formations."""
        weights = self.steps[places, way]
        for j, escort in zip(self.moved, self.escorts, strict=True):
            weights = weights + escort[places, way] * self.states.holders[j, formations]
        return weights

    def spread(self, groups: NDArray, formations: NDArray, values: NDArray, places: NDArray, back: bool) -> NDArray:
        """What the crowds can do: from joint formations at given values to all others.

        Args:
            groups: (e,), non-decreasing; in which of b groups each value is. Values of a group are alternatives.
            formations: (e,), increasing within a group.
            values: (e,)
            places: (b,), where the objects are before.
            back: whether to go from after to before.

        Returns:
            (b, F): least value + weight.
        """
        tables, shape = self.back if back else self.ahead, self.states.shape
        if not shape:
            result = np.full((len(places), 1), np.inf)
            np.minimum.at(result[:, 0], groups, values)
            return result
        result = self._last(tables[-1], groups, formations, values, places)
        inner = shape[-1]
        for n, table in zip(reversed(shape[:-1]), reversed(tables[:-1]), strict=True):
            result = _along(result.reshape(len(places), -1, n, inner), table[places])
            inner *= n
        return result.reshape(len(places), -1)

    def _last(self, table: NDArray, groups: NDArray, formations: NDArray, values: NDArray, places: NDArray) -> NDArray:
        """Along the last crowd, where values are few."""
        n = self.states.shape[-1]
        n_others = self.states.n_formations // n
        lines = groups * n_others + formations // n
        starts = np.flatnonzero(np.append(True, lines[1:] != lines[:-1])) if len(lines) else np.zeros(0, int)
        ends = np.append(starts, len(lines))
        result = np.full((len(places) * n_others, n), np.inf)
        first = 0
        while first < len(starts):
            after = max(first + 1, int(np.searchsorted(ends, ends[first] + CHUNK // n, side="right")) - 1)
            piece = slice(ends[first], ends[after])
            rows = table[places[groups[piece]], formations[piece] % n] + values[piece, None]
            result[lines[starts[first:after]]] = np.minimum.reduceat(rows, starts[first:after] - ends[first], axis=0)
            first = after
        return result


def _along(values: NDArray, table: NDArray) -> NDArray[np.float64]:
    """(b, outer, n, inner) by (b, n, n): the least sum over the axis of length n."""
    result = np.full_like(values, np.inf)
    each = max(1, CACHED // max(values[:1].size, 1))
    for start in range(0, len(values), each):
        cut = slice(start, start + each)
        for i in range(values.shape[2]):
            np.minimum(result[cut], values[cut, :, i, None] + table[cut, None, i, :, None], out=result[cut])
    return result


def all_moves(states: MergedStates, can_carry: CanCarry, weight: float, largest: float) -> list[Moves]:
    """The transitions for each set of objects that may be moved together; first those that move none.

    Args:
        states: S.
        can_carry: Lambda; the same for agents of a crowd.
        weight: of the cost, alpha or beta.
        largest: no transition's cost, weighted, is greater; determines the unit of cost.
    """
    ways = in_units(weight * way_costs(states.scenario), largest)
    n_objects = len(states.scenario.objects)
    strong = [_strong(states, can_carry, j) for j in range(n_objects)]
    found = []
    for k in range(n_objects + 1 if len(ways) > 1 else 1):
        for moved in combinations(range(n_objects), k):
            allowed = states.possible & np.logical_and.reduce([strong[j] for j in moved])
            if moved and allowed.any():
                allowed &= states.room_for(moved)
            if allowed.any() or not moved:
                single = _single(states, ways, moved)
                found.append(Moves(states, moved, allowed, single, *_ways_of(states, ways, moved)))
    return found


def usual_weight(states: MergedStates, weight: float, largest: float) -> float:
    """The median weight of a step in which one agent travels."""
    ways = in_units(weight * way_costs(states.scenario), largest)
    positive = ways[ways > 0]
    return ACTION_LIMIT + (float(np.median(positive)) if len(positive) else 0.0)


def _single(states: MergedStates, ways: NDArray, moved: tuple[int, ...]) -> NDArray[np.float64]:
    """Def. 5 (iii)(1) to (3): nobody grasps or releases what is moved; who grasps it goes with it."""
    n_regions, (n_places, n_objects) = len(ways), states.places.shape
    single = np.full((n_places, n_regions + n_objects, n_regions + n_objects), np.inf)
    single[:, :n_regions, :n_regions] = ways + 1.0 - np.eye(n_regions)
    rows = np.arange(n_places)
    for j in range(n_objects):
        single[:, n_regions + j, n_regions + j] = 0.0
        if j not in moved:
            single[rows, states.places[:, j], n_regions + j] = 1.0
            single[rows, n_regions + j, states.places[:, j]] = 1.0
    return single


def _ways_of(states: MergedStates, ways: NDArray, moved: tuple[int, ...]) -> tuple[NDArray, NDArray, tuple]:
    """Goals, steps and escorts of `Moves`: each object goes by 1 .. K - 1 regions further on, cyclically."""
    n_regions, (n_places, n_objects) = len(ways), states.places.shape
    by = np.indices((n_regions - 1,) * len(moved)).reshape(len(moved), (n_regions - 1) ** len(moved)).T + 1
    goals = np.repeat(np.arange(n_places)[:, None], len(by), axis=1)
    steps, escorts = np.full(goals.shape, float(ACTION_LIMIT)), []
    for i, j in enumerate(moved):
        start = states.places[:, j, None]
        goal = (start + by[:, i]) % n_regions
        goals += n_regions ** (n_objects - 1 - j) * (goal - start)
        steps += ways[start, goal]
        escorts.append(ways[start, goal] + 1.0)
    return goals, steps, tuple(escorts)


def _strong(states: MergedStates, can_carry: CanCarry, j: int) -> NDArray[np.bool_]:
    """(F,): whether those that grasp an object are strong enough to carry it."""
    scenario = states.scenario
    grasping = states.options == len(scenario.regions) + j
    teams, team = np.unique(grasping, axis=0, return_inverse=True)
    names = [frozenset(a.name for a, there in zip(scenario.agents, row, strict=True) if there) for row in teams]
    answers = [bool(members) and bool(can_carry(scenario.objects[j].name, members)) for members in names]
    return np.array(answers, dtype=bool)[team.reshape(-1)]
