"""Random starts from which a scenario's plan can be placed, every one of them equally likely.

The set of these starts has no simple shape: bodies must stand apart in their regions, by the least margin of planning
(or what the scenario's own start leaves of it: else a run's least clearance would be that of the draw), and around an
object there must be room for those who grasp it. So a random walk is taken in it, as Metropolis et al. (1953) did for
hard discs: a member is moved at random and stays there if the start is still one of the set. Both kinds of moves are as
likely there and back, so in the long run all starts are equally likely, and every start on the way is a valid one. The
walk has an end, though: where there is little room, starts are nearer to the scenario's own than in the long run.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping

import numpy as np

from drake_ltl.errors import InvalidInputError, PlacementError
from drake_ltl.planning.geometry import Geometry
from drake_ltl.planning.placement import place
from drake_ltl.planning.plan import Plan
from drake_ltl.planning.spheres import LEAST_MARGIN
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.starts import Starts, check_starts

Position = tuple[float, float]
"""x and y of a base or of an object's origin in W [m]."""

ROUNDS = 6
"""In each, every member is moved twice: anywhere in its region where it is apart from all, and to somewhere near."""
TRIES = 100
"""To find such a place; there is none where a region is full."""
NEAR = 0.5
"""[m]; objects often have no more room than that if all who carry them are to fit into the region."""
DIGITS = 4
"""Positions are whole tenths of a millimetre, as one would write them."""


def draw_starts(scenario: Scenario, geometry: Geometry, plan: Plan, rng: np.random.Generator) -> dict[str, Position]:
    """Positions of all members, each in the region where the scenario has it.

    Args:
        scenario: with a valid start, at which the walk begins.
        plan: one that can be placed from there; it can be from the drawn start as well.

    Raises:
        InvalidInputError: the scenario's own start is not valid.
    """
    walk = _Walk(scenario, geometry, plan)
    now = walk.begin
    for _ in range(ROUNDS):
        for name in now:
            now = walk.moved_anywhere(now, name, rng)
            now = walk.moved_near(now, name, rng)
    return now


def placed_at(scenario: Scenario, positions: Mapping[str, Position]) -> Scenario:
    """The scenario with its members at other positions (its text is not changed)."""
    agents, objects = (
        tuple(dataclasses.replace(member, position=positions[member.name]) for member in members)
        for members in (scenario.agents, scenario.objects)
    )
    return dataclasses.replace(scenario, agents=agents, objects=objects)


def _in_disc(centre: tuple[float, ...], radius: float, rng: np.random.Generator) -> Position:
    angle, distance = rng.uniform(0.0, 2.0 * math.pi), radius * math.sqrt(rng.uniform())
    x, y = centre[0] + distance * math.cos(angle), centre[1] + distance * math.sin(angle)
    return round(x, DIGITS), round(y, DIGITS)


class _Walk:
    """What moves are judged by."""

    def __init__(self, scenario: Scenario, geometry: Geometry, plan: Plan):
        self._scenario, self._geometry, self._plan = scenario, geometry, plan
        starts = check_starts(scenario, geometry)
        self._home = _homes(starts)
        self._margin = min(LEAST_MARGIN, self._least_gap(starts))
        self.begin = {member.name: member.position for member in (*scenario.agents, *scenario.objects)}

    def moved_anywhere(self, now: dict[str, Position], name: str, rng: np.random.Generator) -> dict[str, Position]:
        """Where it is apart from all, each place as likely: so the way back is as likely too."""
        region = self._scenario.region(self._home[name])
        for _ in range(TRIES):
            moved = {**now, name: _in_disc(region.centre[:2], region.radius, rng)}
            starts = self._starts(moved)
            if starts is not None:
                return moved if self._has_places(moved, starts) else now
        return now

    def moved_near(self, now: dict[str, Position], name: str, rng: np.random.Generator) -> dict[str, Position]:
        moved = {**now, name: _in_disc(now[name], NEAR, rng)}
        starts = self._starts(moved)
        return moved if starts is not None and self._has_places(moved, starts) else now

    def _starts(self, positions: Mapping[str, Position]) -> Starts | None:
        """None where some sphere is too near to another or is not in its region."""
        try:
            starts = check_starts(placed_at(self._scenario, positions), self._geometry)
        except InvalidInputError:
            return None
        return starts if _homes(starts) == self._home and self._least_gap(starts) >= self._margin else None

    def _least_gap(self, starts: Starts) -> float:
        """Between any two bounding spheres [m]."""
        spheres = [(start.p_WC, self._geometry.agent_radius[name]) for name, start in starts.agents.items()]
        spheres += [(start.p_WO, self._geometry.object_radius[name]) for name, start in starts.objects.items()]
        gaps = (math.dist(p, q) - r - s for (p, r), (q, s) in itertools.combinations(spheres, 2))
        return min(gaps, default=math.inf)

    def _has_places(self, positions: Mapping[str, Position], starts: Starts) -> bool:
        """Whether the plan can be placed; this takes the longest of all."""
        try:
            place(self._plan, placed_at(self._scenario, positions), self._geometry, starts)
        except PlacementError:
            return False
        return True


def _homes(starts: Starts) -> dict[str, str]:
    """Region of each member."""
    return {name: start.region for name, start in (*starts.agents.items(), *starts.objects.items())}
