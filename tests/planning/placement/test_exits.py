"""Rings of bodies that shut a mover in, against a flood of the plane; and plans in which somebody cannot get out."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.ndimage import label

from drake_ltl.errors import PlacementError
from drake_ltl.planning.exits import way_out
from drake_ltl.planning.placement import place
from drake_ltl.planning.plan import State
from drake_ltl.scenario.starts import check_starts

CENTRES = {"home": (0.0, 0.0, 0.0), "away": (30.0, 0.0, 0.0)}
GRID = 0.05
"""Of the flood [m]."""


def floods_out(discs) -> bool:
    """Whether the origin is connected to far away, outside of all discs (x, y, radius)."""
    ticks = np.arange(-9.0, 9.0 + GRID / 2, GRID)
    x, y = np.meshgrid(ticks, ticks, indexing="ij")
    free = np.ones(x.shape, dtype=bool)
    for a, b, r in discs:
        free &= np.hypot(x - a, y - b) > r
    parts, _ = label(free, structure=np.ones((3, 3)))
    middle = len(ticks) // 2
    return parts[middle, middle] == parts[0, 0]


disc = st.tuples(st.floats(0.0, 2.0 * math.pi), st.floats(1.2, 5.0), st.floats(0.7, 3.0))


@settings(max_examples=60, deadline=None)
@given(st.lists(disc, min_size=3, max_size=7))
def test_rings_shut_in_what_a_flood_does_not_leave(polar):
    discs = [(d * math.cos(a), d * math.sin(a), r) for a, d, r in polar]
    assume(all(d > r + 2 * GRID for _, d, r in polar))
    slack = float(way_out(np.zeros(2), [np.array(d[:2]) for d in discs], [np.array(d[2]) for d in discs]))
    assume(abs(slack) > 3 * GRID)
    assert (slack > 0.0) == floods_out(discs)


def test_many_places_at_once_are_judged_as_each_alone():
    rng = np.random.default_rng(0)
    p = rng.uniform(-0.5, 0.5, (20, 2))
    corners = [np.array([3.0 * math.cos(a), 3.0 * math.sin(a)]) for a in (0.1, 1.7, 3.2, 4.9)]
    radii = [np.full(20, 2.2), np.array(2.3), np.array(2.3), np.linspace(1.6, 2.4, 20)]
    found = way_out(p, corners, radii)
    each = [way_out(p[k], corners, [np.broadcast_to(r, 20)[k] for r in radii]) for k in range(20)]
    np.testing.assert_allclose(found, each, atol=1e-12)
    assert (found < 0.0).any()
    assert (found > 0.0).any()


def leaves(tools, distance, angles):
    """a1 leaves home, and the others stand around it so far off [m]."""
    spots = {"a1": (0.0, 0.0)} | {
        f"a{k + 2}": (distance * math.cos(a), distance * math.sin(a)) for k, a in enumerate(angles)
    }
    headings = [2.0 * math.pi * k / 3.0 for k in range(len(spots))]
    agents = {
        name: (x - 0.784 * math.cos(h), y - 0.784 * math.sin(h))
        for (name, (x, y)), h in zip(spots.items(), headings, strict=True)
    }
    scenario = tools.scenario(agents=agents, objects={}, centres=CENTRES, radius=7.0, workspace=60.0)
    geometry = tools.geometry(scenario)
    rest = ("home",) * len(angles)
    idle = (None,) * len(agents)
    plan = tools.plan(scenario, [State(("home", *rest), (), idle), State(("away", *rest), (), idle)], 1)
    return place(plan, scenario, geometry, check_starts(scenario, geometry))


FOUR = [0.0, 0.5 * math.pi, math.pi, 1.5 * math.pi]


def test_who_is_shut_in_cannot_leave(tools):
    """Four at 3.4 m leave gaps of 4.81 m, and a1 between two others takes 5 m."""
    with pytest.raises(PlacementError, match="a1 could not get out of home") as caught:
        leaves(tools, 3.4, FOUR)
    assert (caught.value.step, caught.value.region) == (0, "home")


def test_a_gap_that_is_wide_enough_is_a_way_out(tools):
    leaves(tools, 3.6, FOUR)
    leaves(tools, 3.4, FOUR[:3])
