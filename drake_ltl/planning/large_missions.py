"""Missions of teams too large to enumerate: the bounded method's plans, placed one after another."""

from __future__ import annotations

from dataclasses import replace

from drake_ltl.errors import InfeasibleError, NoPlacesError, PlacementError
from drake_ltl.planning.fits import Fits
from drake_ltl.planning.geometry import Geometry
from drake_ltl.planning.initial import initial_state
from drake_ltl.planning.mission import Mission
from drake_ltl.planning.placement import place
from drake_ltl.planning.plan import Plan, State
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.starts import Starts

PLAN_TIME = 30.0
"""For each plan [s]; one that is proven least sooner takes less."""
MOST_PLANS = 10
"""That are tried to be placed."""


def plan_large_mission(scenario: Scenario, geometry: Geometry, starts: Starts, fits: Fits) -> Mission:
    """A mission whose bodies can be placed, of small cost.

    Where a plan cannot be placed, the transition at which that shows is excluded, and planning starts again. A plan
    other than the first counts as feasible, with the lower bound of the first.

    Raises:
        InfeasibleError: it is proven that no plan satisfies the formula.
        NoPlacesError: none of those tried can be placed.
        SearchLimitError: no plan was found in time.
    """
    from drake_ltl.planning.bounded import plan_bounded  # loading the solver takes longer than most plans

    start = initial_state(scenario, starts)
    forbidden: frozenset[tuple[State, State]] = frozenset()
    least: Plan | None = None
    failure = ""
    for _ in range(MOST_PLANS):
        try:
            found = plan_bounded(scenario, start, fits, forbidden=forbidden, time_limit=PLAN_TIME)
        except InfeasibleError:
            if not forbidden:
                raise
            break
        if least is None:
            least = found
        else:
            found = replace(found, status="feasible", lower_bound=least.lower_bound)
        try:
            return place(found, scenario, geometry, starts)
        except PlacementError as error:
            failure, run = str(error), (*found.states, found.suffix[0])
            forbidden |= {(run[error.step], run[error.step + 1])}
    raise NoPlacesError(
        f"no places for the bodies were found in any of the {len(forbidden)} plans tried; the last fails at {failure}"
    )
