"""Plan, place, and where no places are found plan around it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drake_ltl.errors import InfeasibleError, PlacementError
from drake_ltl.planning.fits import Fits
from drake_ltl.planning.geometric_fits import GeometricFits
from drake_ltl.planning.geometry import Geometry
from drake_ltl.planning.initial import initial_state
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
) -> Mission:
    """A mission of small cost among the plans whose bodies can be placed.

    The plan of least cost is placed. If that fails at some transition, all transitions are excluded that do the
    same in the region concerned, whatever goes on elsewhere, and planning starts again. What can be placed may
    depend on how things got where they are, so if nothing is left, planning starts once more with only those
    transitions excluded that have failed themselves.

    Args:
        scenario: the problem.
        geometry: radii and offsets of its models.
        starts: where all members are at the beginning.
        fits: P_{s,0}; None takes the geometric predicate.
        max_attempts: number of plans to place.

    Returns:
        A placed mission. If its plan is not the first one, it counts as feasible, with the cost of the first as
        its lower bound.

    Raises:
        InfeasibleError: no plan satisfies the formula, or none of those tried can be placed; says what could not
            be placed, and why.
    """
    fits = fits or GeometricFits(scenario, geometry)
    start, system = initial_state(scenario, starts), form(scenario, fits, sum_rule(scenario))
    alike, itself = np.zeros((2, system.n_transitions), dtype=bool)
    failures: list[str] = []
    excluded, least = alike, None
    while len(failures) < max_attempts:
        try:
            found = plan(scenario, start, fits, system=system.keep(~excluded) if failures else system)
        except InfeasibleError as error:
            if excluded is alike and not np.array_equal(alike, itself):
                excluded = itself
                continue
            raise InfeasibleError(_because(str(error), failures)) from error
        least = least or found
        try:
            return place(_bounded(found, least), scenario, geometry, starts)
        except PlacementError as error:
            failures.append(str(error))
            before, after = _transition(found, error.step)
            itself |= _like(system, before, after, scenario.region_names)
            alike |= _like(system, before, after, (error.region,) if error.region else scenario.region_names)
    raise InfeasibleError(_because(f"none of {max_attempts} plans can be carried out", failures))


def _transition(found: Plan, step: int) -> tuple[State, State]:
    run = (*found.states, found.suffix[0])
    return run[step], run[step + 1]


def _like(system: TransitionSystem, before: State, after: State, regions: tuple[str, ...]) -> NDArray[np.bool_]:
    """Transitions (E,) in which the same bodies do the same in the regions."""
    numbers = [system.scenario.region_names.index(name) for name in regions]
    agents, objects = system.agent_regions, system.places
    local = np.hstack(
        [
            np.where(np.isin(agents, numbers), system.options, -1),
            np.where(np.isin(objects, numbers), objects, -1),
        ]
    )
    from_alike = (local == local[system.index(before)]).all(axis=1)
    to_alike = (local == local[system.index(after)]).all(axis=1)
    return from_alike[system.sources] & to_alike[system.targets]


def _bounded(found: Plan, least: Plan) -> Plan:
    """What may be claimed of a plan found after others were given up."""
    if found is least:
        return found
    return replace(found, status="feasible", lower_bound=least.lower_bound)


def _because(text: str, failures: list[str]) -> str:
    different = list(dict.fromkeys(failures))
    return "; ".join([text, *(f"could not be placed: {failure}" for failure in different[-5:])])
