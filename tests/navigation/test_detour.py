"""Ways around static spheres for one mover."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from drake_ltl.navigation import RegionBall, StaticBody, Transport, Traveller, step_relations
from drake_ltl.navigation.detour import detour, run_up

REGIONS = [RegionBall("p1", (-10.0, 0.0, 0.0), 3.5), RegionBall("p2", (10.0, 0.0, 0.0), 3.5)]


def relations(start, goal, statics=(), regions=REGIONS, within=False):
    traveller = Traveller("a1", 1.25, "p1", "p1" if within else "p2", (*start, 0.4), (*goal, 0.4))
    return step_relations(
        travellers=[traveller],
        static_agents=[StaticBody(f"s{i}", r, (x, y, 0.4)) for i, (x, y, r) in enumerate(statics)],
        regions=regions,
        workspace_radius=30.0,
    )


def least_beta(step, way):
    """Over the straight lines from the start by way of the points to the goal."""
    corners = [step.start[0, :2], *map(np.array, way), step.goal[0, :2]]
    least = np.inf
    for a, b in pairwise(corners):
        for share in np.linspace(0.0, 1.0, 200):
            p = step.at(np.array([[*(a + share * (b - a)), 0.4]]))
            least = min(least, step.relations.betas(p).min())
    return least


def test_straight_where_nothing_is_in_the_way():
    assert detour(relations((-10, 0), (10, 0))) == []


@pytest.mark.parametrize("y", [0.0, 0.3, -1.0])
def test_goes_around_what_is_in_the_way(y):
    step = relations((-10, 0), (10, 0), [(0.0, y, 1.25), (0.0, y + 2.7, 1.25)])
    way = detour(step)
    assert way
    assert least_beta(step, way) > 0.0


def test_goes_around_regions_it_must_avoid():
    step = relations((-10, 0), (10, 0), regions=[*REGIONS, RegionBall("p3", (0.0, 0.0, 0.0), 3.5)])
    way = detour(step)
    assert way
    assert least_beta(step, way) > 0.0


def test_stays_within_the_region():
    step = relations((-11.8, 0.6), (-8.2, 0.6), [(-10.0, 1.2, 0.1)], within=True)
    way = detour(step)
    assert way
    assert least_beta(step, way) > 0.0


def test_an_arm_that_stands_high_can_come_down_at_each_way_point():
    """Stuck with its sphere up at 1.4 m it passes above what its sphere would touch at its goal's height."""
    places = [(-3.0, y, 0.3) for y in np.arange(-1.4, 12.0, 0.4)]
    step = step_relations(
        travellers=[Traveller("a1", 1.25, "p1", "p2", (-7.5, 0.2, 1.4), (8.0, 0.0, 0.4))],
        static_agents=[StaticBody(f"s{i}", r, (x, y, 0.1)) for i, (x, y, r) in enumerate(places)],
        regions=REGIONS,
        workspace_radius=30.0,
    )
    way = detour(step)
    assert way
    for x, y in way:
        assert not step.relations.violated(step.at(np.array([[x, y, 0.4]])))


@pytest.mark.parametrize("shift", [0.0, 0.05, 0.1, 0.15])
def test_a_gap_that_hardly_lets_a_mover_through_is_found(shift):
    """Wherever it lies on the lattice: a wall of spheres across a region leaves 12 cm more than the mover is wide."""
    wall = [(-10.0, shift + side * (1.31 + 1.0 + 1.5 * k), 1.0) for side in (1, -1) for k in range(3)]
    step = relations((-12.0, 0.0), (-8.0, 0.0), wall, [RegionBall("p1", (-10.0, 0.0, 0.0), 5.0)], within=True)
    way = detour(step)
    assert way is not None
    assert least_beta(step, way) > 0.0


def test_none_where_there_is_no_way():
    ring = [(-10 + 5 * np.cos(a), 5 * np.sin(a), 1.0) for a in np.linspace(0, 2 * np.pi, 12, endpoint=False)]
    assert detour(relations((-10, 0), (10, 0), ring)) is None


def test_refuses_several_movers():
    team = Transport("o1", ("a2",), 2.6, "p2", "p1", (10.0, 0.0, 0.25), (-10.0, 0.0, 0.25))
    step = step_relations(
        travellers=[Traveller("a1", 1.25, "p1", "p2", (-10.0, 0.0, 0.4), (10.0, 0.0, 0.4))],
        transports=[team],
        regions=REGIONS,
        workspace_radius=30.0,
    )
    with pytest.raises(ValueError, match="one mover"):
        detour(step)


def test_run_up_to_a_goal_beside_somebody():
    """The start is squeezed between the goal and whom it must keep clear of; the run-up begins away from both."""
    step = relations((-7.5, 0.5), (-7.4, 0.0), [(-10.0, 0.0, 1.25)], within=False)
    ((x, y),) = run_up(step)
    assert np.hypot(x + 10.0, y) > 2.5 + 0.3
    assert 0.3 < np.hypot(x + 7.4, y) < 1.5
    assert least_beta(step, [(x, y)]) > 0.0


def test_no_run_up_where_there_is_no_room():
    """Within a region that just holds it there is none; it goes on straight."""
    ring = [(-10.0 + 2.6 * np.cos(angle), 2.6 * np.sin(angle), 1.25) for angle in np.linspace(0.0, 2.0 * np.pi, 9)]
    assert run_up(relations((-10.05, 0.0), (-10.0, 0.0), ring, within=True)) == []
