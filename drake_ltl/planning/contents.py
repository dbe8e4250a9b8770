"""P_s on arrays: asks the predicate `fits` once for every different content of a region."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.fits import Content, Fits
from drake_ltl.scenario.model import Region, Scenario

SMALL_TABLE = 1 << 14
"""Answers for so many codes are tabulated in any case; for more only if there are as many questions."""


@dataclass(frozen=True)
class Fitting:
    """The predicate with its answers so far.

    A content is a number whose digits say, from the lowest: for each object whether it is there and whether
    it is carried (two bits); for each agent 0 if it is not there, 1 if it is there and free, 2 + j if it grasps
    object j.
    """

    scenario: Scenario
    fits: Fits
    answers: dict[tuple[Hashable, int], bool] = field(default_factory=dict, compare=False)
    contents: dict[int, Content] = field(default_factory=dict, compare=False)
    """By their numbers; the same ones are asked about in many regions."""

    def grid(self, region: int, places: NDArray) -> NDArray[np.int64]:
        """Contents of one region for all combinations of what the members do.

        Args:
            region: index of the region.
            places: region of each object, (C, M).

        Returns:
            (K + M, .. K + M, C) in one dimension: an axis for the option of each agent, the last for the objects.
        """
        n_regions, (n_places, n_objects) = len(self.scenario.regions), places.shape
        there = places == region
        digits = np.zeros((n_regions + n_objects, n_places), dtype=np.int64)
        digits[region] = 1
        digits[n_regions:] = there.T * (2 + np.arange(n_objects))[:, None]
        codes = (there @ (1 << 2 * np.arange(n_objects)))[None]
        for agent in range(len(self.scenario.agents) - 1, -1, -1):
            codes = ((digits * self.unit(agent))[:, None] + codes).reshape(-1, n_places)
        return codes.reshape(-1)

    @staticmethod
    def carried(obj: int) -> int:
        """What to add to a content because an object that is there counts as carried."""
        return 2 << 2 * obj

    def check(self, region: int, codes: NDArray) -> NDArray[np.bool_]:
        """Whether contents of a region, given by codes (n,), fit."""
        size = self.unit(len(self.scenario.agents))
        if size > max(SMALL_TABLE, codes.size):
            different, inverse = np.unique(codes, return_inverse=True)
            return self._ask_all(region, different)[inverse]
        present = np.zeros(size, dtype=bool)
        present[codes] = True
        different = np.flatnonzero(present)
        present[different] = self._ask_all(region, different)
        return present[codes]

    def unit(self, agent: int) -> int:
        """Value of an agent's digit 1."""
        n_objects = len(self.scenario.objects)
        return 4**n_objects * (n_objects + 2) ** agent

    def _ask_all(self, region: int, codes: NDArray) -> NDArray[np.bool_]:
        where = self.scenario.regions[region]
        kind = self._kind(where)
        return np.array([self._ask(where, kind, code) for code in codes.tolist()], dtype=bool)

    def _kind(self, region: Region) -> Hashable:
        """Regions of the same kind give the same answers."""
        of_region = getattr(self.fits, "of_region", None)
        return region.name if of_region is None else of_region(region)

    def _ask(self, region: Region, kind: Hashable, code: int) -> bool:
        key = (kind, code)
        if key not in self.answers:
            if code not in self.contents:
                self.contents[code] = self._decode(code)
            content = self.contents[code]
            empty = not (content.free_agents or content.objects)
            self.answers[key] = empty or bool(self.fits(region, content))
        return self.answers[key]

    def _decode(self, code: int) -> Content:
        names, objects, carried = self.scenario.object_names, [], []
        for name in names:
            code, bits = divmod(code, 4)
            objects += [name] if bits & 1 else []
            carried += [name] if bits & 2 else []
        free, holds = [], []
        for name in self.scenario.agent_names:
            code, digit = divmod(code, len(names) + 2)
            if digit == 1:
                free.append(name)
            elif digit >= 2:
                holds.append((name, names[digit - 2]))
        return Content(tuple(free), tuple(objects), tuple(holds), frozenset(carried))
