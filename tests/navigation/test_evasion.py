"""One mover gets out of another's way, the other goes, and the first follows: every leg is driven here."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from drake_ltl.navigation import RegionBall, StaticBody, Traveller, step_relations
from drake_ltl.navigation.detour import detour
from drake_ltl.navigation.evasion import evasion

ROOM = RegionBall("room", (0.0, 0.0, 0.0), 5.0)


def alone(name, start, goal, others):
    """Within a region of 5 m, `others` being (name, radius, x, y)."""
    return step_relations(
        travellers=[Traveller(name, 1.25, "room", "room", (*start, 0.4), (*goal, 0.4))],
        static_agents=[StaticBody(other, r, (x, y, 0.4)) for other, r, x, y in others],
        regions=[ROOM],
        workspace_radius=30.0,
    )


def driven(step, way):
    """Least beta over straight lines from the start through way points."""
    corners, least = [step.start[0, :2], *map(np.array, way)], np.inf
    for a, b in pairwise(corners):
        for share in np.linspace(0.0, 1.0, 100):
            p = step.at(np.array([[*(a + share * (b - a)), 0.4]]))
            least = min(least, step.relations.betas(p).min())
    return least


CRATE = ("crate", 0.5, -2.3, 1.5)
FIRST, SECOND = (1.1, 3.1), (-1.45, 3.1)
"""Where they stand: the second in a corner between the crate, the border and the first, whose goal is that corner."""


def test_who_bars_the_corner_lets_out_who_stands_in_it():
    to_corner = alone("a1", FIRST, SECOND, [("a2", 1.25, *SECOND), CRATE])
    way_out = alone("a2", SECOND, (-2.3, -1.5), [("a1", 1.25, *FIRST), CRATE])
    assert to_corner.relations.violated(to_corner.goal)
    assert detour(way_out) is None
    assert evasion(way_out, to_corner) is None  # a2 cannot get out of a1's way
    way = evasion(to_corner, way_out)
    assert way
    assert driven(to_corner, way) > 0.0
    freed = alone("a2", SECOND, (-2.3, -1.5), [("a1", 1.25, *way[-1]), CRATE])
    out = detour(freed)
    assert out is not None
    assert driven(freed, [*out, (-2.3, -1.5)]) > 0.0
    home = alone("a1", way[-1], SECOND, [("a2", 1.25, -2.3, -1.5), CRATE])
    back = detour(home)
    assert back is not None
    assert driven(home, [*back, SECOND]) > 0.0


def test_nobody_makes_way_where_something_else_bars_it():
    ring = [(f"s{i}", 0.8, 2.2 * np.cos(a), 2.2 * np.sin(a)) for i, a in enumerate(np.arange(0.0, 6.2, 0.6))]
    inside = alone("a1", (0.0, 0.0), (3.6, 0.0), [("a2", 1.25, 3.7, 0.0), *ring])
    assert evasion(alone("a2", (3.7, 0.0), (-3.7, 0.0), [("a1", 1.25, 0.0, 0.0), *ring]), inside) is None
