"""A scenario in numbers: indices of regions and members, costs and powers as integers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise

from drake_ltl.planning.costs import region_costs
from drake_ltl.planning.plan import State
from drake_ltl.planning.power import CanCarry
from drake_ltl.scenario.formulas import labels
from drake_ltl.scenario.model import Scenario

Run = tuple[tuple[State, ...], int]
"""States 0 .. T - 1 and the index of the one to which the last step leads."""

_FINEST = 10**4
"""Costs are counted in units no finer than this part of 1."""


def exact(number: float) -> Fraction:
    """The decimal fraction that a number is written as: 0.1 is a tenth."""
    return Fraction(repr(float(number)))


@dataclass(frozen=True)
class Problem:
    """What both the model of lassos and the relaxation are made from."""

    scenario: Scenario
    start: State
    can_carry: CanCarry
    sum_rule: bool
    """Whether `can_carry` is that of the scenario's powers."""

    @property
    def n_regions(self) -> int:
        return len(self.scenario.regions)

    @property
    def n_agents(self) -> int:
        return len(self.scenario.agents)

    @property
    def n_objects(self) -> int:
        return len(self.scenario.objects)

    @property
    def members(self) -> tuple[str, ...]:
        """Agents, then objects."""
        return self.scenario.agent_names + self.scenario.object_names

    @cached_property
    def starts(self) -> tuple[int, ...]:
        """Region index of each member at the start."""
        index = {name: k for k, name in enumerate(self.scenario.region_names)}
        return tuple(index[region] for region in self.start.agents + self.start.objects)

    @cached_property
    def labels(self) -> dict[tuple[str, int], frozenset[str]]:
        """(member, region index) -> propositions `m.p` that hold."""
        names = self.scenario.region_names
        return {(m, k): labels(self.scenario, m, name) for m in self.members for k, name in enumerate(names)}

    @cached_property
    def first_letter(self) -> frozenset[str]:
        """What holds at the start."""
        return frozenset().union(*(self.labels[m, k] for m, k in zip(self.members, self.starts, strict=True)))

    @cached_property
    def ways(self) -> list[list[float]]:
        """(K, K): cost of one body's way from region to region."""
        table, names = region_costs(self.scenario), self.scenario.region_names
        return [[table[a, b] for b in names] for a in names]

    @cached_property
    def unit(self) -> Fraction:
        """The cost that the integer costs count: exact if a power of ten down to 1 / 10^4 is."""
        costs = [exact(cost) for row in self.ways for cost in row]
        digits = 1
        while digits < _FINEST and any((cost * digits).denominator != 1 for cost in costs):
            digits *= 10
        return Fraction(1, digits)

    def integer_ways(self, *, below: bool = False) -> list[list[int]]:
        """(K, K): the costs in units, to the nearest or rounded down."""
        costs = [[exact(cost) / self.unit for cost in row] for row in self.ways]
        return [[cost.__floor__() if below else round(cost) for cost in row] for row in costs]

    def cost(self, states: Iterable[State]) -> int:
        """Of consecutive states, in units."""
        index = {name: k for k, name in enumerate(self.scenario.region_names)}
        return sum(
            self._integer_ways[index[a]][index[b]]
            for before, after in pairwise(states)
            for a, b in zip(before.agents + before.objects, after.agents + after.objects, strict=True)
        )

    @cached_property
    def _integer_ways(self) -> list[list[int]]:
        return self.integer_ways()

    @cached_property
    def powers(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """zeta and Lambda as integers in the same unit (exact for decimal fractions)."""
        zetas = [exact(agent.power) for agent in self.scenario.agents]
        needs = [exact(obj.power_needed) for obj in self.scenario.objects]
        unit = 1
        while any((f * unit).denominator != 1 for f in (*zetas, *needs)):
            unit *= 10
        return tuple(int(f * unit) for f in zetas), tuple(int(f * unit) for f in needs)

    def carries(self, obj: int, agents: Iterable[int]) -> bool:
        """Lambda, by indices."""
        names = self.scenario.agent_names
        return bool(self.can_carry(self.scenario.objects[obj].name, frozenset(names[i] for i in agents)))

    @cached_property
    def strong_teams(self) -> list[list[frozenset[int]]] | None:
        """For each object all teams that can carry it; None if there are too many teams to ask."""
        if self.n_agents > 8:
            return None
        teams = [frozenset(i for i in range(self.n_agents) if bits >> i & 1) for bits in range(1, 1 << self.n_agents)]
        return [[team for team in teams if self.carries(j, team)] for j in range(self.n_objects)]
