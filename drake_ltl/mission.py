"""The whole chain in four calls: measure, plan_and_place, simulate, then `drake_ltl.verification.verify`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from drake_ltl.diagrams import MakeMissionDiagram
from drake_ltl.execution.runner import Run, RunMission, RunProgress
from drake_ltl.multibody import MeasuredModels, MeasureGeometry
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.mission import Mission
from drake_ltl.planning.mission_planner import plan_mission
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.starts import check_starts


def measure(scenario: Scenario) -> MeasuredModels:
    """Loads the scenario's models. Raises InvalidInputError if one cannot be used."""
    return MeasureGeometry(scenario)


def plan_and_place(scenario: Scenario, models: MeasuredModels) -> Mission:
    """The cheapest mission found whose bodies can be placed.

    Raises:
        InvalidInputError: a body starts outside every region, or touches another.
        InfeasibleError: nothing satisfies the specification, or nothing that does can be carried out.
    """
    starts = check_starts(scenario, models.geometry)
    fits = None if scenario.fits is None else published_fits(scenario.fits)
    return plan_mission(scenario, models.geometry, starts, fits=fits)


def num_steps(mission: Mission, suffix_rounds: int) -> int:
    """Steps up to the first state of the suffix, and that many rounds from there."""
    return len(mission.plan.prefix) + suffix_rounds * len(mission.plan.suffix)


def simulate(
    mission: Mission,
    scenario: Scenario,
    models: MeasuredModels,
    *,
    suffix_rounds: int = 1,
    report: Callable[[RunProgress], None] | None = None,
) -> Run:
    """Carries the mission out in Drake's Simulator."""
    steps = num_steps(mission, suffix_rounds)
    diagram = MakeMissionDiagram(mission, scenario, models, num_steps=steps)
    return RunMission(diagram, num_steps=steps, report=report)
