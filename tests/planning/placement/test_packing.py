"""Packing against known optima, and the packings that come with a yes against distances alone."""

from __future__ import annotations

import itertools
import math

import pytest

from drake_ltl.planning.fits import Content
from drake_ltl.planning.geometric_fits import GeometricFits
from drake_ltl.planning.packing import Group, Packed, Sphere, pack
from drake_ltl.planning.spheres import LEAST_MARGIN, REGION_MARGIN

OPTIMA = {
    1: 1.0,
    2: 2.0,
    3: 1.0 + 2.0 / math.sqrt(3.0),
    4: 1.0 + math.sqrt(2.0),
    5: 1.0 + math.sqrt(2.0 * (1.0 + 1.0 / math.sqrt(5.0))),
    7: 3.0,
}
"""Radius of the smallest circle that holds n unit circles (Graham 1968)."""


def _equal(count: int, radius: float) -> list[Group]:
    return [Group(((Sphere((0.0, 0.0, 0.0), radius),),))] * count


def _region_radius(count: int, radius: float, factor: float) -> float:
    """Radius of a region `factor` times as large as needed, all margins included."""
    half = radius + LEAST_MARGIN / 2.0
    return factor * OPTIMA[count] * half - LEAST_MARGIN / 2.0 + REGION_MARGIN


@pytest.mark.parametrize("count", OPTIMA)
@pytest.mark.parametrize("seed", range(3))
def test_equal_circles_fit_two_percent_above_the_optimum_and_not_below(count, seed):
    packed = pack(_equal(count, 1.25), _region_radius(count, 1.25, 1.02), 0.0, seed=seed)
    assert packed is not None
    region = _region_radius(count, 1.25, 1.02)
    assert all(math.hypot(*p) + 1.25 + REGION_MARGIN <= region + 1e-9 for p in packed.origins)
    gaps = [math.dist(p, q) - 2.5 for p, q in itertools.combinations(packed.origins, 2)]
    assert all(gap >= LEAST_MARGIN - 1e-9 for gap in gaps)
    assert pack(_equal(count, 1.25), _region_radius(count, 1.25, 0.995), 0.0, seed=seed) is None


def test_heights_make_room():
    """Two spheres at different heights may overlap in plan: sqrt(2.05^2 - 1.5^2) = 1.397 m is enough here."""
    high = [Group(((Sphere((0.0, 0.0, z), 1.0),),)) for z in (0.0, 1.5)]
    flat = _equal(2, 1.0)
    assert pack(high, 2.2, 0.75) is not None
    assert pack(flat, 2.05, 0.0) is None


def test_an_alternative_that_fits_is_found():
    wide = tuple(Sphere((x, 0.0, 0.0), 0.5) for x in (-3.0, 3.0))
    narrow = tuple(Sphere((x, 0.0, 0.0), 0.5) for x in (-1.0, 1.0))
    packed = pack([Group((wide, narrow))], 2.0, 0.0)
    assert packed is not None
    assert packed.alternatives == (1,)


def test_nothing_fits_everywhere_and_what_cannot_be_held_nowhere():
    assert pack([], 1.0, 0.0) == Packed((), ())
    assert pack([Group(())], 10.0, 0.0) is None


@pytest.fixture
def fits(case_ii):
    return GeometricFits(case_ii.scenario, case_ii.geometry)


def _contents(scenario):
    for doing in itertools.product((None, "free", *scenario.object_names), repeat=len(scenario.agents)):
        for present in itertools.product((False, True), repeat=len(scenario.objects)):
            objects = tuple(o for o, here in zip(scenario.object_names, present, strict=True) if here)
            pairs = list(zip(scenario.agent_names, doing, strict=True))
            holds = tuple((a, what) for a, what in pairs if what in scenario.object_names)
            if all(obj in objects for _, obj in holds):
                free = tuple(a for a, what in pairs if what == "free")
                for carried in [frozenset(), *({obj} for _, obj in holds)]:
                    yield Content(free, objects, holds, frozenset(carried))


def test_every_yes_comes_with_a_packing_that_keeps_all_distances(case_ii, fits):
    geometry, region = case_ii.geometry, case_ii.scenario.region("pi2")
    answers = []
    for content in _contents(case_ii.scenario):
        packing = fits.packing(region, content)
        answers.append(packing is not None)
        assert fits(region, content) == answers[-1]
        if packing is None:
            continue
        held = dict(content.holds)
        assert set(packing.agents) == {*content.free_agents, *held}
        assert set(packing.objects) == set(content.objects)
        balls = [({a}, held.get(a), p, geometry.agent_radius[a]) for a, p in packing.agents.items()]
        balls += [({o}, None, p, geometry.object_radius[o]) for o, p in packing.objects.items()]
        for obj in content.carried:
            team = {obj, *(a for a, o in held.items() if o == obj)}
            balls.append((team, obj, packing.objects[obj], geometry.team_radius[obj]))
        for a, p in packing.agents.items():
            if a in held:
                option = next(o for o in geometry.grasps[a, held[a]] if o.name == packing.options[a])
                offset = [q - o for q, o in zip(p, packing.objects[held[a]], strict=True)]
                assert math.dist(offset, option.p_OoC_grasp) < 1e-9
        for a, at, p, r in balls:
            assert math.dist(p, region.centre) + r + REGION_MARGIN <= region.radius + 1e-9, (content, a)
            for b, bt, q, s in balls:
                if not (a & b) and at not in b and bt not in a:
                    assert math.dist(p, q) >= r + s + LEAST_MARGIN - 1e-9, (content, a, b)
    assert any(answers)
    assert not all(answers)


@pytest.mark.parametrize(
    ("content", "fit"),
    [
        (Content(("a1", "a2", "a3"), ("o1", "o2")), True),
        (Content((), ("o1",), (("a1", "o1"), ("a2", "o1"), ("a3", "o1"))), True),
        (Content((), ("o1",), (("a1", "o1"), ("a2", "o1"), ("a3", "o1")), frozenset({"o1"})), True),
        (Content(("a3",), ("o1",), (("a1", "o1"), ("a2", "o1"))), True),
        # a team's sphere of 2.6 m leaves no room for an agent's of 1.25 m in a region of 3.5 m
        (Content(("a3",), ("o1",), (("a1", "o1"), ("a2", "o1")), frozenset({"o1"})), False),
    ],
)
def test_contents_of_the_paper(case_ii, fits, content, fit):
    assert fits(case_ii.scenario.region("pi1"), content) is fit


def test_answers_do_not_depend_on_what_was_asked_before(case_ii, fits):
    region = case_ii.scenario.region("pi1")
    contents = list(_contents(case_ii.scenario))
    first = [fits.packing(region, content) for content in contents]
    again = GeometricFits(case_ii.scenario, case_ii.geometry)
    assert first == [again.packing(region, content) for content in reversed(contents)][::-1]
