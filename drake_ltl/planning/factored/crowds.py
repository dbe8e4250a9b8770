"""Agents that may be exchanged without changing anything, described by how many of them have each option."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations_with_replacement, permutations
from math import comb

import numpy as np
from numpy.typing import NDArray

from drake_ltl.scenario.formulas import global_formula
from drake_ltl.scenario.model import Scenario
from drake_ltl.spot_support import require_spot

MOST_FORMATIONS = 500
"""Larger crowds are taken apart: their tables (formations before x after) would outgrow what merging saves."""


@dataclass(frozen=True, eq=False)
class Crowd:
    """r agents with O options each: free in one of K regions, or grasping one of M objects.

    A formation is what they do together, leaving open who does what: a multiset of r options.
    """

    agents: tuple[int, ...]
    n_options: int

    @property
    def size(self) -> int:
        """Number n of formations."""
        return comb(len(self.agents) + self.n_options - 1, len(self.agents))

    @cached_property
    def formations(self) -> NDArray[np.int64]:
        """(n, r): the options of each formation, sorted; rows in lexicographic order."""
        rows = list(combinations_with_replacement(range(self.n_options), len(self.agents)))
        return np.array(rows, dtype=np.int64).reshape(len(rows), len(self.agents))

    @cached_property
    def counts(self) -> NDArray[np.int64]:
        """(n, O): how many agents have each option."""
        return (self.formations[:, :, None] == np.arange(self.n_options)).sum(axis=1)

    def index(self, options: list[int]) -> int:
        """The number of the formation with these options, in any order."""
        return self._numbers[tuple(sorted(options))]

    def arrangements(self, formation: int) -> NDArray[np.int64]:
        """(R, r): all ways to say who has which of a formation's options; the sorted one comes first."""
        return np.array(sorted(set(permutations(self.formations[formation].tolist()))), dtype=np.int64)

    def least_ways(self, single: NDArray[np.float64]) -> NDArray[np.float64]:
        """What it costs to get from one formation to another.

        Args:
            single: (C, O, O), cost for one agent to get from option to option, in C cases.

        Returns:
            (C, n, n): the least sum over all ways to say who goes where.
        """
        fewer, ways = Crowd((), self.n_options), np.zeros((len(single), 1, 1))
        for k in range(1, len(self.agents) + 1):
            crowd = Crowd(self.agents[:k], self.n_options)
            rows = crowd.formations
            rest = np.array([[fewer.index([*row[:i], *row[i + 1 :]]) for i in range(k)] for row in rows.tolist()])
            more = np.full((len(single), crowd.size, crowd.size), np.inf)
            for i in range(k):  # the first one before may become any of those after
                first = single[:, rows[:, :1], rows[:, i]]
                np.minimum(more, first + ways[:, rest[:, :1], rest[:, i]], out=more)
            fewer, ways = crowd, more
        return ways

    @cached_property
    def _numbers(self) -> dict[tuple[int, ...], int]:
        return {tuple(row): i for i, row in enumerate(self.formations.tolist())}


def crowds(scenario: Scenario, merge: bool) -> tuple[Crowd, ...]:
    """All agents in crowds, the crowd with the most formations last.

    Args:
        scenario: says who has the same power and is not named in any formula.
        merge: whether such agents may be exchanged; otherwise each is a crowd of its own.
    """
    n_options = len(scenario.regions) + len(scenario.objects)
    groups: dict[object, list[int]] = {}
    named = _named(scenario)
    for i, agent in enumerate(scenario.agents):
        alone = not merge or agent.name in named
        groups.setdefault(agent.name if alone else agent.power, []).append(i)
    found = [Crowd(tuple(part), n_options) for group in groups.values() for part in _parts(group, n_options)]
    return tuple(sorted(found, key=lambda crowd: crowd.size))


def _parts(group: list[int], n_options: int) -> list[list[int]]:
    most = 1
    while comb(most + n_options, most + 1) <= MOST_FORMATIONS and most < len(group):
        most += 1
    return [group[i : i + most] for i in range(0, len(group), most)]


def _named(scenario: Scenario) -> set[str]:
    """Members of which the formulas speak."""
    spot = require_spot()
    propositions = spot.atomic_prop_collect(spot.formula(global_formula(scenario)))
    return {ap.ap_name().split(".")[0] for ap in propositions}
