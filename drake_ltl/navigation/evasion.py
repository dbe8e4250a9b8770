"""How one mover gets out of the way of another: what is asked when who stands in the way can move as well."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from drake_ltl.navigation.detour import CLEARANCES, Scene, detour
from drake_ltl.navigation.relations import Array
from drake_ltl.navigation.step import StepRelations

SLACK = 0.15
"""Movers stop this near to a way point [m]."""
MOST_PLACES = 24
"""That are looked at more closely, spread over all where the mover would be out of the way."""


def evasion(evader: StepRelations, barred: StepRelations) -> list[tuple[float, float]] | None:
    """Way points (x, y) [m] of a mover to where it is out of the way that another would then go to its goal.

    The last of them is the place: the nearest from which, of those looked at, the mover gets to its own goal when the
    other has arrived. None if there is none, or if the other has no way even without the mover.

    Args:
        evader: the relations of the mover alone, the other standing where it is.
        barred: those of the other alone, the mover standing where it is.
    """
    name, other = evader.movers[0], barred.movers[0]
    free = _without(barred, name)
    if any(free.relations.violated(ends) for ends in (free.start, free.goal)) or (way := detour(free)) is None:
        return None
    line = np.vstack([free.start[:1, :2], *np.array(way).reshape(-1, 1, 2), free.goal[:1, :2]])
    (reach,) = (pair.radius for pair in barred.relations.apart if pair.b == barred.index(name))
    for clearance in CLEARANCES:
        scene = Scene(replace(evader, goal=evader.start), clearance)
        tree = scene.tree()
        aside = np.flatnonzero(np.isfinite(tree.distances) & (_distance(tree.nodes, line) >= reach + clearance + SLACK))
        nearest_first = aside[np.argsort(tree.distances[aside], kind="stable")]
        for node in nearest_first[:: max(1, len(aside) // MOST_PLACES)]:
            if _gets_home(evader, tree.nodes[node], other, barred.goal[0]):
                return scene.corners(tree, int(node))
    return None


def _without(step: StepRelations, name: str) -> StepRelations:
    """The same without a body that does not move."""
    gone = step.index(name)
    apart = tuple(pair for pair in step.relations.apart if gone not in (pair.a, pair.b))
    return replace(step, relations=replace(step.relations, apart=apart))


def _gets_home(evader: StepRelations, place: Array, other: str, p_other: Array) -> bool:
    """Whether the mover has a way from a place (2,) to its goal when the other is at p_other (3,)."""
    start, goal = evader.start.copy(), evader.goal.copy()
    start[0, :2] = place
    start[evader.index(other)] = goal[evader.index(other)] = p_other
    later = replace(evader, start=start, goal=goal)
    return not later.relations.violated(goal) and detour(later) is not None


def _distance(points: Array, line: Array) -> Array:
    """Of points (m, 2) from a line through corners (n, 2), (m,) [m]."""
    least = np.full(len(points), np.inf)
    for a, b in pairwise(line):
        along = b - a
        share = np.clip((points - a) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
        least = np.minimum(least, np.linalg.norm(points - a - share[:, None] * along, axis=1))
    return least
