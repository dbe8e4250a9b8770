"""Time steps that may raise V where movers start: against what one step of the discrete motion does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from drake_ltl.errors import InvalidInputError
from drake_ltl.mission import measure, plan_and_place
from drake_ltl.scenario import loads
from drake_ltl.systems.legs import Moving
from drake_ltl.systems.longest_time_step import NEAR, longest_time_step, nearest, reaches_at_begin
from drake_ltl.systems.preflight import check_fields, snapshot
from drake_ltl.systems.program import mission_program
from drake_ltl.systems.step_field import FieldBuilder

TEXT = """
name: border
workspace: {radius: 20.0}
regions:
  home: {centre: [0, 0, 0], radius: 4.0}
  away: {centre: [10, 0, 0], radius: 4.0}
agents:
  a1: {model: package://drake_ltl_models/agents/planar_arm.urdf, position: [0.0, 2.5982], joints: [0.0, 0.0], power: 1}
objects:
  o1: {model: package://drake_ltl_models/objects/crate.sdf, position: [0.0, 0.2], power_needed: 1, spec: F away}
"""
"""a1 stands 3 mm inside home, in which it must stay while it drives to where it grasps from."""


@pytest.fixture(scope="module")
def scenario():
    return loads(TEXT)


@pytest.fixture(scope="module")
def border(scenario):
    """Models and program."""
    models = measure(scenario)
    return models, mission_program(plan_and_place(scenario, models), models, scenario)


def begin(scenario, models, program):
    """What the first step begins with."""
    here = snapshot(program.mission.steps[0].before, models)
    step = program.steps[0]
    moving = Moving(step.travels, step.transports)
    return here, FieldBuilder(scenario, models).field(moving, here, reaches_at_begin(step, here))


def test_from_rest_v_can_rise_in_longer_steps_alone(scenario, border):
    """k Phi is differenced twice; a step from rest by the worst of all slopes, then by that of the field."""
    models, program = border
    here, field = begin(scenario, models, program)
    longest = longest_time_step(field, here, scenario.controller, models)
    assert 1e-4 < longest < 5e-3
    model, q_0, (task,) = models.agents["a1"], here.q["a1"], field.travels

    def potential(q: np.ndarray) -> float:
        p = field.relations.at(model.centre(q)[None])
        gamma = model.gamma(q, task.q_goal)
        return scenario.controller.force * field.function.shaping.value(np.log(gamma) - log_barrier(p))

    def log_barrier(p: np.ndarray) -> float:
        function = field.function
        return float(function.log_G(p) - function.log_G_goal) / function.kappa

    h = 1e-4
    e = h * np.eye(model.n)
    K = np.array(
        [
            [
                potential(q_0 + a + b) - potential(q_0 + a - b) - potential(q_0 - a + b) + potential(q_0 - a - b)
                for b in e
            ]
            for a in e
        ]
    ) / (4.0 * h * h)
    g = np.array([potential(q_0 + a) - potential(q_0 - a) for a in e]) / (2.0 * h)
    M = model.inertia(q_0)

    def rise(dt: float, g: np.ndarray) -> float:
        """Of V in the first step, to second order."""
        w = -dt * np.linalg.solve(M, g)
        return 0.5 * w @ M @ w + dt * g @ w + 0.5 * dt**2 * w @ K @ w

    frequencies, shapes = np.linalg.eig(np.linalg.solve(M, K))
    worst = M @ shapes[:, np.argmax(frequencies.real)].real
    assert rise(0.9 * longest, worst) < 0.0  # K by differences of 0.1 mm at 3 mm is good for some per cent
    assert rise(1.1 * longest, worst) > 0.0

    def raised(dt: float) -> float:
        w = -dt * np.linalg.solve(M, g)
        return 0.5 * w @ M @ w + potential(q_0 + dt * w) - potential(q_0)

    assert raised(0.9 * longest) < 0.0


def test_a_start_too_close_for_the_time_step_is_refused_with_what_would_do(scenario, border):
    models, program = border
    _, field = begin(scenario, models, program)
    gap, what = nearest(field.relations)
    assert what == "a1 and the border of home"
    assert gap == pytest.approx(0.003, abs=1e-3)
    coarse = replace(scenario, simulation=replace(scenario.simulation, time_step=0.01))
    with pytest.raises(InvalidInputError) as caught:
        check_fields(program, coarse, models)
    (mistake,) = caught.value.mistakes
    assert mistake.where == "simulation.time_step"
    assert "step 1: a1 and the border of home are 3 mm apart" in mistake.what
    least = float(mistake.remedy.split()[3])
    fine = replace(scenario, simulation=replace(scenario.simulation, time_step=least))
    check_fields(program, fine, models)


def test_far_from_everything_every_time_step_will_do(program, case_ii, models):
    seen = []
    for step, placed in zip(program.steps, program.mission.steps, strict=True):
        here = snapshot(placed.before, models)
        moving = Moving(step.travels, step.transports)
        field = FieldBuilder(case_ii, models).field(moving, here, reaches_at_begin(step, here))
        if step.travels and nearest(field.relations)[0] > NEAR:
            seen.append(longest_time_step(field, here, case_ii.controller, models))
    assert seen
    assert np.isinf(seen).all()
