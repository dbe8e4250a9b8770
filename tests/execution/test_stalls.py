"""Runs that meet a saddle, and dense arrivals: both finish."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drake_ltl.mission import measure, plan_and_place, simulate
from drake_ltl.scenario import load, loads
from drake_ltl.verification import verify

pytestmark = pytest.mark.mission

GATHERING = Path(__file__).parents[2] / "examples" / "gathering.yaml"
IN_LINE = """
name: saddle
workspace: {radius: 20}
regions:
  pi1: {centre: [-10, 0, 0], radius: 3.0}
  pi2: {centre: [0, 0, 0], radius: 3.0}
  pi3: {centre: [10, 0, 0], radius: 3.0}
agents:
  a1:
    model: package://drake_ltl_models/agents/planar_arm.urdf
    position: [-10, 0]
    radius: 1.25
    spec: "F pi3 & G !pi2"
objects: {}
"""


ONE_BEHIND_THE_OTHER = """
name: queue
workspace: {radius: 20}
regions:
  out: {centre: [-5, 0, 0], radius: 5.0}
  mid: {centre: [6, 0, 0], radius: 5.0}
agents:
  a1: {model: "package://drake_ltl_models/agents/planar_arm.urdf", position: [-3, 0], radius: 1.25, heading: 0.0}
  a2: {model: "package://drake_ltl_models/agents/planar_arm.urdf", position: [-7, 0], radius: 1.25, heading: 0.0}
objects: {}
spec: "F(a1.mid & a2.mid)"
"""


def carried_out(scenario):
    models = measure(scenario)
    return simulate(plan_and_place(scenario, models), scenario, models).recording


def test_a_run_that_rests_on_a_saddle_is_led_around_and_says_so():
    """Start, forbidden region and goal lie on one line: the gradient leads straight onto the saddle."""
    scenario = loads(IN_LINE)
    recording = carried_out(scenario)
    verdict = verify(recording, scenario)

    assert verdict.satisfied, [str(violation) for violation in verdict.violations]
    assert verdict.detours == (0,)
    first = recording.centre["a1"][recording.phase == 0]
    assert np.abs(first[:, 1]).max() < 0.01  # straight ahead until it rested
    assert np.abs(recording.centre["a1"][:, 1]).max() > 3.0


def test_who_arrives_first_in_the_nearer_place_moves_on_when_the_other_stalls_behind_it():
    """All stand on one line, and the places are given in the wrong order."""
    scenario = loads(ONE_BEHIND_THE_OTHER)
    models = measure(scenario)
    mission = plan_and_place(scenario, models)
    step = mission.steps[0]
    places = {"a1": 4.5, "a2": 7.5}
    stands = {name: replace(step.after.agents[name], p_WC=(x, 0.0, 1.0)) for name, x in places.items()}
    steps = (replace(step, after=replace(step.after, agents=stands)), *mission.steps[1:])
    recording = simulate(replace(mission, steps=steps), scenario, models).recording
    verdict = verify(recording, scenario)

    assert verdict.satisfied, [str(violation) for violation in verdict.violations]
    assert (verdict.exchanges, verdict.detours) == ((0,), ())
    assert recording.centre["a1"][-1, 0] == pytest.approx(7.5, abs=scenario.tolerances.position)
    assert recording.centre["a2"][-1, 0] == pytest.approx(4.5, abs=scenario.tolerances.position)


def test_six_agents_arrive_in_a_region_that_just_holds_them():
    scenario = load(GATHERING)
    recording = carried_out(scenario)
    verdict = verify(recording, scenario)

    assert verdict.satisfied, [str(violation) for violation in verdict.violations]
    assert verdict.min_clearance["agent_agent"] > 0.0
