"""Missions of the bounded method."""

from __future__ import annotations

import pytest

from drake_ltl.errors import InfeasibleError, NoPlacesError, PlacementError, SearchLimitError
from drake_ltl.planning import large_missions, mission_planner
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.large_missions import plan_large_mission
from drake_ltl.scenario import load
from drake_ltl.scenario.starts import check_starts


@pytest.fixture(scope="module")
def problem(examples):
    """Case ii with what is measured of its models."""
    from drake_ltl.multibody import MeasureGeometry

    scenario = load(examples / "case_ii.yaml")
    geometry = MeasureGeometry(scenario).geometry
    return scenario, geometry, check_starts(scenario, geometry)


@pytest.fixture(scope="module")
def mission(problem):
    """Planned by enumeration."""
    scenario, geometry, starts = problem
    return mission_planner.plan_mission(scenario, geometry, starts, fits=published_fits(scenario.fits))


def test_what_cannot_be_enumerated_is_planned_by_the_bounded_method(problem, mission, monkeypatch):
    """Case ii is small enough for both ways: they cost the same."""
    scenario, geometry, starts = problem

    def refuse(*arguments):
        raise SearchLimitError("too large")

    monkeypatch.setattr(mission_planner, "form", refuse)
    monkeypatch.setattr(large_missions, "PLAN_TIME", 10.0)
    fits = published_fits(scenario.fits)
    found = mission_planner.plan_mission(scenario, geometry, starts, fits=fits)
    assert found.plan.cost == pytest.approx(mission.plan.cost, rel=1e-9)


def test_what_cannot_be_placed_is_planned_around(problem, mission, monkeypatch):
    """The first plan is refused at its third move; the second must not use it."""
    scenario, geometry, starts = problem
    asked = []

    def plan_bounded(scenario, start, fits, *, forbidden, time_limit):
        asked.append(forbidden)
        return mission.plan

    def place(plan, *arguments):
        if len(asked) == 1:
            raise PlacementError("no room", step=2)
        return plan

    monkeypatch.setattr("drake_ltl.planning.bounded.plan_bounded", plan_bounded)
    monkeypatch.setattr(large_missions, "place", place)
    found = plan_large_mission(scenario, geometry, starts, published_fits(scenario.fits))
    run = mission.plan.states
    assert asked == [frozenset(), frozenset({(run[2], run[3])})]
    assert found.status == "feasible"
    assert found.lower_bound == mission.plan.lower_bound


@pytest.mark.parametrize("plans", [0, 3])
def test_where_no_plan_is_left(problem, mission, monkeypatch, plans):
    """That nothing satisfies the formula may be said only if nothing was excluded before."""
    scenario, geometry, starts = problem
    counter = iter(range(100))

    def plan_bounded(*arguments, **options):
        if next(counter) >= plans:
            raise InfeasibleError("no lasso")
        return mission.plan

    def place(plan, *arguments):
        raise PlacementError("no room", step=0)

    monkeypatch.setattr("drake_ltl.planning.bounded.plan_bounded", plan_bounded)
    monkeypatch.setattr(large_missions, "place", place)
    with pytest.raises(InfeasibleError) as caught:
        plan_large_mission(scenario, geometry, starts, published_fits(scenario.fits))
    assert isinstance(caught.value, NoPlacesError) == (plans > 0)
