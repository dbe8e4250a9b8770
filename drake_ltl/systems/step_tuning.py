"""Tunes kappa for the steps of a placed mission: the tuner of `drake_ltl.navigation.tuning`, told who moves where."""

from __future__ import annotations

from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.navigation import StepRelations
from drake_ltl.navigation.tuning import Tuning, tune_kappa
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.legs import Moving
from drake_ltl.systems.preflight import snapshot
from drake_ltl.systems.program import MissionProgram
from drake_ltl.systems.step_field import FieldBuilder


def relations_of_step(
    program: MissionProgram, number: int, scenario: Scenario, models: MeasuredModels
) -> StepRelations | None:
    """Relations of the step as the mission is placed; `number` counts from 0. None if nobody travels or carries."""
    step, placed = program.steps[number], program.mission.steps[number]
    if not (step.travels or step.transports):
        return None
    moving = Moving(step.travels, step.transports)
    return FieldBuilder(scenario, models).relations(moving, snapshot(placed.before, models), {})


def tune_steps(
    program: MissionProgram, scenario: Scenario, models: MeasuredModels, *, n_starts: int = 20, seed: int = 0
) -> dict[int, Tuning]:
    """For each step in which something moves, its number from 0 and what was found (see `tune_kappa`)."""
    settings = scenario.controller
    tunings = {}
    for number in range(len(program.steps)):
        relations = relations_of_step(program, number, scenario, models)
        if relations is not None:
            tunings[number] = tune_kappa(
                relations, n_starts=n_starts, seed=seed, lambda_=settings.lambda_, h=settings.h
            )
    return tunings
