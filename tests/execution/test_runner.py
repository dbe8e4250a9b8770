"""Short runs: how they end, and what they leave behind."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from drake_ltl.diagrams import MakeMissionDiagram
from drake_ltl.diagrams.mission_diagram import MissionDiagram
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, EventStatus, LeafSystem

from drake_ltl.errors import ExecutionError
from drake_ltl.execution.recording import NOTHING, Recording
from drake_ltl.execution.runner import RunMission
from drake_ltl.systems.mission_controller import MissionController
from drake_ltl.verification import verify


def assert_on_every_step(recording: Recording, time_step: float) -> None:
    """One sample at each step of the plant, from the start on, none in between and none twice."""
    samples = np.arange(len(recording.time))
    np.testing.assert_allclose(recording.time, samples * time_step, rtol=0, atol=1e-9)


def assert_valid(recording: Recording, scenario) -> None:
    """Whatever ended the run, it can be judged."""
    assert_on_every_step(recording, scenario.simulation.time_step)
    verdict = verify(recording, scenario)
    assert not verdict.satisfied
    assert any(f"the run ended early: {recording.reason}" in str(v) for v in verdict.violations)


def test_a_run_is_recorded(short_run, shuttle):
    scenario, recording = shuttle[1], short_run.recording
    assert recording.completed
    assert recording.reason == ""
    assert short_run.wall_seconds > 0.0
    assert_on_every_step(recording, scenario.simulation.time_step)
    assert [step.number for step in recording.steps] == [0, 1]
    assert all(step.finished for step in recording.steps)
    assert [step.actions[0]["to"] for step in recording.steps] == ["far", "near"]
    assert recording.steps[1].start == pytest.approx(recording.steps[0].duration)
    assert recording.step[0] == 0
    assert recording.step[-1] == 2
    assert np.all(np.diff(recording.step) >= 0)
    assert np.all(recording.grasp == NOTHING)
    assert recording.scenario == scenario.source
    assert set(recording.versions) == {"drake_ltl", "drake", "numpy"}


def test_positions_and_velocities_belong_together(short_run):
    """Semi-implicit steps: q changes by the new velocity; centres are those of the configurations."""
    recording = short_run.recording
    dt = np.diff(recording.time)[:, None]
    np.testing.assert_allclose(np.diff(recording.q["a1"], axis=0), dt * recording.qd["a1"][1:], atol=1e-9)


def test_centres_are_those_of_the_configurations(short_run, shuttle):
    model = shuttle[2].agents["a1"]
    for k in range(0, len(short_run.recording.time), 97):
        np.testing.assert_array_equal(short_run.recording.centre["a1"][k], model.centre(short_run.recording.q["a1"][k]))


def test_a_run_is_judged_satisfied(short_run, shuttle):
    verdict = verify(short_run.recording, shuttle[1])
    assert verdict.satisfied, [str(v) for v in verdict.violations]
    assert verdict.word == (("a1.near",), ("a1.far",), ("a1.near",))


def test_no_steps_are_soon_done(run_shuttle):
    recording = run_shuttle(0).recording
    assert recording.completed
    assert len(recording.time) == 1
    assert recording.steps == ()


def test_progress_is_reported_every_second(run_shuttle):
    seen = []
    run_shuttle(1, report=seen.append)
    assert [round(progress.time, 9) for progress in seen[:4]] == [0.0, 1.0, 2.0, 3.0]
    assert all(progress.num_steps == 1 for progress in seen)
    assert "a1" in seen[0].waiting_for[0]


def test_the_same_run_twice_is_the_same_file(run_shuttle, short_run, tmp_path):
    """Another diagram, another process's worth of memory: to the last byte."""
    short_run.recording.save(tmp_path / "one.npz")
    run_shuttle(2).recording.save(tmp_path / "two.npz")
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()


def test_a_page_changes_nothing(run_shuttle, short_run):
    """It is published between the plant's steps: the samples stay on them, and all numbers the same."""
    from drake_ltl.visualization.meshcat_scene import MakeMeshcat
    from drake_ltl.visualization.recorded_page import StartPage

    meshcat = MakeMeshcat()
    StartPage(meshcat)
    recording = run_shuttle(1, meshcat=meshcat).recording
    samples = np.count_nonzero(recording.step == 0)  # then the longer run goes on to the next step
    np.testing.assert_array_equal(recording.time[:samples], short_run.recording.time[:samples])
    np.testing.assert_array_equal(recording.q["a1"][:samples], short_run.recording.q["a1"][:samples])


def test_interruption_leaves_a_valid_partial_recording(run_shuttle, shuttle, tmp_path):
    def interrupt(progress) -> None:
        if progress.time >= 2.0:
            raise KeyboardInterrupt

    recording = run_shuttle(2, report=interrupt).recording
    assert not recording.completed
    assert recording.reason == "interrupted"
    assert recording.time[-1] == pytest.approx(2.0)
    assert [step.finished for step in recording.steps] == [False]
    assert_valid(recording, shuttle[1])
    recording.save(tmp_path / "partial.npz")
    assert Recording.load(tmp_path / "partial.npz").reason == "interrupted"


def test_an_interruption_before_the_first_step(run_shuttle, shuttle):
    def interrupt(progress) -> None:
        raise KeyboardInterrupt

    recording = run_shuttle(2, report=interrupt).recording
    assert recording.reason == "interrupted"
    verify(recording, shuttle[1])


def test_a_step_that_takes_too_long_ends_the_run(run_shuttle, shuttle):
    scenario = replace(shuttle[1], simulation=replace(shuttle[1].simulation, step_time_limit=1.5))
    recording = run_shuttle(2, scenario=scenario).recording
    assert not recording.completed
    assert recording.reason.startswith("step 1 did not finish within 1.5 s: a1 is ")
    assert "from its place in far" in recording.reason
    assert 1.5 < recording.time[-1] <= 2.5 + scenario.simulation.time_step
    assert_valid(recording, scenario)


def fail_after(monkeypatch, method, count: int, error: Exception, owner=MissionController) -> None:
    """The method does its work so many times, then raises."""
    original, calls = getattr(owner, method), iter(range(10**9))

    def failing(self, *args):
        if next(calls) >= count:
            raise error
        return original(self, *args)

    monkeypatch.setattr(owner, method, failing)


@pytest.mark.parametrize("error", [ExecutionError("the model broke"), RuntimeError("Drake's check\nfailed")])
def test_an_error_in_a_controller_ends_the_run_with_a_recording(run_shuttle, shuttle, monkeypatch, error):
    fail_after(monkeypatch, "_torques", 300, error)
    recording = run_shuttle(2).recording
    assert not recording.completed
    assert recording.reason == " ".join(str(error).split())
    assert 200 < len(recording.time) <= 301
    assert_valid(recording, shuttle[1])


def test_an_error_at_the_very_start_has_a_recording_too(run_shuttle, shuttle, monkeypatch):
    fail_after(monkeypatch, "_torques", 0, ExecutionError("nothing works"))
    recording = run_shuttle(2).recording
    assert recording.reason == "nothing works"
    assert recording.steps == ()
    assert not verify(recording, shuttle[1]).satisfied


def test_defects_of_a_program_pass(run_shuttle, monkeypatch):
    fail_after(monkeypatch, "_torques", 10, ZeroDivisionError("a defect"))
    with pytest.raises(ZeroDivisionError, match="a defect"):
        run_shuttle(1)


def test_a_torque_that_is_no_number_ends_the_run(run_shuttle, shuttle, monkeypatch):
    """Drake refuses it by itself."""
    from drake_ltl.systems import mission_controller

    monkeypatch.setattr(mission_controller, "transition_torque", lambda *args: np.full(4, np.nan))
    recording = run_shuttle(1).recording
    assert "NaN" in recording.reason
    assert not recording.completed


class Stopper(LeafSystem):
    """A user's monitor that ends the simulation at a time."""

    def __init__(self, time: float):
        super().__init__()
        self.set_name("stopper")
        self.DeclarePerStepPublishEvent(
            lambda context: (
                EventStatus.ReachedTermination(self, "enough")
                if context.get_time() >= time
                else EventStatus.DidNothing()
            )
        )


def test_a_monitor_of_a_user_ends_the_run(shuttle):
    mission, scenario, models = shuttle
    builder = DiagramBuilder()
    builder.AddSystem(Stopper(0.5))
    diagram = MakeMissionDiagram(mission, scenario, models, num_steps=1, builder=builder)
    recording = RunMission(diagram, num_steps=1).recording
    assert not recording.completed
    assert "enough" in recording.reason
    assert recording.time[-1] == pytest.approx(0.5, abs=0.01)


def test_a_user_s_simulator_is_taken(shuttle):
    mission, scenario, models = shuttle
    diagram: MissionDiagram = MakeMissionDiagram(mission, scenario, models, num_steps=1)
    simulator = Simulator(diagram.diagram, diagram.CreateStartContext())
    recording = RunMission(diagram, num_steps=1, simulator=simulator).recording
    assert recording.completed
    assert simulator.get_context().get_time() == pytest.approx(recording.time[-1])


def test_a_grasp_that_does_not_fit_ends_the_run(mission, case_ii, models, monkeypatch):
    """The supervisor commands a weld across the workspace at the start."""
    diagram = MakeMissionDiagram(mission, case_ii, models, num_steps=1)
    monkeypatch.setattr(diagram.supervisor, "grasps_pending", lambda context: True)
    monkeypatch.setattr(diagram.supervisor, "commanded_grasps", lambda context: [0, -1, -1])
    recording = RunMission(diagram, num_steps=1).recording
    assert recording.reason.startswith("a1 cannot be welded to o1")
