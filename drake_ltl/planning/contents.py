"""P_s on arrays: asks the predicate `fits` once for every different content of a region."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.fits import Content, Fits
from drake_ltl.scenario.model import Region, Scenario


@dataclass(frozen=True)
class Fitting:
    """The predicate with its answers so far.

    A content is a number whose digits say, from the lowest: for each object whether it is there and whether
    it is carried (two bits); for each agent 0 if it is not there, 1 if it is there and free, 2 + j if it grasps
    object j.
    """

    scenario: Scenario
    fits: Fits
    answers: dict[tuple[str, int], bool] = field(default_factory=dict, compare=False)

    def check(
        self, region: int, options: NDArray, places: NDArray, carried: NDArray | None = None
    ) -> NDArray[np.bool_]:
        """Whether the content of one region fits, for each of n states.

        Args:
            region: index of the region.
            options: what each agent does, (n, N), as in `TransitionSystem.options`.
            places: region of each object, (n, M).
            carried: which objects count as carried, (n, M); None means none.
        """
        codes, inverse = np.unique(self._codes(region, options, places, carried), return_inverse=True)
        answers = [self._ask(self.scenario.regions[region], code) for code in codes.tolist()]
        return np.array(answers, dtype=bool)[inverse]

    def _codes(self, region: int, options: NDArray, places: NDArray, carried: NDArray | None) -> NDArray[np.int64]:
        regions, objects = len(self.scenario.regions), places.shape[1]
        codes = np.zeros(len(options), dtype=np.int64)
        for agent in range(options.shape[1] - 1, -1, -1):
            option = options[:, agent]
            grasps = option >= regions
            held = np.where(grasps, option - regions, 0)
            at = places[np.arange(len(places)), held] == region if objects else np.zeros(len(places), bool)
            digit = np.where(grasps, np.where(at, 2 + held, 0), option == region)
            codes = codes * (objects + 2) + digit
        for obj in range(objects - 1, -1, -1):
            codes = codes * 4 + (places[:, obj] == region)
            if carried is not None:
                codes += 2 * carried[:, obj]
        return codes

    def _ask(self, region: Region, code: int) -> bool:
        key = (region.name, code)
        if key not in self.answers:
            content = self._decode(code)
            empty = not (content.free_agents or content.objects)
            self.answers[key] = empty or bool(self.fits(region, content))
        return self.answers[key]

    def _decode(self, code: int) -> Content:
        objects, carried = [], []
        for name in self.scenario.object_names:
            code, bits = divmod(code, 4)
            objects += [name] if bits & 1 else []
            carried += [name] if bits & 2 else []
        free, holds = [], []
        for name in self.scenario.agent_names:
            code, digit = divmod(code, len(self.scenario.objects) + 2)
            if digit == 1:
                free.append(name)
            elif digit >= 2:
                holds.append((name, self.scenario.object_names[digit - 2]))
        return Content(tuple(free), tuple(objects), tuple(holds), frozenset(carried))
