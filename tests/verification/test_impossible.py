"""Recordings that no run could have made: each tells of a good run, but contradicts itself or its models.

One short mission is simulated; every test edits its recording, and the verdict must name what is impossible.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from drake_ltl.errors import InvalidInputError
from drake_ltl.execution.recording import Recording
from drake_ltl.mission import measure, plan_and_place, simulate
from drake_ltl.scenario import loads
from drake_ltl.verification import Verdict, verify
from drake_ltl.verification.models import work_out

CARRIER, IDLE, CRATE = "a1", "a2", "o1"
SCENARIO = """
name: errand
workspace: {radius: 14}
regions:
  pi1: {centre: [-6, 0, 0], radius: 3.5}
  pi2: {centre: [6, 0, 0], radius: 3.5}
  pi3: {centre: [0, 9, 0], radius: 3.5}
agents:
  a1:
    model: package://drake_ltl_models/agents/planar_arm.urdf
    position: [-6, 1.0]
    power: 2
    spec: "GF pi1"
  a2:
    model: package://drake_ltl_models/agents/planar_arm.urdf
    position: [0, 9]
objects:
  o1:
    model: package://drake_ltl_models/objects/crate.sdf
    position: [-6, -1.0]
    power_needed: 2
    spec: "FG pi2"
"""


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """a1 drives to crate o1, grasps it, carries it to pi2, and lets go there; a2 stands by."""
    path = tmp_path_factory.mktemp("run") / "run.npz"
    scenario = loads(SCENARIO)
    models = measure(scenario)
    simulate(plan_and_place(scenario, models), scenario, models).recording.save(path)
    return Recording.load(path)


@pytest.fixture
def run(good: Recording) -> Recording:
    """To be spoilt."""
    groups = ("q", "qd", "centre", "pose", "velocity")
    copies = {field: {name: array.copy() for name, array in getattr(good, field).items()} for field in groups}
    return dataclasses.replace(good, lyapunov=good.lyapunov.copy(), grasp=good.grasp.copy(), **copies)


def judge(recording: Recording) -> Verdict:
    scenario = loads(recording.scenario)
    return verify(recording, scenario, work_out(recording, scenario))


def step_of(recording: Recording, kind: str) -> int:
    """Number of the first step with such an action."""
    return next(step.number for step in recording.steps if any(a["kind"] == kind for a in step.actions))


def midst(recording: Recording, kind: str) -> int:
    """A sample in the midst of the first step with such an action."""
    return int(np.flatnonzero(recording.step == step_of(recording, kind)).mean())


def carrying(recording: Recording) -> slice:
    rows = np.flatnonzero(recording.step == step_of(recording, "transport"))
    return slice(int(rows[0]), int(rows[-1]) + 1)


def kinds(verdict: Verdict) -> set[str]:
    return {v.kind for v in verdict.violations}


def test_the_run_itself_is_satisfied(good):
    verdict = judge(good)
    assert verdict.satisfied, [str(v) for v in verdict.violations]
    assert {action["kind"] for step in good.steps for action in step.actions} == {
        "travel",
        "grasp",
        "transport",
        "release",
    }
    assert 0.0 < verdict.max_weld_error < 1e-3
    assert 0.0 < verdict.max_tilt < np.deg2rad(15.0)


@pytest.mark.parametrize("field", ["agent_radius", "object_radius"])
def test_radius_that_the_scenario_leaves_open(good, field):
    """It is the model's, though a smaller sphere would cover it as long as the arm is folded."""
    name = IDLE if field == "agent_radius" else CRATE
    smaller = dataclasses.replace(good, **{field: getattr(good, field) | {name: getattr(good, field)[name] - 0.01}})
    (violation,) = (v for v in judge(smaller).violations if v.what.startswith(f"the recorded radius of {name}, "))
    assert violation.worst == pytest.approx(0.01, abs=1e-9)


def test_v_is_what_the_controllers_saw(good):
    """Formed by other code, of the recorded motion."""
    V = work_out(good, loads(good.scenario)).lyapunov
    np.testing.assert_allclose(V, good.lyapunov, rtol=1e-12, atol=1e-12)  # the same numbers, added in another order
    assert np.count_nonzero(V > 1.0) > 1000


def test_carrier_stays_behind(run):
    """Its crate goes on without it, though it is said to be welded."""
    rows = carrying(run)
    for arrays in (run.q, run.centre):
        arrays[CARRIER][rows] = arrays[CARRIER][rows.start]
    run.qd[CARRIER][rows] = 0.0
    assert {"weld", "lyapunov"} <= kinds(judge(run))


def test_carried_crate_under_the_floor(run):
    """... with its team: nothing between them changes."""
    rows = carrying(run)
    run.pose[CRATE][rows, 6] -= 3.0
    assert {"motion", "weld", "body"} <= kinds(judge(run))


@pytest.mark.parametrize("aspect", ["upside down", "beside"])
def test_carried_crate_for_one_sample(run, aspect):
    sample = midst(run, "transport")
    if aspect == "beside":
        run.pose[CRATE][sample, 4] += 3.0
    else:
        run.pose[CRATE][sample, :4] = [0.0, 1.0, 0.0, 0.0]
    verdict = judge(run)
    assert {"motion", "weld"} <= kinds(verdict)
    assert (CRATE,) in {v.who for v in verdict.violations if v.kind == "motion"}


def test_idle_agent_jumps(run):
    """Within its region, and back."""
    sample = midst(run, "transport")
    run.q[IDLE][sample, 0] += 1.0
    run.centre[IDLE][sample, 0] += 1.0
    verdict = judge(run)
    assert {v.kind for v in verdict.violations} == {"motion", "lyapunov"}
    assert verdict.violations[0].worst == pytest.approx(1.0, abs=1e-6)


def test_joints_elsewhere_than_spheres(run):
    run.q[IDLE][:, 0] += 5.0
    verdict = judge(run)
    (violation,) = (v for v in verdict.violations if v.kind == "body")
    assert (violation.who, violation.worst) == ((IDLE,), pytest.approx(5.0))


def test_no_velocities(run):
    for arrays in (run.qd, run.velocity):
        for array in arrays.values():
            array[:] = 0.0
    assert {"motion", "lyapunov"} <= kinds(judge(run))


def test_v_drawn_by_hand(run):
    rows = carrying(run)
    run.lyapunov[rows] = np.linspace(50.0, 1.0, rows.stop - rows.start)
    verdict = judge(run)
    assert kinds(verdict) == {"lyapunov"}
    assert "not that of the motion" in verdict.violations[0].what


def test_v_without_goals(run):
    """No interval says what V is a function of."""
    assert kinds(judge(dataclasses.replace(run, intervals=()))) == {"lyapunov"}


def test_another_goal(run):
    """V of the motion towards elsewhere is not what was recorded, and does not fall."""
    (interval,) = (i for i in run.intervals if i.transports)
    elsewhere = dataclasses.replace(interval, transports={CRATE: (-4.0, 0.0, 0.2)})
    intervals = tuple(elsewhere if i is interval else i for i in run.intervals)
    verdict = judge(dataclasses.replace(run, intervals=intervals))
    assert kinds(verdict) == {"lyapunov"}
    assert verdict.max_lyapunov_increase > 1.0


def test_spheres_that_do_not_cover(run):
    """A radius that is too small would make clearances of what touches."""
    verdict = judge(dataclasses.replace(run, agent_radius=run.agent_radius | {IDLE: 0.2}))
    assert any(v.kind == "body" and v.who == (IDLE,) for v in verdict.violations)
    verdict = judge(dataclasses.replace(run, object_radius={CRATE: 0.2}))
    assert any(v.kind == "body" and v.who == (CRATE,) for v in verdict.violations)
    verdict = judge(dataclasses.replace(run, team_radius={CRATE: 1.5}))
    assert any(v.kind == "body" and v.who == (CRATE, CARRIER) for v in verdict.violations)


def test_crate_hovers(run):
    """Put down a centimetre above the floor, and left there."""
    released = step_of(run, "release") + 1
    run.pose[CRATE][run.step >= released, 6] += 0.01
    verdict = judge(run)
    assert any(v.kind == "body" and "above the floor" in v.what for v in verdict.violations)


def test_joints_of_another_model(run):
    with pytest.raises(InvalidInputError, match=r"recording\.q\.a2: has 5 joints"):
        judge(
            dataclasses.replace(run, **{f: getattr(run, f) | {IDLE: np.zeros((len(run.time), 5))} for f in ("q", "qd")})
        )


def test_joint_beyond_its_limits(run):
    """By a slow turn, and back."""
    turn = 4.0 * np.sin(np.linspace(0.0, np.pi, len(run.time))) ** 2
    run.q[IDLE][:, 2] += turn
    run.qd[IDLE][:, 2] += np.diff(turn, prepend=0.0) / np.diff(run.time, prepend=-1.0)
    verdict = judge(run)
    assert any(v.kind == "body" and v.who == (IDLE,) and "beyond its limits" in v.what for v in verdict.violations)
