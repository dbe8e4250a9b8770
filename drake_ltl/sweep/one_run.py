"""One run of a sweep: drawn, planned, simulated and judged."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pydrake.systems.framework import Context

from drake_ltl import mission
from drake_ltl.diagrams import MissionDiagram
from drake_ltl.errors import InfeasibleError, SearchLimitError
from drake_ltl.execution.runner import Run, RunProgress
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.scenario.model import Scenario
from drake_ltl.sweep.drawing import Drawn, draw, drawn_scenario
from drake_ltl.sweep.outcome import FAILED, NO_PLAN, Outcome, judged
from drake_ltl.sweep.sweep import Sweep
from drake_ltl.verification import verify
from drake_ltl.verification.verdict import Verdict


@dataclass(frozen=True)
class CarriedOut:
    """A run with all that it left; `run` and `verdict` are None if nothing was simulated."""

    scenario: Scenario
    outcome: Outcome
    run: Run | None = None
    verdict: Verdict | None = None


def run_one(sweep: Sweep, number: int) -> Outcome:
    """What workers do. Whatever goes wrong is an outcome, too."""
    try:
        return carry_out(sweep, number).outcome
    except (Exception, SystemExit) as error:  # Drake's failed conditions end a process with a text
        return Outcome(number, FAILED, reason=in_one_line(error))


def carry_out(
    sweep: Sweep,
    number: int,
    report: Callable[[RunProgress], None] | None = None,
    models: MeasuredModels | None = None,
) -> CarriedOut:
    """Run `number`, with its recording.

    Args:
        report: told of the simulation's progress once per simulated second.
        models: the scenario's, if they are at hand: nothing of what is drawn changes them. None: measured.

    Raises:
        DrakeLtlError: what `drake_ltl.mission` raises, unless there is no plan.
    """
    begin = time.perf_counter()
    drawn = draw(sweep, number)
    scenario = drawn_scenario(sweep.scenario, drawn)
    models = mission.measure(scenario) if models is None else models
    try:
        planned = mission.plan_and_place(scenario, models)
    except (InfeasibleError, SearchLimitError) as error:
        return CarriedOut(scenario, Outcome(number, NO_PLAN, reason=in_one_line(error), drawn=drawn))
    run = mission.simulate(
        planned,
        scenario,
        models,
        suffix_rounds=sweep.suffix_rounds,
        keep_going=True,  # how far a run gets, and what then becomes of it, counts too
        disturb=_heavier(drawn),
        announce=lambda line: None,  # outcomes say it
        report=report,
    )
    verdict = verify(run.recording, scenario)
    seconds = time.perf_counter() - begin
    return CarriedOut(scenario, judged(number, drawn, planned.plan.cost, run.recording, verdict, seconds), run, verdict)


def _heavier(drawn: Drawn) -> Callable[[MissionDiagram, Context], None]:
    return lambda diagram, context: scale_masses(diagram, context, drawn.masses)


def scale_masses(diagram: MissionDiagram, context: Context, factors: Mapping[str, float]) -> None:
    """Multiplies the mass and the rotational inertia of objects in the plant; controllers keep the models' values."""
    parts = diagram.transport_plant
    plant_context = parts.plant.GetMyMutableContextFromRoot(context)
    for name, factor in factors.items():
        for index in parts.plant.GetBodyIndices(parts.objects[name]):
            body = parts.plant.get_body(index)
            body.SetMass(plant_context, factor * body.get_mass(plant_context))


def in_one_line(error: BaseException) -> str:
    """The kind of an error and what it says."""
    return " ".join(f"{type(error).__name__}: {error}".split())
