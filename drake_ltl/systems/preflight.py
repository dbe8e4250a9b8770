"""What can be refused before a mission is run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.planning.mission import Layout
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.legs import Moving
from drake_ltl.systems.longest_time_step import longest_time_step, nearest, reaches_at_begin
from drake_ltl.systems.program import MissionProgram, start_configuration
from drake_ltl.systems.step_field import FieldBuilder, Snapshot, StepField


def check_fields(program: MissionProgram, scenario: Scenario, models: MeasuredModels) -> None:
    """Builds the navigation function of every step once, as the mission is placed.

    Raises:
        InvalidInputError: the controller's settings do not allow one (lambda > 0 with too many relations), a goal
            touches something, or the time step is too long for how close movers start to others or to borders.
    """
    builder, mistakes = FieldBuilder(scenario, models), []
    for number, (step, placed) in enumerate(zip(program.steps, program.mission.steps, strict=True), start=1):
        if step.travels or step.transports:
            here = snapshot(placed.before, models)
            field = builder.field(Moving(step.travels, step.transports), here, reaches_at_begin(step, here))
            mistakes += _too_long(number, field, here, scenario, models)
    if mistakes:
        raise InvalidInputError(mistakes)


def _too_long(
    number: int, field: StepField, here: Snapshot, scenario: Scenario, models: MeasuredModels
) -> Iterator[Mistake]:
    time_step, longest = scenario.simulation.time_step, longest_time_step(field, here, scenario.controller, models)
    if time_step > longest:
        gap, what = nearest(field.relations)
        short = 10.0 ** np.floor(np.log10(longest))
        yield Mistake(
            "simulation.time_step",
            f"{time_step:g} s is too long for the start of step {number}: {what} are {1e3 * gap:.3g} mm apart, and "
            "torques held for so long may raise V",
            f"use at most {np.floor(longest / short) * short:g} s, or let them start farther apart",
        )


def snapshot(layout: Layout, models: MeasuredModels) -> Snapshot:
    """The layout in joint coordinates."""
    p_WO = {name: np.asarray(p, dtype=float) for name, p in layout.objects.items()}
    q = {}
    for name, stand in layout.agents.items():
        if stand.grasp is None:
            q[name] = start_configuration(stand, name, models)
            continue
        obj, option = stand.grasp
        q[name] = models.grasping(name, obj, option, layout.headings[obj]).copy()
        q[name][:NUM_BASE_JOINTS] += p_WO[obj][:2]
    return Snapshot(q, p_WO)
