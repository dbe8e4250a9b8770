"""Something is deliberately made wrong, and a monitor ends the run with the right words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from drake_ltl.diagrams import MakeMissionDiagram

from drake_ltl.execution import runner
from drake_ltl.execution.recording import Recording
from drake_ltl.execution.runner import Run, RunMission
from drake_ltl.mission import measure, plan_and_place
from drake_ltl.scenario import loads
from drake_ltl.systems import mission_controller
from drake_ltl.verification import verify

CARRY = """\
name: carry
workspace: {radius: 12.0}
regions:
  near: {centre: [-4.0, 0.0, 0.0], radius: 2.9}
  far: {centre: [5.0, 0.5, 0.0], radius: 2.9}
agents:
  a1:
    model: package://drake_ltl_models/agents/planar_arm.urdf
    position: [-5.2, 0.0]
    power: 1
objects:
  o1:
    model: package://drake_ltl_models/objects/crate.sdf
    position: [-3.0, 0.0]
    power_needed: 1
    spec: "F far"
"""


@pytest.fixture(scope="module")
def carry():
    """(mission, scenario, models) of one agent that grasps a crate and brings it to another region."""
    scenario = loads(CARRY)
    models = measure(scenario)
    return plan_and_place(scenario, models), scenario, models


def assert_ended_by(run: Run, monitor: str, text: str) -> Recording:
    """The recording of a run that a monitor ended; nothing else was seen before."""
    recording = run.recording
    assert not recording.completed
    assert recording.reason == f"a monitor saw: {recording.monitored[0]}"
    assert recording.monitored[0].monitor == monitor
    assert text in recording.reason
    assert recording.time[-1] == pytest.approx(recording.monitored[0].time)
    return recording


def upwards(monkeypatch) -> None:
    """Travellers go up the navigation function: a wrong sign of the gradient."""
    right = mission_controller.transition_torque
    monkeypatch.setattr(
        mission_controller,
        "transition_torque",
        lambda gravity, gradient, damping, qd: right(gravity, -gradient, damping, qd),
    )


def test_nothing_is_seen_where_all_is_well(short_run):
    assert short_run.recording.monitored == ()


def test_a_wrong_sign_of_the_gradient(run_shuttle, shuttle, monkeypatch):
    """V rises from the start on, long before anybody hits anything."""
    upwards(monkeypatch)
    recording = assert_ended_by(run_shuttle(2), "lyapunov", "V rises, relative to its start: ")
    assert recording.reason.startswith("a monitor saw: step 1, 0.")
    assert recording.time[-1] < 0.2
    verdict = verify(recording, shuttle[1])
    assert [violation.kind for violation in verdict.violations].count("lyapunov") == 1  # which sees it by itself
    assert any(recording.reason in str(violation) for violation in verdict.violations)


def test_swapped_goals(shuttle):
    """The program drives a1 to where it comes from, which takes no time."""
    mission, scenario, models = shuttle
    diagram = MakeMissionDiagram(mission, scenario, models, num_steps=2)
    there, back = (step.travels[0].q_goal for step in diagram.program.steps)
    there[:], back[:] = back.copy(), there.copy()
    recording = assert_ended_by(RunMission(diagram, num_steps=2), "region", "a1 has not come to far: -")
    assert recording.monitored[0].who == ("a1", "far")
    assert recording.monitored[0].step == 1  # the step before had ended


def test_steps_that_take_no_time_are_looked_at_too(shuttle):
    """Both are over before a monitor looks again."""
    mission, scenario, models = shuttle
    diagram = MakeMissionDiagram(mission, scenario, models, num_steps=2)
    there, back = (step.travels[0].q_goal for step in diagram.program.steps)
    there[:] = back
    assert_ended_by(RunMission(diagram, num_steps=2), "region", "a1 has not come to far: -")


def test_a_negated_formula(shuttle):
    """The run is watched for the contrary of what was planned."""
    mission, scenario, models = shuttle
    (a1,) = scenario.agents
    negated = replace(scenario, agents=(replace(a1, spec="!(F far)"),))
    diagram = MakeMissionDiagram(mission, negated, models, num_steps=2)
    assert_ended_by(RunMission(diagram, num_steps=2), "word", "step 2, ").reason.endswith(
        "nothing can satisfy a1's formula any more: !(F far)"
    )


def test_a_weld_left_open(carry, monkeypatch):
    """Grasps are acknowledged, and never made: a1 drives off with its hand on the handle, and the crate stays."""

    def acknowledge(mission, root_context):
        mission.supervisor.acknowledge(mission.supervisor.GetMyMutableContextFromRoot(root_context))

    monkeypatch.setattr(runner, "ApplyGrasps", acknowledge)
    mission, scenario, models = carry
    diagram = MakeMissionDiagram(mission, scenario, models, num_steps=2)
    recording = assert_ended_by(RunMission(diagram, num_steps=2), "weld", "step 2, ")
    seen = recording.monitored[0]
    assert seen.who == ("a1", "o1")
    assert "the weld of a1 to o1 gapes: " in str(seen)
    assert 0.003 < seen.value < 0.8  # [m]: what was to lift the crate throws the hand up, between two looks
    assert any(violation.kind == "weld" for violation in verify(recording, scenario).violations)


def test_going_on(run_shuttle, shuttle, monkeypatch, tmp_path):
    """All that is seen is recorded, each thing once in a step, and none of it is excused."""
    upwards(monkeypatch)
    scenario = replace(shuttle[1], simulation=replace(shuttle[1].simulation, step_time_limit=2.0))
    recording = run_shuttle(1, scenario=scenario, keep_going=True).recording
    assert recording.reason.startswith("in collision: ") or "did not finish" in recording.reason
    kinds = [seen.monitor for seen in recording.monitored]
    assert "lyapunov" in kinds
    assert len(recording.monitored) == len({seen.key for seen in recording.monitored})
    assert np.all(np.diff([seen.time for seen in recording.monitored]) >= 0.0)
    assert recording.time[-1] > recording.monitored[0].time + 0.5
    recording.save(tmp_path / "run.npz")
    again = Recording.load(tmp_path / "run.npz")
    assert again.monitored == recording.monitored
    assert any(
        "the lyapunov monitor saw: V rises" in str(violation) for violation in verify(again, scenario).violations
    )


def test_a_run_without_monitors_is_the_same(shuttle, short_run, tmp_path):
    """They observe, and never act: to the last byte."""
    mission, scenario, models = shuttle
    diagram = MakeMissionDiagram(mission, scenario, models, num_steps=2, monitors=False)
    assert diagram.monitors == {}
    RunMission(diagram, num_steps=2).recording.save(tmp_path / "without.npz")
    short_run.recording.save(tmp_path / "with.npz")
    assert (tmp_path / "without.npz").read_bytes() == (tmp_path / "with.npz").read_bytes()
