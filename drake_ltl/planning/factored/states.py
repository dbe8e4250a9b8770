"""The states of TS with the agents of a crowd merged: a full box of places times formations, never listed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.contents import Fitting
from drake_ltl.planning.factored.crowds import Crowd
from drake_ltl.planning.factors import ways_to_place
from drake_ltl.planning.fits import Fits
from drake_ltl.planning.transition_system import agent_regions
from drake_ltl.scenario.model import Scenario


@dataclass(frozen=True, eq=False)
class MergedStates:
    """P = K^M ways to place the objects times F joint formations, the last crowd's varying fastest."""

    scenario: Scenario
    fits: Fits
    crowds: tuple[Crowd, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of formations of each crowd."""
        return tuple(crowd.size for crowd in self.crowds)

    @property
    def n_formations(self) -> int:
        """F."""
        return math.prod(self.shape)

    @property
    def n_states(self) -> int:
        """P F, possible or not."""
        return len(self.scenario.regions) ** len(self.scenario.objects) * self.n_formations

    @cached_property
    def places(self) -> NDArray[np.int64]:
        """(P, M): region of each object."""
        return ways_to_place(self.scenario)

    @cached_property
    def options(self) -> NDArray[np.int8]:
        """(F, N): an option for each agent; those of a crowd in order."""
        options = np.zeros((self.n_formations, len(self.scenario.agents)), dtype=np.int8)
        for c, crowd in enumerate(self.crowds):
            options[:, crowd.agents] = self._spread(c, crowd.formations.T.astype(np.int8)).T
        return options

    @cached_property
    def holders(self) -> NDArray[np.int64]:
        """(M, F): how many agents grasp each object."""
        n_regions = len(self.scenario.regions)
        parts = [self._spread(c, crowd.counts.T[n_regions:]) for c, crowd in enumerate(self.crowds)]
        return np.sum(parts, axis=0)

    @cached_property
    def possible(self) -> NDArray[np.bool_]:
        """(P, F): Def. 5 (i), whether the contents of all regions fit."""
        return self.room_for(())

    @cached_property
    def n_possible(self) -> int:
        """How many states of TS the possible ones stand for."""
        ways = np.ones(self.n_formations, dtype=np.int64)
        for c, crowd in enumerate(self.crowds):
            each = [math.factorial(len(crowd.agents)) // math.prod(map(math.factorial, row)) for row in crowd.counts]
            ways *= self._spread(c, np.array(each))
        return int((self.possible * ways).sum())

    def room_for(self, moved: tuple[int, ...]) -> NDArray[np.bool_]:
        """(P, F): whether all fits if some objects count as carried."""
        room = np.ones((len(self.places), self.n_formations), dtype=bool)
        for region in range(len(self.scenario.regions)):
            codes = self._contents(region)
            for j in moved:
                codes += ((self.places[:, j] == region) * self._fitting.carried(j))[:, None]
            rows = np.flatnonzero(room)
            room.reshape(-1)[rows] = self._fitting.check(region, codes.reshape(-1)[rows])
        return room

    def number(self, options: list[int], places: list[int]) -> int:
        """The merged state of a state of TS; -1 if that is impossible."""
        numbers = [crowd.index([options[i] for i in crowd.agents]) for crowd in self.crowds]
        place = sum(k * len(self.scenario.regions) ** i for i, k in enumerate(reversed(places)))
        formation = int(np.ravel_multi_index(numbers, self.shape)) if numbers else 0
        return place * self.n_formations + formation if self.possible[place, formation] else -1

    def listed(self, states: NDArray) -> Listed:
        """Some merged states, each by one of the states it stands for."""
        places, formations = np.divmod(states, self.n_formations)
        return Listed(self.scenario, self.options[formations].astype(np.int64), self.places[places])

    def _spread(self, crowd: int, values: NDArray) -> NDArray:
        """Values (.., n) of one crowd's formations, for all joint ones: (.., F)."""
        axes = np.ones(len(self.crowds), dtype=int)
        axes[crowd] = self.shape[crowd]
        box = np.broadcast_to(values.reshape(*values.shape[:-1], *axes), (*values.shape[:-1], *self.shape))
        return box.reshape(*values.shape[:-1], -1)

    @cached_property
    def _fitting(self) -> Fitting:
        return Fitting(self.scenario, self.fits)

    def _contents(self, region: int) -> NDArray[np.int64]:
        """(P, F): codes of what is in a region."""
        n_regions, n_objects = len(self.scenario.regions), len(self.scenario.objects)
        there = self.places == region
        digits = np.zeros((len(self.places), n_regions + n_objects), dtype=np.int64)
        digits[:, region] = 1
        digits[:, n_regions:] = there * (2 + np.arange(n_objects))
        codes = np.tile((there @ (1 << 2 * np.arange(n_objects)))[:, None], (1, self.n_formations))
        for c, crowd in enumerate(self.crowds):
            units = np.array([self._fitting.unit(agent) for agent in crowd.agents])
            codes += self._spread(c, digits[:, crowd.formations] @ units)
        return codes


@dataclass(frozen=True, eq=False)
class Listed:
    """S states as arrays, like those of `TransitionSystem`."""

    scenario: Scenario
    options: NDArray[np.int64]
    """(S, N)"""
    places: NDArray[np.int64]
    """(S, M)"""

    @property
    def n_states(self) -> int:
        return len(self.options)

    @property
    def agent_regions(self) -> NDArray[np.int64]:
        """(S, N): region of each agent."""
        return agent_regions(self.options, self.places, len(self.scenario.regions))
