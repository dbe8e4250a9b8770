"""A good run is satisfied; each thing that is spoilt is found, with its name, its time and its size, and alone."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from drake_ltl.execution.recording import NOTHING, Recording
from drake_ltl.verification import Verdict, Violation, verify
from drake_ltl.verification.arrivals import arrival_violations
from drake_ltl.verification.lyapunov import NO_VALUE, lyapunov_rises, lyapunov_violations
from drake_ltl.verification.potential import TOUCHING
from drake_ltl.verification.roles import Roles
from drake_ltl.verification.spans import step_spans
from drake_ltl.verification.starts import start_pose_violations
from drake_ltl.verification.word import last_round, readings, word_violations

PER_STEP = 50  # samples of one step, 1 s long
TRAVEL, GRASP, CARRY, RELEASE, MIXED = 0, 1, 2, 3, 4  # numbers of steps


def during(step: int, begin: int = 20, end: int = 30) -> slice:
    """Some samples in the midst of a step."""
    return slice(step * PER_STEP + begin, step * PER_STEP + end)


def only(verdict: Verdict, kind: str) -> Violation:
    """The one violation of a verdict, which is of this kind; what is put elsewhere also jumps."""
    found = [v for v in verdict.violations if v.kind == kind or not jumps(v)]
    assert [v.kind for v in found] == [kind], "\n".join(map(str, verdict.violations))
    assert not verdict.satisfied
    return found[0]


def kinds(verdict: Verdict) -> set[str]:
    """All but the jumps of what is put elsewhere."""
    return {v.kind for v in verdict.violations if not jumps(v)}


def jumps(violation: Violation) -> bool:
    """Whether it says no more than that somebody is put elsewhere."""
    return violation.kind == "motion" or "under no navigation function" in violation.what


def respecified(recording: Recording, old: str, new: str) -> Recording:
    assert old in recording.scenario
    return dataclasses.replace(recording, scenario=recording.scenario.replace(old, new))


# What is good.


def test_a_good_run_is_satisfied(recording):
    verdict = verify(recording)
    assert verdict.violations == ()
    assert verdict.satisfied
    assert verdict.word[0] == ("a1.pi1", "a2.pi3", "a3.pi4", "o1.pi2", "o2.pi4")
    assert verdict.word[1] == verdict.word[9] == ("a1.pi2", "a2.dock", "a3.pi4", "o1.pi2", "o2.pi4")
    assert len(verdict.word) == 10
    assert verdict.simulated_seconds == pytest.approx(9.0)
    assert verdict.max_weld_error < 3e-4  # welded two samples before the gripper is quite there
    assert verdict.max_weld_angle == pytest.approx(0.0, abs=1e-12)
    assert verdict.max_lyapunov_increase == 0.0


def test_numbers_agree_with_brute_force(recording):
    least = verify(recording).min_clearance
    # while carrying, a3 and o2 keep away from the team's sphere; o2 is the nearer one, a3 stands behind it
    team = [recording.pose["o1"][during(s, 0, PER_STEP + 1), 4:] for s in (2, 7)]
    offsets = np.concatenate(team) - recording.pose["o2"][0, 4:]
    assert least["team_other"] == pytest.approx(np.linalg.norm(offsets, axis=1).min() - 2.4 - 0.4, abs=1e-12)
    # a2 passes pi4 on the line from (0, 10) to (10, 1.3), 0.2 m up
    passing = 10.0 * 8.7 / np.hypot(10.0, 8.7)
    assert least["forbidden_region"] == pytest.approx(np.hypot(passing, 0.2) - 3.5 - 0.7, abs=1e-12)
    # members of one team, 90 degrees apart at the crate
    assert least["agent_agent"] == pytest.approx(1.05 * np.sqrt(2) - 1.4, abs=1e-12)
    # a1 waits apart from the crate at the end of step 5
    assert least["agent_object"] == pytest.approx(1.3 - 1.1, abs=1e-12)
    assert set(least) == {"agent_agent", "agent_object", "object_object", "team_other", "forbidden_region", "workspace"}


def test_more_rounds(draw):
    assert verify(draw(9 + 16)).satisfied


def test_half_a_round_more(draw):
    assert verify(draw(9 + 4)).satisfied


def test_loop_that_begins_with_grasps(draw):
    """States 3 and 11 are held by both; the weld that the next step opens at once still belongs to state 3."""
    assert verify(dataclasses.replace(draw(11), prefix_length=3)).satisfied


@pytest.mark.parametrize(
    ("num_states", "expected"), [(1, None), (9, None), (10, (1, 9)), (17, (8, 16)), (18, (9, 17)), (26, (17, 25))]
)
def test_the_last_round_ends_with_the_run(recording, num_states, expected):
    assert last_round(recording, num_states) == expected


def test_saved_and_loaded(recording, tmp_path):
    recording.save(tmp_path / "run.npz")
    assert verify(Recording.load(tmp_path / "run.npz")) == verify(recording)


# How it began.


@pytest.mark.parametrize(("joint", "by"), [(0, 0.01), (2, 0.1), (3, 0.01), (7, 0.1)])
def test_drive_that_begins_turned(recording, scenario, joint, by):
    *others, a3 = scenario.agents
    a3 = dataclasses.replace(a3, has_arm=False, heading=1.5)
    drives = dataclasses.replace(scenario, agents=(*others, a3))
    q = np.pad(recording.q["a3"], ((0, 0), (0, 4)))
    q[:, 2], q[:, 3] = a3.heading, -1e-4  # its wheels' give
    begun = dataclasses.replace(recording, q=recording.q | {"a3": q})
    assert not list(start_pose_violations(begun, drives))
    q[:, joint] += by
    (violation,) = start_pose_violations(begun, drives)
    assert violation.who == ("a3",)
    assert violation.worst == pytest.approx(by, rel=0.02)


# Regions.


def test_wrong_region(recording):
    """a2 ends a step beside pi3 and leaves from there."""
    end = (MIXED + 1) * PER_STEP
    recording.centre["a2"][end - 5 : end + 1, 0] += 3.5
    lenient = respecified(recording, " & GF pi3", "")
    lenient = respecified(lenient, "F a2.pi3", "F a2.dock")
    violation = only(verify(lenient), "region")
    assert violation.who == ("a2", "pi3")
    assert violation.step == MIXED
    assert violation.time == pytest.approx(5.0)
    assert violation.worst == pytest.approx(np.hypot(3.5, 0.2) + 0.7 - 3.5)


def test_swapped_goals(recording):
    """a1 goes where a2 should and the other way round, in the step that leads both apart."""
    way, speed = recording.centre["a2"].copy(), recording.qd["a2"].copy()
    first, after = MIXED * PER_STEP, (MIXED + 2) * PER_STEP + 1
    for arrays, other in ((recording.centre, way), (recording.qd, speed)):
        spare = arrays["a1"][first:after].copy()
        arrays["a1"][first:after], arrays["a2"][first:after] = other[first:after], spare
    verdict = verify(recording)
    assert {("a2", "pi3"), ("a1", "pi1")} <= {v.who for v in verdict.violations if v.kind == "region"}
    assert {("a1",), ("a2",)} <= {v.who for v in verdict.violations if v.kind == "formula"}


def test_idle_agent_leaves_its_region_and_comes_back(recording):
    recording.centre["a3"][during(CARRY), 1] += 2.0
    violation = only(verify(recording), "region")
    assert violation.who == ("a3", "pi4")
    assert (violation.step, violation.time) == (CARRY, pytest.approx(2.4))
    assert violation.worst == pytest.approx(np.hypot(3.0, 0.2) + 0.7 - 3.5)


def test_grasping_agent_leaves_its_region(recording):
    recording.centre["a2"][during(GRASP), 1] = 3.0
    assert only(verify(recording), "region").who == ("a2", "pi2")


def test_sphere_not_centre(recording):
    """The centre alone is still inside."""
    recording.centre["a3"][during(CARRY), 1] = 10.0 + 2.9
    assert only(verify(recording), "region").worst == pytest.approx(np.hypot(2.9, 0.2) + 0.7 - 3.5)


def test_start_outside_every_region(recording):
    recording.centre["a3"][:, 1] = 15.0
    violation = only(verify(recording), "region")
    assert (violation.who, violation.time) == (("a3",), 0.0)
    assert not any(letter.startswith("a3.") for letter in verify(recording).word[0])


def test_action_from_elsewhere(recording):
    actions = recording.steps[TRAVEL].actions
    wrong = dataclasses.replace(recording.steps[TRAVEL], actions=({**actions[0], "from": "pi2"}, actions[1]))
    verdict = verify(dataclasses.replace(recording, steps=(wrong, *recording.steps[1:])))
    assert [v.who for v in verdict.violations if v.kind == "action"] == [("a1",)]
    assert kinds(verdict) == {"action", "forbidden_region"}  # so pi1 is none of its two regions either


# Clearances.


@pytest.mark.parametrize(
    ("step", "who"),
    [(TRAVEL, ("a1", "a2")), (CARRY, ("a1", "a2")), (MIXED, ("a1", "a2"))],
)
def test_agents_collide_on_their_way(recording, step, who):
    """Travellers, members of one team, a traveller and one that backs off."""
    at = during(step)
    recording.centre["a2"][at] = recording.centre["a1"][at] + [0.0, 1.3, 0.0]
    verdict = verify(recording)
    violation = next(v for v in verdict.violations if v.kind == "clearance" and v.who == who)
    assert violation.worst >= 0.1 - 1e-12
    assert violation.step == step
    assert verdict.min_clearance["agent_agent"] == -violation.worst


def test_agent_hits_object(recording):
    recording.centre["a3"][during(GRASP), 1] -= 1.0
    violation = only(verify(recording), "clearance")
    assert violation.who == ("a3", "o2")
    assert violation.worst == pytest.approx(0.1)
    assert violation.time == pytest.approx(1.38)  # on the way from the sample before


def test_agent_hits_object_it_no_longer_grasps(recording):
    """Where it may be while it holds, it may not while it travels: the pair is exempt no longer."""
    way = recording.centre["a2"]
    way[MIXED * PER_STEP : MIXED * PER_STEP + 10, 1] = 1.05
    verdict = verify(recording)
    assert ("a2", "o1") in {v.who for v in verdict.violations if v.kind == "clearance"}


def test_objects_collide(recording):
    recording.pose["o2"][during(CARRY), 4:6] = recording.pose["o1"][during(CARRY), 4:6] + [0.0, 2.7]
    verdict = verify(recording)
    assert ("o2", "o1 with a1 and a2") in {v.who for v in verdict.violations if v.kind == "clearance"}
    assert verdict.min_clearance["team_other"] == pytest.approx(-0.1)


def test_free_objects_collide(recording):
    recording.pose["o2"][during(RELEASE), 4:6] = [0.75, 0.0]
    verdict = verify(recording)
    assert ("o1", "o2") in {v.who for v in verdict.violations if v.kind == "clearance"}
    assert verdict.min_clearance["object_object"] == pytest.approx(-0.05)


def test_team_counts_as_one_sphere(recording):
    """a3 keeps away from both agents and the crate, but not from the team's sphere."""
    at = during(CARRY, 35, 40)
    recording.centre["a3"][at] = recording.pose["o1"][at, 4:] + [0.0, 2.9, 0.0]
    verdict = verify(recording)
    clearances = [v for v in verdict.violations if v.kind == "clearance"]
    assert [v.who for v in clearances] == [("a3", "o1 with a1 and a2")]
    assert clearances[0].worst == pytest.approx(0.2)


def test_nothing_slips_through_between_two_samples(recording):
    """a3 jumps over o2 and back within its region: no sample shows an overlap."""
    for step in range(2):
        recording.centre["a3"][during(step), 1] = 7.7
    verdict = verify(recording)
    assert only(verdict, "clearance").worst == pytest.approx(1.1)


def test_forbidden_region_on_the_way(recording):
    """a1 makes a detour through pi3; G !pi3 does not see it, the poses between the states do."""
    at = during(TRAVEL)
    recording.centre["a1"][at, 1] = 8.0
    recording.centre["a2"][at, 1] = 12.0
    verdict = verify(recording)
    violation = next(v for v in verdict.violations if v.kind == "forbidden_region")
    assert violation.who == ("a1", "pi3")
    assert kinds(verdict) == {"forbidden_region"}
    assert verdict.min_clearance["forbidden_region"] == -violation.worst < 0.0


def test_team_touches_a_region(recording):
    """The crate itself is 5 m away from the centre of pi3, and so outside; its team's sphere is not."""
    for way in (recording.centre["a1"], recording.centre["a2"], recording.pose["o1"][:, 4:]):
        way[during(CARRY, 40, 50), 1] += 5.0
    verdict = verify(recording)
    assert {v.who for v in verdict.violations if v.kind == "forbidden_region"} == {("o1 with a1 and a2", "pi3")}


def test_own_regions_are_not_forbidden(recording):
    assert verify(recording).min_clearance["forbidden_region"] > 0.0


def test_workspace_left(recording):
    recording.centre["a1"][during(TRAVEL), :2] = [5.0, -19.5]
    violation = only(verify(recording), "workspace")
    assert violation.who == ("a1",)
    assert violation.worst == pytest.approx(np.linalg.norm([5.0, 19.5, 0.2]) + 0.7 - 20.0)


# Grasps.


def grasped_wrongly(verdict: Verdict) -> Violation:
    """The one wrong grasp, by a gripper that is not there."""
    assert kinds(verdict) == {"grasp", "weld"}
    (violation,) = (v for v in verdict.violations if v.kind == "grasp")
    return violation


def test_weld_opened_in_a_transport(recording):
    recording.grasp[during(CARRY), 1] = NOTHING
    violation = only(verify(recording), "grasp")
    assert violation.who == ("a2",)
    assert (violation.step, violation.time) == (CARRY, pytest.approx(2.4))


def test_weld_opened_while_idle(recording):
    """a1 holds the crate while a2 lets it go."""
    recording.grasp[during(RELEASE), 0] = NOTHING
    assert only(verify(recording), "grasp").who == ("a1",)


def test_welded_to_the_wrong_object(recording):
    recording.grasp[during(CARRY), 1] = 1
    assert "o2 instead of o1" in grasped_wrongly(verify(recording)).what


def test_bystander_is_welded(recording):
    recording.grasp[during(CARRY), 2] = 0
    assert grasped_wrongly(verify(recording)).who == ("a3",)


def test_grasp_never_made(recording):
    recording.grasp[during(GRASP, 0, PER_STEP), 0] = NOTHING
    assert only(verify(recording), "grasp").what == "a1 has not grasped o1"


def test_release_never_made(recording):
    recording.grasp[during(RELEASE, 0, PER_STEP), 1] = 0
    assert grasped_wrongly(verify(recording)).what == "a2 has not released o1"


def test_grasp_that_flickers(recording):
    recording.grasp[during(GRASP, 10, 20), 0] = 0
    assert grasped_wrongly(verify(recording)).what == "a1 changes its grasp 3 times in one step"


def test_weld_gapes(recording):
    recording.centre["a2"][during(CARRY), 2] += 4e-3
    verdict = verify(recording)
    violation = only(verdict, "weld")
    assert (violation.who, violation.worst) == (("a2",), pytest.approx(4e-3))
    assert verdict.max_weld_error == violation.worst


def test_weld_turns(recording):
    """The crate, upright until then, turns away under both grippers: no joint can follow that."""
    half = np.deg2rad(0.6) / 2
    recording.pose["o1"][during(CARRY), :4] = [np.cos(half), 0.0, 0.0, np.sin(half)]
    verdict = verify(recording)
    turned = [v for v in verdict.violations if v.kind == "weld" and v.unit == "rad"]
    assert [v.worst for v in turned] == pytest.approx([np.deg2rad(0.6)] * 2)
    assert verdict.max_weld_angle == pytest.approx(np.deg2rad(0.6))


def test_weld_beside_the_ring(recording):
    """Held firmly, but where there is no handle."""
    hold = recording.grasp[:, 1] == 0
    recording.centre["a2"][hold, 1] += 0.01
    assert only(verify(recording), "weld").worst == pytest.approx(0.01, abs=3e-4)


def test_transport_by_others_than_the_holders(recording):
    """a2 still holds what a1 alone is said to carry."""
    wrong = dataclasses.replace(
        recording.steps[CARRY], actions=({**recording.steps[CARRY].actions[0], "agents": ["a1"]},)
    )
    steps = (*recording.steps[:CARRY], wrong, *recording.steps[CARRY + 1 :])
    verdict = verify(dataclasses.replace(recording, steps=steps))
    assert "o1 is carried by others than those that grasp it" in {v.what for v in verdict.violations}


# Objects, V, rest.


def test_object_moves_though_nobody_carries_it(recording):
    recording.pose["o2"][during(CARRY), 4] += 0.02
    violation = only(verify(recording), "object")
    assert (violation.who, violation.worst) == (("o2",), pytest.approx(0.02))


def test_object_creeps(recording):
    """2.5 mm in each step: little, but it adds up."""
    recording.pose["o2"][:, 4] += 0.0025 * recording.time
    assert only(verify(recording), "object").step > 1


def test_object_turns_though_nobody_carries_it(recording):
    half = np.deg2rad(3.0) / 2
    recording.pose["o2"][during(CARRY), :4] = [np.cos(half), 0.0, 0.0, np.sin(half)]
    violation = only(verify(recording), "object")
    assert violation.worst == pytest.approx(np.deg2rad(3.0))


def test_lyapunov_rises(recording):
    recording.lyapunov[during(CARRY)] += 3.0
    verdict = verify(recording)
    violation = only(verdict, "lyapunov")
    assert violation.step == CARRY
    assert verdict.max_lyapunov_increase == violation.worst == pytest.approx((3.0 - 79.9 / 49) / 80.0)


def test_lyapunov_creeps_up(recording):
    """Each sample alone would pass."""
    recording.lyapunov[during(CARRY, 0, PER_STEP)] = 80.0 * (1.0 + 5e-7 * np.arange(PER_STEP))
    assert only(verify(recording), "lyapunov").worst == pytest.approx(49 * 5e-7)


def with_phase_anew(recording: Recording, begin: int) -> Recording:
    """From a sample of the first step on there is another navigation function, with the same goals."""
    recording.phase[during(TRAVEL, begin, PER_STEP)] = 1
    recording.lyapunov[during(TRAVEL, begin, PER_STEP)] = 1e3
    again = dataclasses.replace(recording.intervals[0], phase=1)
    return dataclasses.replace(recording, intervals=(recording.intervals[0], again, *recording.intervals[1:]))


def test_lyapunov_may_jump_between_steps_and_phases(recording):
    assert verify(with_phase_anew(recording, 46)).satisfied


def test_lyapunov_begins_anew_on_the_way(recording):
    verdict = verify(with_phase_anew(recording, 30))
    assert {v.who for v in verdict.violations} == {("a1",), ("a2",)}
    assert all("V begins anew" in v.what for v in verdict.violations)


@pytest.mark.parametrize("name", ["a1", "a2"])
def test_mover_that_no_function_moves(recording, name):
    first, *others = recording.intervals
    travels = {mover: q for mover, q in first.travels.items() if mover != name}
    left_out = dataclasses.replace(recording, intervals=(dataclasses.replace(first, travels=travels), *others))
    violation = only(verify(left_out), "lyapunov")
    assert violation.who == (name,)
    assert "under no navigation function" in violation.what
    assert violation.worst > 8.0


@pytest.mark.parametrize(("index", "field", "name", "axis"), [(0, "travels", "a1", 0), (1, "transports", "o1", 2)])
def test_goal_that_is_never_reached(recording, index, field, name, axis):
    """Any way leads towards a goal that is far enough off."""
    changed = list(recording.intervals)
    goal = np.array(getattr(changed[index], field)[name])
    goal[axis] += 0.1
    goals = {**getattr(changed[index], field), name: tuple(goal.tolist())}
    changed[index] = dataclasses.replace(changed[index], **{field: goals})
    violation = only(verify(dataclasses.replace(recording, intervals=tuple(changed))), "lyapunov")
    assert (violation.who, violation.worst) == ((name,), pytest.approx(0.1))
    assert "has not reached the goal" in violation.what


@pytest.mark.parametrize(("is_drive", "turns", "reached"), [(True, 1, True), (False, 1, False), (True, 0.25, False)])
def test_joints_at_the_goal(recording, scenario, is_drive, turns, reached):
    """A heading is the same after a turn, an arm's joint is not."""
    a1, *others = scenario.agents
    changed = dataclasses.replace(scenario, agents=(dataclasses.replace(a1, has_arm=not is_drive), *others))
    x, y, *joints = recording.intervals[0].travels["a1"]
    goal = {**recording.intervals[0].travels, "a1": (x, y, joints[0] + turns * 2 * np.pi, *joints[1:])}
    run = dataclasses.replace(recording, intervals=(dataclasses.replace(recording.intervals[0], travels=goal),))
    free = {name: (np.full(4, -np.inf), np.full(4, np.inf)) for name in recording.agents}
    assert bool(list(arrival_violations(run, changed, step_spans(run), free))) != reached
    tight = free | {"a1": (np.full(4, -20.0), np.array([20.0, 20.0, 0.2, 20.0]))}
    assert any("limits" in v.what for v in arrival_violations(run, changed, step_spans(run), tight))


def test_touching_has_no_lyapunov_function(recording):
    recording.lyapunov[during(CARRY, 0, PER_STEP)] = TOUCHING
    assert "touches something" in only(verify(recording), "lyapunov").what


def test_v_that_is_no_number_hides_nothing(recording):
    """No comparison with it says that V rises, then or later."""
    spans, V = step_spans(recording), recording.lyapunov.copy()
    V[during(CARRY, 10, 11)] = np.nan
    V[during(CARRY)] += 1000.0
    rises = lyapunov_rises(recording, V, spans)
    assert rises[during(CARRY)].min() > 10.0
    found = list(lyapunov_violations(recording, V, spans, [Roles((), (), {}, frozenset())] * len(spans), rises))
    assert NO_VALUE in {v.what for v in found}


def test_movement_without_lyapunov_function(recording):
    recording.lyapunov[:] = 0.0
    assert kinds(verify(recording)) == {"lyapunov"}


@pytest.mark.parametrize("member", ["a1", "o1"])
def test_not_at_rest(recording, member):
    velocity = recording.qd[member] if member == "a1" else recording.velocity[member]
    velocity[(CARRY + 1) * PER_STEP] = 0.0
    velocity[(CARRY + 1) * PER_STEP, -1] = 0.1
    violation = only(verify(recording), "rest")
    assert (violation.who, violation.step, violation.worst) == ((member,), CARRY, 0.1)


# Formulas and the loop.


@pytest.mark.parametrize(
    ("old", "new", "who"),
    [
        ("GF pi1 & G !pi3", "G !pi1", ("a1",)),
        ("GF dock & GF pi3", "GF dock & FG !pi3", ("a2",)),
        ("GF pi1 & GF pi2", "FG pi1", ("o1",)),
        ("G(o1.pi1 -> F a2.pi3)", "F(o1.pi1 & G !a2.pi3)", ()),
        ("GF pi1 & G !pi3", "X X pi1", ("a1",)),  # positions count: it is there at first and after three steps
    ],
)
def test_formula_violated(recording, old, new, who):
    violation = only(verify(respecified(recording, old, new)), "formula")
    assert violation.who == who
    assert violation.time is None


def test_round_does_not_close(recording):
    """A suffix of six states would lead from the crate in pi2 to the crate in pi1, held."""
    verdict = verify(dataclasses.replace(recording, suffix_length=6))
    assert {v.who for v in verdict.violations if v.kind == "loop"} == {("a1",), ("a2",), ("o1",)}


def test_prefix_counts_as_well(recording):
    """One more state in the prefix, one less to go round: no longer closed, as grasps differ."""
    verdict = verify(dataclasses.replace(recording, prefix_length=2, suffix_length=7))
    assert "loop" in kinds(verdict)


# How it ended.


def test_early_stop(draw):
    """Safety of what happened is judged, nothing else is found wrong."""
    stopped = dataclasses.replace(draw(5), completed=False, reason="interrupted")
    violation = only(verify(stopped), "run")
    assert "interrupted" in str(violation)
    stopped.centre["a3"][during(GRASP), 1] -= 1.0
    assert kinds(verify(stopped)) == {"run", "clearance"}


def test_texts_that_a_terminal_would_obey(recording):
    """They might clear the screen, and write another verdict there."""
    from drake_ltl.monitoring.violation import Violation as Seen

    seen = Seen("weld\x1b[2J", 1.0, 0, ("a1",), "is open\x07", 1.0, unit="\x9b")
    spoilt = dataclasses.replace(recording, completed=False, reason="\x1b[2J\nSATISFIED", monitored=(seen,))
    lines = [str(v) for v in verify(spoilt).violations]
    assert all(line.isprintable() for line in lines)
    assert any(line.endswith(r"the run ended early: \x1b[2J\nSATISFIED") for line in lines)


def test_stop_in_the_midst_of_a_step(recording):
    """What the step was to reach is not asked for; what it must not touch is."""
    kept = _first_samples(recording, CARRY * PER_STEP + 25)
    stopped = dataclasses.replace(kept, completed=False, reason="step 3 did not finish within 300 s")
    assert only(verify(stopped), "run").step == CARRY
    assert len(verify(stopped).word) == 3


def test_less_than_one_round(draw):
    violation = only(verify(draw(8)), "run")
    assert violation.what.startswith("8 of the 9 steps")


def test_completed_in_the_midst_of_a_step(draw):
    whole = draw(17 + 1)
    last = dataclasses.replace(whole.steps[-1], finished=False, duration=0.98)
    cut = _first_samples(dataclasses.replace(whole, steps=(*whole.steps[:-1], last)), 18 * PER_STEP)
    assert only(verify(cut), "run").step == 17


def test_states_after_a_whole_round_are_judged_too(draw, scenario):
    """a1 is in pi3, where it may never be, half a round after the last whole one."""
    recording = draw(9 + 4)
    states = readings(recording, scenario, step_spans(recording))
    assert not list(word_violations(recording, scenario, states))
    states[11] = dataclasses.replace(states[11], letter=states[11].letter | {"a1.pi3"})
    assert {v.who for v in word_violations(recording, scenario, states)} == {("a1",)}


def test_stop_after_a_whole_round_is_still_a_stop(recording):
    assert only(verify(dataclasses.replace(recording, completed=False, reason="interrupted")), "run").worst is None


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_not_finite(recording, value):
    recording.qd["a2"][during(CARRY), 1] = value
    verdict = verify(recording)
    violation = next(v for v in verdict.violations if v.kind == "data")
    assert (violation.who, violation.step, violation.time) == (("qd of a2",), CARRY, pytest.approx(2.4))
    assert kinds(verdict) == {"data", "run"}  # what follows is not judged, so no round is seen
    assert np.isfinite(list(verdict.min_clearance.values())).all()


@pytest.mark.parametrize("value", [1e-200, 0.0, 2.0, 1e300])
def test_a_quaternion_that_is_none_ends_what_is_judged(recording, value):
    recording.pose["o1"][during(CARRY), :4] = [value, 0.0, 0.0, 0.0]
    assert kinds(verify(recording)) == {"data", "run"}


@pytest.mark.parametrize("field", ["q", "qd", "centre", "pose", "velocity"])
def test_numbers_that_are_too_large(recording, field):
    name = "o1" if field in ("pose", "velocity") else "a1"
    getattr(recording, field)[name][during(CARRY), -1] = 1e300
    verdict = verify(recording)
    violation = next(v for v in verdict.violations if v.kind == "data")
    assert violation.what == f"{field} of {name} is beyond 1e+06"
    assert kinds(verdict) == {"data", "run"}


def test_not_finite_from_the_start(recording):
    recording.lyapunov[0] = np.nan
    verdict = verify(recording)
    assert not verdict.satisfied
    assert kinds(verdict) == {"data"}


def test_no_samples(recording):
    nothing = dataclasses.replace(_first_samples(recording, 0), completed=False, reason="interrupted")
    assert kinds(verify(nothing)) == {"data", "run"}


@pytest.mark.parametrize("spoil", ["gap", "backwards", "thinned"])
def test_time(recording, spoil):
    if spoil == "gap":
        recording.time[200:] += 0.5
    elif spoil == "backwards":
        recording.time[200:] -= 0.5
    else:
        recording.time[:] *= 2.0
    assert only(verify(_recorded_anew(recording)), "data").who == ("time",)


def test_an_instant_logged_twice(recording):
    """Rounding can end an advance just before the sample that the next one begins with."""
    twice = _samples(recording, np.insert(np.arange(len(recording.time)), 120, 120))
    twice.time[120] -= 1e-14
    assert verify(twice).satisfied


def test_no_quaternion(recording):
    recording.pose["o2"][during(CARRY), :4] *= 2.0
    violation = next(v for v in verify(recording).violations if v.kind == "data")
    assert violation.who == ("o2",)


def _first_samples(recording: Recording, count: int) -> Recording:
    """The run as it stood after so many samples."""
    first = _samples(recording, np.arange(count))
    last = int(first.step[-1]) + 1 if count else 0
    intervals = tuple(interval for interval in recording.intervals if interval.step < last)
    return _recorded_anew(dataclasses.replace(first, steps=recording.steps[:last], intervals=intervals))


def _recorded_anew(recording: Recording) -> Recording:
    """Steps that begin and end with their samples."""
    steps = []
    for record in recording.steps:
        first, after = np.searchsorted(recording.step, [record.number, record.number + 1])
        finished = bool(after < len(recording.step))
        start, end = recording.time[first], recording.time[after if finished else -1]
        steps.append(dataclasses.replace(record, start=start, duration=end - start, finished=finished))
    return dataclasses.replace(recording, steps=tuple(steps))


def _samples(recording: Recording, rows: np.ndarray) -> Recording:
    """Copies of these samples."""
    fields = {}
    for field in dataclasses.fields(Recording):
        value = getattr(recording, field.name)
        if isinstance(value, np.ndarray):
            fields[field.name] = value[rows]
        elif field.name in ("q", "qd", "centre", "pose", "velocity"):
            fields[field.name] = {name: array[rows] for name, array in value.items()}
    return dataclasses.replace(recording, **fields)


# The start, powers, and what no machine can do.


def test_starts_elsewhere(recording):
    moved = respecified(recording, "- 10\n    - 11", "- 10\n    - 11.5")
    violation = only(verify(moved), "start")
    assert (violation.who, violation.worst) == (("a3",), pytest.approx(0.5))


def test_starts_turned_or_moving(recording):
    half = 0.1
    recording.pose["o2"][:, :4] = [np.cos(half), 0.0, 0.0, np.sin(half)]
    recording.qd["a3"][0, 0] = 0.3
    found = [v for v in verify(recording).violations if v.kind == "start"]
    assert {(v.who, round(v.worst, 9)) for v in found} == {(("o2",), 0.2), (("a3",), 0.3)}


def test_the_end_alone_is_no_run(recording):
    """As if all had been done when the recording begins."""
    last = _samples(recording, np.array([len(recording.time) - 1]))
    last = dataclasses.replace(last, steps=(), intervals=(), step=np.zeros(1, dtype=int))
    assert "start" in kinds(verify(dataclasses.replace(last, time=np.zeros(1))))


def test_team_too_weak(recording):
    weak = respecified(
        recording, "power_needed: 2\n    radius: 0.4\n    spec", "power_needed: 9\n    radius: 0.4\n    spec"
    )
    assert "too weak" in only(verify(weak), "action").what
    assert verify(weak, can_carry=lambda obj, team: len(team) == 2).satisfied


def test_faster_than_any_machine(recording):
    """There and back within one sample, with velocities to match."""
    sample = CARRY * PER_STEP + 20
    for arrays in (recording.q, recording.centre):
        arrays["a3"][sample, 0] += 1.5
    for k, sign in ((sample, 1.0), (sample + 1, -1.0)):
        recording.qd["a3"][k, 0] += sign * 1.5 / 0.02
    violation = only(verify(recording), "motion")
    assert (violation.who, violation.worst) == (("a3",), pytest.approx(75.0))


def test_many_samples_of_one_instant_do_not_add_up_to_a_way(recording):
    rows = np.insert(np.arange(len(recording.time)), 121, [120] * 40)
    twice = _samples(recording, rows)
    twice.time[121:161] = twice.time[120] + 1e-12 * np.arange(1, 41)
    for arrays in (twice.q, twice.centre):
        arrays["a3"][121:, 0] += np.minimum(np.arange(1, len(rows) - 120), 40) * 9e-7
    assert {v.kind for v in verify(twice).violations} >= {"motion"}


def test_drives_through_what_it_grasps(recording):
    recording.centre["a1"][during(GRASP), :2] = [9.2, -0.5]
    violation = only(verify(recording), "clearance")
    assert violation.who == ("a1", "o1")
    assert "nearer to o1 than where it holds it" in violation.what


def test_recordings_of_older_versions(recording):
    """The second version began without torques and manipulabilities; the first did not say what V is a function of."""
    verdict = verify(dataclasses.replace(recording, lacks=("effort", "manipulability")))
    assert verdict.satisfied
    assert verdict.max_effort == verdict.min_manipulability == {}
    oldest = dataclasses.replace(recording, intervals=(), lacks=("intervals", "effort", "manipulability"))
    assert "too old" in only(verify(oldest), "data").what
    oldest.lyapunov[during(TRAVEL)] += 50.0
    assert kinds(verify(oldest)) == {"data", "lyapunov"}
