"""Whole missions: case ii carried out and judged, and what a bad controller makes of it."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from drake_ltl.diagrams import MakeMissionDiagram
from drake_ltl.models import package_xml

from drake_ltl.execution.recording import NOTHING, Recording
from drake_ltl.execution.runner import RunMission
from drake_ltl.mission import measure, num_steps, plan_and_place, simulate
from drake_ltl.scenario import loads
from drake_ltl.systems import mission_controller
from drake_ltl.systems.field_value import FieldValue
from drake_ltl.verification import Verdict, verify

pytestmark = pytest.mark.mission


@pytest.fixture(scope="module")
def recording(case_ii_run) -> Recording:
    return case_ii_run.recording


@pytest.fixture(scope="module")
def verdict(recording) -> Verdict:
    """By the recording alone."""
    return verify(recording)


def test_case_ii_is_satisfied(verdict):
    assert verdict.satisfied, [str(violation) for violation in verdict.violations]


def test_every_kind_of_action_is_done(recording, mission):
    """In the order of the plan: its prefix, and its suffix twice."""
    assert recording.completed
    assert len(recording.steps) == num_steps(mission, 2)
    assert {action["kind"] for step in recording.steps for action in step.actions} == {
        "travel",
        "grasp",
        "transport",
        "release",
    }
    assert all(step.finished for step in recording.steps)


def test_nothing_comes_too_close(verdict):
    for kind in ("agent_agent", "agent_object", "team_other", "forbidden_region"):
        assert verdict.min_clearance[kind] > 0.0, kind


def test_v_never_rises(verdict, recording):
    assert verdict.max_lyapunov_increase <= 1e-6
    assert recording.lyapunov.max() > 100.0  # it was there to fall


def test_welds_hold(verdict):
    assert verdict.max_weld_error <= 1e-3  # [m], what a weld may be made with


def test_the_word_satisfies_the_formulas(verdict):
    """Read by hand from the specification of case ii, for one round that repeats."""
    letters = [set(letter) for letter in verdict.word]
    assert not any("a1.pi3" in letter for letter in letters)
    assert any("a2.pi3" in letter for letter in letters[-2:])
    assert any("o2.pi3" in letter for letter in letters[-2:])
    assert any("o1.pi1" in letter for letter in letters[-2:])
    assert any("o1.pi4" in letter for letter in letters[-2:])


def test_the_loop_closes(recording):
    """The second round does what the first did, and ends where the first ended."""
    prefix, suffix = recording.prefix_length, recording.suffix_length
    first, second = recording.steps[prefix : prefix + suffix], recording.steps[prefix + suffix :]
    assert [step.actions for step in first] == [step.actions for step in second]
    ends = [np.searchsorted(recording.time, step.start + step.duration) for step in (first[-1], second[-1])]
    for origin in recording.object_origin.values():
        np.testing.assert_allclose(origin[ends[0]], origin[ends[1]], atol=0.06)  # twice the tolerance of a goal
    assert np.array_equal(*(recording.grasp[min(end, len(recording.time) - 1)] for end in ends))


def test_samples_are_on_the_plant_s_steps(recording, case_ii):
    """Also where the run paused to switch welds."""
    samples = np.arange(len(recording.time))
    np.testing.assert_allclose(recording.time, samples * case_ii.simulation.time_step, rtol=0, atol=1e-7)
    assert np.any(np.diff(recording.grasp, axis=0) != 0)


def test_what_is_carried_is_held(recording):
    """Whenever an object moves faster than a creep, the agents of its team are welded to it."""
    for column, obj in enumerate(recording.objects):
        moving = np.linalg.norm(recording.velocity[obj][:, 3:], axis=1) > 0.1
        assert moving.any()
        held = (recording.grasp == column).sum(axis=1)
        assert held[moving].min() == 2


def test_a_load_is_carried_upright(recording):
    for pose in recording.pose.values():
        w, x, y, z = pose[:, :4].T
        tilt = np.arccos(np.clip(1.0 - 2.0 * (x**2 + y**2), -1.0, 1.0))
        assert np.rad2deg(tilt.max()) < 1.0
        assert np.rad2deg(2.0 * np.abs(np.arctan2(z, w)).max()) < 3.0  # yaw


def test_nobody_drifts_while_holding(recording):
    """An idle agent keeps its place to a millimetre, whatever goes on around it."""
    idle = (recording.mode == 0) & (recording.grasp == NOTHING)
    checked = 0
    for column, agent in enumerate(recording.agents):
        changes = np.flatnonzero(np.diff(idle[:, column].astype(int))) + 1
        for begin, end in pairwise([0, *changes, len(idle)]):
            if idle[begin, column] and end - begin > 400:
                settled = recording.q[agent][begin + 200 : end]  # it brakes in the first second
                assert np.ptp(settled, axis=0).max() < 1e-3
                checked += 1
    assert checked


def test_a_file_says_the_same_as_the_run(recording, verdict, tmp_path):
    recording.save(tmp_path / "run.npz")
    assert verify(Recording.load(tmp_path / "run.npz")) == verdict


def test_the_same_mission_again_is_the_same(recording, mission, case_ii, models):
    """Its first two steps, with grasps in them, by another diagram: equal to the last bit."""
    again = RunMission(MakeMissionDiagram(mission, case_ii, models, num_steps=2), num_steps=2).recording
    samples = np.count_nonzero(again.step < 2)  # the last ones are already of the next step there
    for name in recording.agents:
        np.testing.assert_array_equal(again.q[name][:samples], recording.q[name][:samples])
    for name in recording.objects:
        np.testing.assert_array_equal(again.pose[name][:samples], recording.pose[name][:samples])
    np.testing.assert_array_equal(again.lyapunov[:samples], recording.lyapunov[:samples])


# Bad controllers.


def test_a_gradient_of_the_wrong_sign_is_judged_violated(mission, case_ii, models, monkeypatch):
    """Movers are driven from their goals to the border of the workspace."""
    right = mission_controller.evaluate_field

    def wrong(*args):
        value = right(*args)
        return replace(
            value,
            agents={name: -slope for name, slope in value.agents.items()},
            objects={name: -slope for name, slope in value.objects.items()},
        )

    monkeypatch.setattr(mission_controller, "evaluate_field", wrong)
    run = simulate(mission, case_ii, models, keep_going=True)
    verdict = verify(run.recording)
    assert not verdict.satisfied
    kinds = {violation.kind for violation in verdict.violations}
    assert {"lyapunov", "run"} <= kinds
    assert verdict.max_lyapunov_increase > 0.01


CROSSING = """\
name: crossing
workspace: {radius: 13.0}
regions:
  near: {centre: [-6.0, 0.0, 0.0], radius: 2.5}
  between: {centre: [0.0, 0.5, 0.0], radius: 2.0}
  far: {centre: [6.0, 0.0, 0.0], radius: 2.5}
agents:
  a1:
    model: package://drake_ltl_models/agents/planar_arm.urdf
    position: [-6.0, 0.0]
    power: 1
    spec: "F far & G !between"
"""


def straight_ahead(field, force, models, world) -> FieldValue:
    """A potential that knows no obstacles, with a V of its own that falls."""
    (task,) = field.travels
    weights = models[task.agent].gamma_weights
    error = weights * (world.q(task.agent) - task.q_goal)
    length = np.sqrt(0.25 + error @ error)
    return FieldValue(force * length, {task.agent: force * weights * error / length}, {})


@pytest.mark.parametrize("bad", [False, True], ids=["around", "across"])
def test_who_ignores_obstacles_is_judged_violated(monkeypatch, bad):
    """The way leads across a region that is neither start nor goal; all else looks fine, but for a V of its own."""
    scenario = loads(CROSSING)
    models = measure(scenario)
    if bad:
        monkeypatch.setattr(mission_controller, "evaluate_field", straight_ahead)
    run = simulate(plan_and_place(scenario, models), scenario, models, keep_going=True)
    verdict = verify(run.recording)
    assert run.recording.completed
    assert verdict.satisfied is not bad, [str(violation) for violation in verdict.violations]
    if bad:
        kinds = {violation.kind for violation in verdict.violations}
        assert kinds == {"forbidden_region", "lyapunov", "monitor"}  # V was its own
        assert {seen.monitor for seen in run.recording.monitored} == {"forbidden_region"}  # they see the V of its own
        assert verdict.min_clearance["forbidden_region"] < -2.0
    else:
        assert verdict.min_clearance["forbidden_region"] > 0.0


ERRAND = """\
name: errand
workspace: {radius: 20.0}
regions:
  near: {centre: [-7.5, 0.0, 0.0], radius: 6.5}
  far: {centre: [7.0, 0.5, 0.0], radius: 6.0}
agents:
  a1: {model: yaw_arm.urdf, position: [-10.0, 2.5]}
  a2: {model: yaw_arm.urdf, position: [5.0, 2.0]}
objects:
  crate:
    model: package://drake_ltl_models/objects/crate.sdf
    position: [-7.0, 0.0]
    power_needed: 2
    spec: "GF near & GF far"
"""


def test_arms_with_a_yaw_joint_carry(tmp_path, yaw_joint):
    """Five joints, whose actuators stand in another order."""
    text = (package_xml().parent / "agents" / "planar_arm.urdf").read_text(encoding="utf-8")
    for old, new in yaw_joint.items():
        text = text.replace(old, new)
    (tmp_path / "yaw_arm.urdf").write_text(text, encoding="utf-8")
    scenario = loads(ERRAND, base=tmp_path)
    models = measure(scenario)
    run = simulate(plan_and_place(scenario, models), scenario, models)
    assert any(action["kind"] == "transport" for step in run.recording.steps for action in step.actions)
    verdict = verify(run.recording, scenario)
    assert verdict.satisfied, [str(violation) for violation in verdict.violations]


TIGHT = """\
name: tight
workspace: {radius: 30.0}
regions:
  r1: {centre: [15.3, 0.4, 0], radius: 4.0}
  r2: {centre: [-0.7, 0.8, 0], radius: 4.5}
  r3: {centre: [15.6, -18.0, 0], radius: 4.5}
  r4: {centre: [-10.2, -18.9, 0], radius: 4.0}
agents:
  a1:
    model: package://drake_ltl_models/agents/planar_arm.urdf
    position: [15.21, 0.41]
    radius: 1.25
    spec: "G !r4"
  a2:
    model: package://drake_ltl_models/agents/planar_arm.urdf
    position: [-10.92, -19.19]
    radius: 1.25
    spec: "F(r4 & F r1)"
seed: 307
"""


def test_room_for_one_more():
    """a1 stands in the middle of a region; between it and the border there are 6 cm to spare. a2 comes close, stalls
    with its arm folded away, and goes on from a way point where there is room."""
    scenario = loads(TIGHT)
    models = measure(scenario)
    run = simulate(plan_and_place(scenario, models), scenario, models)
    verdict = verify(run.recording)
    assert verdict.satisfied, [str(violation) for violation in verdict.violations]
    assert run.recording.phase.max() > 0
