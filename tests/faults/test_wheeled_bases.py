"""Differential drives of which something goes wrong: they stop and hold, find a place, and another one goes on."""

from __future__ import annotations

import numpy as np
import pytest

from drake_ltl import mission
from drake_ltl.multibody.drive_agent import YAW
from drake_ltl.scenario import loads
from drake_ltl.verification import verify

TEXT = """
workspace: {radius: 3.5}
regions:
  dock: {centre: [-1.6, 0.0, 0.0], radius: 1.0}
  shop: {centre: [1.6, 0.0, 0.0], radius: 0.9}
  yard: {centre: [0.8, 2.3, 0.0], radius: 0.7}
agents:
  a1: {model: MODEL, position: [-1.5, -0.5], heading: 2.0}
  a2: {model: MODEL, position: [-1.5, 0.4], heading: 0.4}
spec: "F(a1.shop | a2.shop | a1.yard | a2.yard)"
faults:
  - {kind: blocked_region, region: shop, time: 2.6}
  - {kind: agent_stops, agent: a2, time: 11.0}
""".replace("MODEL", "package://drake_ltl_models/bases/differential_drive.urdf")


@pytest.fixture(scope="module")
def run():
    """(run, scenario): the shop is blocked while a2 is on its way there; on its way to the yard it stops."""
    scenario = loads(TEXT)
    models = mission.measure(scenario)
    planned = mission.plan_and_place(scenario, models)
    return mission.simulate(planned, scenario, models, announce=lambda line: None), scenario


def test_the_whole_run_is_satisfied(run):
    verdict = verify(run[0].recording, run[1])
    assert verdict.satisfied, [str(violation) for violation in verdict.violations]
    ways = [(a["agents"], a["from"], a["to"]) for step in run[0].recording.steps for a in step.actions]
    assert ways == [
        (["a2"], "dock", "shop"),
        (["a2"], "shop", "dock"),  # back to where there is a place
        (["a2"], "dock", "yard"),
        (["a1"], "dock", "yard"),
    ]


def test_each_fault_is_noticed_soon(run):
    blocked, stopped = run[0].noticed
    (_, first), (_, second) = run[0].happened
    assert (blocked.seen.who, stopped.seen.who) == (("shop",), ("a2",))
    assert blocked.seen.time - first.time < 0.15
    assert stopped.seen.time - second.time < 0.25  # what docs/faults.md promises of arms
    assert blocked.lost == "nobody may enter shop any more"
    assert "a2 is out of service" in stopped.lost


def test_they_brake_and_hold(run):
    """Within 50 cm, as verdicts bear, and without slipping over the floor."""
    recording = run[0].recording
    end = next(step.start + step.duration for step in recording.steps if step.halted)
    braking = (recording.time > run[0].noticed[0].seen.time) & (recording.time <= end)
    way = recording.q["a2"][braking][:, :2]
    assert np.linalg.norm(way - way[0], axis=1).max() < 0.25
    assert np.abs(recording.qd["a2"][braking][-1]).max() <= 0.02


def test_it_comes_back_with_a_heading_of_its_own(run):
    """Where nothing else is said, the one with which it began."""
    recording = run[0].recording
    (back,) = (s for s in recording.steps if s.actions and s.actions[0]["from"] == "shop")
    last = np.flatnonzero(recording.step == back.number)[-1]
    assert np.cos(recording.q["a2"][last, YAW] - 0.4) > np.cos(0.03)


def test_who_has_stopped_stays(run):
    recording = run[0].recording
    after = recording.time > run[0].noticed[1].seen.time
    way = recording.centre["a2"][after]
    assert np.abs(way - way[0]).max() < 1e-3
