"""Programs with a mistake in them carry missions out, with nobody watching: the verdict on the recording finds it.

A gradient of the wrong sign is in test_missions.py; recordings that are spoilt are in tests/verification.
"""

from __future__ import annotations

import dataclasses

import pytest

from drake_ltl.execution import runner
from drake_ltl.execution.recording import Recording
from drake_ltl.mission import measure, plan_and_place, simulate
from drake_ltl.scenario import loads
from drake_ltl.systems import program
from drake_ltl.verification import verify

pytestmark = pytest.mark.mission

APART = """
name: apart
workspace: {radius: 12}
regions:
  sw: {centre: [-4, -4, 0], radius: 2.5}
  se: {centre: [4, -4, 0], radius: 2.5}
  nw: {centre: [-4, 4, 0], radius: 2.5}
  ne: {centre: [4, 4, 0], radius: 2.5}
agents:
  a1: {model: package://drake_ltl_models/agents/planar_arm.urdf, position: [-4, -4], spec: "X nw"}
  a2: {model: package://drake_ltl_models/agents/planar_arm.urdf, position: [4, -4], spec: "X ne"}
simulation: {time_step: 0.02}
"""
FETCH = """
name: fetch
workspace: {radius: 12}
regions:
  pi1: {centre: [-4, 0, 0], radius: 3.5}
  pi2: {centre: [4, 0, 0], radius: 3.5}
agents:
  a1: {model: package://drake_ltl_models/agents/planar_arm.urdf, position: [-4, 1]}
objects:
  o1: {model: package://drake_ltl_models/objects/crate.sdf, position: [-4, -1], spec: F pi2}
simulation: {time_step: 0.02}
"""


def run(text: str, seconds: float = 60.0) -> Recording:
    """What is recorded until the mission is done, or time is over."""
    scenario = loads(text)
    models = measure(scenario)

    def report(progress) -> None:
        if progress.time >= seconds:
            raise KeyboardInterrupt

    mission = plan_and_place(scenario, models)
    return simulate(mission, scenario, models, keep_going=True, report=report).recording


def kinds(recording: Recording) -> set[str]:
    return {violation.kind for violation in verify(recording).violations}


def test_swapped_goals(monkeypatch):
    """Each drives to where the other should, mirrored by x = 0; nothing else is wrong with the run."""
    right = program.TravelTask

    def swapped(agent, start, goal, q_goal):
        other = {"nw": "ne", "ne": "nw"}[goal]
        return right(agent, start, other, q_goal * [-1.0, 1.0, *[1.0] * (len(q_goal) - 2)])

    sound = run(APART)
    assert verify(sound).satisfied
    monkeypatch.setattr(program, "TravelTask", swapped)
    recording = run(APART)
    assert recording.completed
    assert {"region", "formula"} <= kinds(recording)

    # The formula alone is the other way round: the word is judged, not the plan.
    negated = dataclasses.replace(sound, scenario=sound.scenario.replace('"X nw"', '"!(X nw)"'))
    assert kinds(negated) == {"formula"}


def test_a_weld_that_is_left_open(monkeypatch):
    """The supervisor is told that it is closed. The carrier then leaves without its load."""

    def leave_open(mission, root_context, *_):
        mission.supervisor.acknowledge(mission.supervisor.GetMyMutableContextFromRoot(root_context))

    monkeypatch.setattr(runner, "ApplyGrasps", leave_open)
    recording = run(FETCH, seconds=12.0)
    assert any(action["kind"] == "transport" for step in recording.steps for action in step.actions)
    assert "weld" in kinds(recording)
