"""Plan, place, and where no places are found plan around it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drake_ltl.errors import InfeasibleError, NoPlacesError, PlacementError, SearchLimitError
from drake_ltl.planning.fits import Fits
from drake_ltl.planning.geometric_fits import GeometricFits
from drake_ltl.planning.geometry import Geometry
from drake_ltl.planning.initial import initial_state
from drake_ltl.planning.large_missions import plan_large_mission
from drake_ltl.planning.mission import Mission
from drake_ltl.planning.placement import place
from drake_ltl.planning.plan import Plan, State
from drake_ltl.planning.planner import plan
from drake_ltl.planning.power import sum_rule
from drake_ltl.planning.transition_system import TransitionSystem, form
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.starts import Starts


def plan_mission(
    scenario: Scenario,
    geometry: Geometry,
    starts: Starts,
    *,
    fits: Fits | None = None,
    max_attempts: int = 60,
    seen: Sequence[State] = (),
    possible: Callable[[TransitionSystem], NDArray[np.bool_]] | None = None,
) -> Mission:
    """A mission of small cost among the plans whose bodies can be placed.

    The plan of least cost is placed. If that fails at some transition, all transitions are excluded in which the
    bodies concerned do the same in the region concerned, whatever else goes on, and planning starts again. That
    may be more than what is impossible, for much depends on how things got where they are. So if no plan is left,
    fewer transitions are excluded: those in which all in the region do the same; at last those that have failed.

    Args:
        scenario: the problem.
        geometry: radii and offsets of its models.
        starts: where all members are at the beginning.
        fits: P_{s,0}; None takes the geometric predicate.
        max_attempts: number of plans to place.
        seen: states that were passed before those starts, from the initial one (`planner.plan`).
        possible: which transitions (E,) of TS are still possible; None means all.

    Returns:
        A placed mission. If its plan is not the first one, it counts as feasible, with the cost of the first as
        its lower bound.

    Raises:
        InfeasibleError: no plan satisfies the formula.
        NoPlacesError: none of those tried can be placed; says how many were tried, and for the cheapest and the last
            at which step which bodies found no places.
        SearchLimitError: the problem is too large to enumerate, and the bounded method found no plan in time.
    """
    fits = fits or GeometricFits(scenario, geometry)
    try:
        start, system = initial_state(scenario, starts), form(scenario, fits, sum_rule(scenario))
    except SearchLimitError:
        if seen or possible:  # the bounded method begins all missions anew, with all that everybody can
            raise
        return plan_large_mission(scenario, geometry, starts, fits)
    if possible is not None:
        system = system.keep(possible(system))
    widths = list(np.zeros((3, system.n_transitions), dtype=bool))
    failures: list[str] = []
    least: Plan | None = None
    while len(failures) < max_attempts:
        try:
            found = plan(scenario, start, fits, system=system.keep(~widths[0]) if failures else system, seen=seen)
        except InfeasibleError as error:
            if not failures:
                raise
            if len(widths) > 1:
                del widths[0]
                continue
            raise _refusal(failures) from error
        least = least or found
        try:
            return place(_bounded(found, least), scenario, geometry, starts)
        except PlacementError as error:
            failures.append(str(error))
            for width, more in zip(reversed(widths), _alike(system, found, error), strict=False):
                width |= more
    raise _refusal(failures)


def _alike(system: TransitionSystem, found: Plan, error: PlacementError) -> list[NDArray[np.bool_]]:
    """Transitions (E,) like the one that failed: itself, all in which its region does the same, and all in which
    the bodies concerned do the same there."""
    scenario, run = system.scenario, (*found.states, found.suffix[0])
    ends = system.index(run[error.step]), system.index(run[error.step + 1])
    everybody = (*scenario.agent_names, *scenario.object_names)
    there = (error.region,) if error.region else scenario.region_names
    return [
        _same(system, ends, regions, bodies)
        for regions, bodies in (
            (scenario.region_names, everybody),
            (there, everybody),
            (there, error.bodies or everybody),
        )
    ]


def _same(
    system: TransitionSystem, ends: tuple[int, int], regions: Sequence[str], bodies: Sequence[str]
) -> NDArray[np.bool_]:
    """Transitions (E,) that are the same for some bodies as far as they are in some regions."""
    scenario = system.scenario
    numbers = [scenario.region_names.index(name) for name in regions]
    agents = [name in bodies for name in scenario.agent_names]
    objects = [name in bodies for name in scenario.object_names]
    where = np.hstack([system.agent_regions[:, agents], system.places[:, objects]])
    what = np.hstack([system.options[:, agents], system.places[:, objects]])
    local = np.where(np.isin(where, numbers), what, -1)
    from_same, to_same = ((local == local[end]).all(axis=1) for end in ends)
    return from_same[system.sources] & to_same[system.targets]


def _bounded(found: Plan, least: Plan) -> Plan:
    """What may be claimed of a plan found after others were given up."""
    if found is least:
        return found
    return replace(found, status="feasible", lower_bound=least.lower_bound)


def _refusal(failures: list[str]) -> NoPlacesError:
    """It is not a formula that stands against these plans: the bodies do not fit as they would have to."""
    count = "the only plan tried" if len(failures) == 1 else f"any of the {len(failures)} plans tried"
    first, last = failures[0], failures[-1]
    text = f"no places for the bodies were found in {count}; the cheapest fails at {first}"
    return NoPlacesError(text if first == last else f"{text}; the last fails at {last}")
