"""The quickest mission that moves, and a step of case ii with a grasp in it."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from drake_ltl.diagrams import MakeMissionDiagram

from drake_ltl.execution.runner import Run, RunMission
from drake_ltl.mission import measure, plan_and_place
from drake_ltl.scenario import loads


@pytest.fixture(scope="session")
def shuttle(shuttle_text):
    """(mission, scenario, models) of one agent between two regions."""
    scenario = loads(shuttle_text)
    models = measure(scenario)
    return plan_and_place(scenario, models), scenario, models


@pytest.fixture(scope="session")
def run_shuttle(shuttle) -> Callable[..., Run]:
    """run_shuttle(num_steps, scenario=..., meshcat=..., **options of RunMission)"""
    mission, scenario, models = shuttle

    def run(num_steps: int, scenario=scenario, meshcat=None, **options) -> Run:
        diagram = MakeMissionDiagram(mission, scenario, models, num_steps=num_steps, meshcat=meshcat)
        return RunMission(diagram, num_steps=num_steps, **options)

    return run


@pytest.fixture(scope="session")
def short_run(run_shuttle) -> Run:
    """There and back."""
    return run_shuttle(2)
