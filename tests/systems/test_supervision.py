"""The rules by which a mission proceeds, on made-up measurements: nothing is simulated here."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from pydrake.math import RigidTransform

from drake_ltl.systems import detours
from drake_ltl.systems.detours import MOST_EXCHANGES, PASSED, PASSED_SPEED, STALL_TIME
from drake_ltl.systems.legs import ALL
from drake_ltl.systems.program import StepProgram, TravelTask
from drake_ltl.systems.progress import Measurement, Progress
from drake_ltl.systems.signals import NO_GRASP, Mode, Phase, reach_ends
from drake_ltl.systems.supervision import PATIENCE, Supervision

ONE_ROUND = 10
CARRY_O2, LET_GO, FIRST_GRASPS_AT_HAND = 2, 3, 6  # steps of case ii


@dataclass
class Puppets:
    """Bodies that are put where the supervisor wants them, and the supervisor that is told."""

    supervision: Supervision
    world: object
    progress: Progress | None = None
    time: float = 0.0
    applied: int = 0

    @property
    def now(self) -> Measurement:
        world = self.world
        return Measurement(self.time, dict(world.q), dict(world.qd), dict(world.X_WO), dict(world.V_WO))

    @property
    def step(self) -> StepProgram:
        return self.supervision.step(self.progress)

    def modes(self) -> dict[str, int]:
        return {name: signals.mode for name, signals in self.signals().items()}

    def signals(self) -> dict:
        return dict(zip(self.world.q, self.progress.agents, strict=True))

    def begin(self) -> Progress:
        self.progress = self.supervision.begin(self.now)
        return self.progress

    def look(self, after: float = 0.02) -> Progress:
        """The supervisor looks again, some time later."""
        self.time += after
        self.progress = self.supervision.advance(self.progress, self.applied, self.now)
        return self.progress

    def apply(self) -> None:
        self.applied = self.progress.revision

    def move(self, task) -> None:
        """A mover arrives at its goal; a team moves along."""
        if isinstance(task, TravelTask):
            self.world.q[task.agent] = task.q_goal.copy()
            return
        shift = task.p_goal - self.world.X_WO[task.object].translation()
        self.world.X_WO[task.object] = RigidTransform(np.array(task.p_goal))
        for name in task.team:
            self.world.q[name] = self.world.q[name] + np.array([*shift[:2], 0.0, 0.0])

    def finish_reaches(self) -> None:
        """Everybody who approaches or backs off gets there, and time passes."""
        signals = [(name, s) for name, s in self.signals().items() if s.mode == Mode.REACH]
        for name, s in signals:
            self.world.q[name] = reach_ends(s.reach)[1].copy()
        self.time = max([self.time, *(s.reach[0] + s.reach[1] for _, s in signals)])

    def obey(self) -> None:
        """All that the phase demands happens, welds are switched; then the supervisor looks."""
        if self.progress.phase is Phase.NAVIGATE:
            for task in (*self.step.travels, *self.step.transports):
                self.move(task)
        self.finish_reaches()
        self.apply()
        self.look()
        self.apply()

    def carry_out(self, count: int) -> None:
        """Goes on until that many steps are done."""
        for _ in range(10 * count):
            if self.progress.count >= count:
                return
            self.obey()
        raise AssertionError(f"stuck: {self.supervision.waiting_for(self.progress, self.now)}")


@pytest.fixture
def puppets(program, case_ii, models, mission, world_at):
    """puppets(num_steps, program=...): everybody at the start of case ii."""

    def make(num_steps: int = ONE_ROUND, program=program) -> Puppets:
        return Puppets(Supervision(program, case_ii, models, num_steps), world_at(mission.steps[0].before))

    return make


@pytest.fixture
def at_step(puppets):
    """at_step(count): the mission stands at the begin of this step."""

    def make(count: int, **options) -> Puppets:
        stage = puppets(**options)
        stage.begin()
        stage.carry_out(count)
        return stage

    return make


# Phases.


def test_a_mission_begins_with_its_first_step(puppets):
    stage = puppets()
    stage.time = 7.0
    progress = stage.begin()
    assert (progress.count, progress.phase, progress.revision, progress.interval) == (0, Phase.NAVIGATE, 0, 0)
    assert progress.step_start == 7.0
    assert stage.modes() == {"a1": Mode.HOLD, "a2": Mode.TRANSITION, "a3": Mode.TRANSITION}
    np.testing.assert_array_equal(stage.signals()["a1"].hold, stage.world.q["a1"])
    np.testing.assert_array_equal(progress.anchor, stage.world.anchor)


def test_nothing_changes_while_movers_are_on_their_way(puppets):
    stage = puppets()
    before = stage.begin()
    stage.world.qd["a2"] = np.array([1.0, 0.0, 0.0, 0.0])
    assert stage.look() is before


def test_a_step_ends_when_all_have_arrived(puppets):
    stage = puppets()
    stage.begin()
    first, second = stage.step.travels
    stage.move(first)
    stage.world.qd[second.agent] = np.array([1.0, 0.0, 0.0, 0.0])
    assert stage.look().count == 0
    stage.move(second)
    assert stage.look().count == 0  # it is there, but moves
    stage.world.qd[second.agent] = np.zeros(4)
    progress = stage.look()
    assert (progress.count, progress.phase, progress.interval) == (1, Phase.NAVIGATE, 0)
    assert progress.step_start == stage.time
    np.testing.assert_array_equal(progress.anchor, stage.world.anchor)


@pytest.mark.parametrize(("joint", "off", "there"), [(0, 0.029, True), (1, -0.031, False), (2, 0.031, False)])
def test_arrival_is_within_the_tolerances(puppets, joint, off, there):
    stage = puppets()
    stage.begin()
    for task in stage.step.travels:
        stage.move(task)
    stage.world.q["a2"][joint] += off
    assert (stage.look().count == 1) is there


def test_late_grasps_wait_for_every_mover(at_step):
    """In case ii's second step a1 travels while a2 and a3 drive to their stand-offs; then both grasp."""
    stage = at_step(1)
    assert stage.modes() == dict.fromkeys(("a1", "a2", "a3"), Mode.TRANSITION)
    for task in stage.step.travels:
        if task.agent != "a1":
            stage.move(task)
    stage.world.qd["a1"] = np.array([1.0, 0.0, 0.0, 0.0])
    assert stage.look().phase is Phase.NAVIGATE
    stage.world.qd["a1"] = np.zeros(4)
    stage.move(next(task for task in stage.step.travels if task.agent == "a1"))
    progress = stage.look()
    assert (progress.count, progress.phase, progress.interval) == (1, Phase.REACH, 1)
    assert stage.modes() == {"a1": Mode.HOLD, "a2": Mode.REACH, "a3": Mode.REACH}
    assert all(s.grasp == NO_GRASP for s in progress.agents)


def test_grasps_at_hand_begin_at_once(at_step):
    stage = at_step(FIRST_GRASPS_AT_HAND)
    assert stage.progress.phase is Phase.NAVIGATE
    assert stage.modes() == {"a1": Mode.REACH, "a2": Mode.HOLD, "a3": Mode.REACH}


def test_a_team_carries_under_the_controller_of_its_object(at_step):
    stage = at_step(CARRY_O2)
    assert stage.modes() == {"a1": Mode.HOLD, "a2": Mode.TRANSPORT + 1, "a3": Mode.TRANSPORT + 1}


@pytest.mark.parametrize("num_steps", [0, 1, 4, ONE_ROUND, ONE_ROUND + 3])
def test_the_mission_ends_after_so_many_steps(puppets, program, num_steps):
    """... and then holds for ever; after the last step comes the first of the loop."""
    stage = puppets(num_steps)
    stage.begin()
    done = []
    while stage.progress.phase is not Phase.DONE:
        if stage.progress.count == len(done):
            done.append(stage.step.actions)
        stage.obey()
        assert len(done) <= num_steps
    assert done == [program.steps[k if k < 10 else 8 + (k - 8) % 2].actions for k in range(num_steps)]
    assert set(stage.modes().values()) == {Mode.HOLD}
    assert stage.supervision.waiting_for(stage.progress, stage.now) == []
    assert stage.look(100.0) is stage.look(1.0)


def test_a_negative_number_of_steps_is_refused(puppets):
    with pytest.raises(ValueError, match="-1"):
        puppets(-1)


def test_what_is_held_is_what_the_plan_says(puppets, program, mission):
    """After each step, the commanded welds are the grasps of the plan's state."""
    stage = puppets()
    stage.begin()
    for count, placed in enumerate(mission.steps, start=1):
        stage.carry_out(count)
        welds = {name: s.grasp for name, s in stage.signals().items() if s.grasp != NO_GRASP}
        if stage.step.releases and stage.progress.phase is Phase.NAVIGATE:
            welds |= {task.weld.agent: program.welds.index(task.weld) for task in stage.step.releases}
        held = {name: (program.welds[k].object, program.welds[k].option) for name, k in welds.items()}
        assert held == {name: s.grasp for name, s in placed.after.agents.items() if s.grasp is not None}


# Grasps.


def approaching(at_step) -> Puppets:
    """a1 and a3 at the end of their approaches to o1."""
    stage = at_step(FIRST_GRASPS_AT_HAND)
    stage.finish_reaches()
    return stage


def test_welds_are_commanded_where_the_gripper_fits(at_step, program):
    stage = approaching(at_step)
    revision = stage.progress.revision
    stage.look()
    grasps = {name: s.grasp for name, s in stage.signals().items() if name != "a2"}
    assert {program.welds[k].agent for k in grasps.values()} == {"a1", "a3"}
    assert {program.welds[k].object for k in grasps.values()} == {"o1"}
    assert stage.progress.revision > revision
    waiting = stage.progress
    assert stage.look() is waiting  # until the welds are applied
    stage.apply()
    assert stage.look().count == FIRST_GRASPS_AT_HAND + 1


@pytest.mark.parametrize(("joint", "off"), [(0, 2e-3), (1, -2e-3), (2, 2e-3)])
def test_no_weld_is_commanded_over_a_gap(at_step, joint, off):
    stage = approaching(at_step)
    stage.world.q["a1"][joint] += off
    stage.world.q["a3"][0] += 0.1
    revision = stage.progress.revision
    stage.look()
    assert stage.signals()["a1"].grasp == NO_GRASP
    assert stage.progress.revision == revision
    assert any("a1 is still grasping o1" in text for text in stage.supervision.waiting_for(stage.progress, stage.now))


def test_no_weld_is_commanded_in_motion(at_step):
    stage = approaching(at_step)
    stage.world.qd["a1"][0] = 0.01
    stage.look()
    assert stage.signals()["a1"].grasp == NO_GRASP
    assert stage.signals()["a3"].grasp != NO_GRASP


def test_no_weld_is_commanded_before_the_approach_has_ended(at_step):
    stage = approaching(at_step)
    stage.time -= 0.5
    stage.look()
    assert stage.signals()["a1"].grasp == NO_GRASP


def test_a_missed_approach_is_not_corrected_while_others_are_on_their_way(at_step, program):
    """V would begin anew with them."""
    stage = approaching(at_step)
    X = stage.world.X_WO["o1"]
    stage.world.X_WO["o1"] = RigidTransform(X.rotation(), X.translation() + np.array([0.004, 0.003, 0.0]))
    (task,) = (task for task in program.steps[0].travels if task.agent == "a2")
    steps = list(program.steps)
    steps[FIRST_GRASPS_AT_HAND] = replace(
        steps[FIRST_GRASPS_AT_HAND], travels=(replace(task, q_goal=task.q_goal + 9.0),)
    )
    stage.supervision.program = replace(program, steps=tuple(steps))
    first, interval = stage.signals()["a1"].reach, stage.progress.interval
    stage.world.qd["a2"][0] = 0.3
    stage.look(2.0 * PATIENCE)
    np.testing.assert_array_equal(stage.signals()["a1"].reach, first)
    assert stage.progress.interval == interval
    stage.world.qd["a2"][0] = 0.0
    stage.look()
    assert stage.progress.interval > interval


def test_a_missed_approach_is_corrected(at_step, models):
    """The object was pushed away by 5 mm meanwhile: a second approach aims at where it is now."""
    stage = approaching(at_step)
    X = stage.world.X_WO["o1"]
    stage.world.X_WO["o1"] = RigidTransform(X.rotation(), X.translation() + np.array([0.004, 0.003, 0.0]))
    first, interval = stage.signals()["a1"].reach, stage.progress.interval
    stage.look(PATIENCE / 2)
    np.testing.assert_array_equal(stage.signals()["a1"].reach, first)
    stage.look(PATIENCE)
    second = stage.signals()["a1"].reach
    assert second[0] == stage.time
    start, goal = reach_ends(second)
    np.testing.assert_array_equal(start, stage.world.q["a1"])
    np.testing.assert_allclose(goal - reach_ends(first)[1], [0.004, 0.003, 0.0, 0.0], atol=1e-12)
    assert stage.progress.interval > interval  # others travel around another way of a1 now
    np.testing.assert_array_equal(stage.progress.anchor, stage.world.anchor)
    stage.finish_reaches()
    stage.look()
    assert stage.signals()["a1"].grasp != NO_GRASP


def test_a_release_lets_go_at_once_and_backs_off(at_step):
    stage = at_step(LET_GO)
    (task,) = stage.step.releases
    assert stage.modes() == {"a1": Mode.HOLD, "a2": Mode.HOLD, "a3": Mode.REACH}
    signals = stage.signals()["a3"]
    assert signals.grasp == NO_GRASP
    assert stage.signals()["a2"].grasp != NO_GRASP
    start, goal = reach_ends(signals.reach)
    np.testing.assert_allclose(goal - start, [*task.retreat, 0.0, 0.0], atol=1e-12)
    stage.finish_reaches()
    stage.world.q["a3"][0] += 0.003
    assert stage.look().count == LET_GO
    assert stage.supervision.waiting_for(stage.progress, stage.now) == ["a3 is still releasing o2"]
    stage.world.q["a3"][0] -= 0.003
    assert stage.look().count == LET_GO + 1


def test_a_release_ends_at_rest(at_step, case_ii):
    stage = at_step(LET_GO)
    stage.finish_reaches()
    stage.world.qd["a3"][1] = 2.0 * case_ii.tolerances.speed
    assert stage.look().count == LET_GO
    stage.world.qd["a3"][1] = 0.0
    assert stage.look().count == LET_GO + 1


@pytest.mark.parametrize(("who", "joint"), [("a2", 2), ("a3", 0), ("o2", 3)])
def test_a_transport_ends_with_object_and_team_at_rest(at_step, case_ii, who, joint):
    stage = at_step(CARRY_O2)
    for task in stage.step.transports:
        stage.move(task)
    velocity = stage.world.qd[who] if who in stage.world.qd else stage.world.V_WO[who]
    velocity[joint] = 2.0 * case_ii.tolerances.speed
    assert stage.look().count == CARRY_O2
    velocity[joint] = 0.0
    assert stage.look().count == LET_GO


def test_releases_are_a_revision_of_grasps(puppets):
    stage = puppets()
    stage.begin()
    stage.carry_out(CARRY_O2)
    for task in stage.step.transports:
        stage.move(task)
    before = stage.progress.revision
    progress = stage.look()
    assert progress.count == LET_GO
    assert progress.revision == before + 1
    assert stage.look(5.0) is progress  # nothing goes on until the weld is off
    stage.apply()
    stage.finish_reaches()
    assert stage.look().count == LET_GO + 1


# Texts.


def test_waiting_for_travellers(puppets):
    stage = puppets()
    stage.begin()
    (task,) = (task for task in stage.step.travels if task.agent == "a3")
    stage.move(task)
    texts = stage.supervision.waiting_for(stage.progress, stage.now)
    assert len(texts) == 1
    assert texts[0].startswith("a2 is 2")  # some 20 m
    assert "from its place in pi1 (speed 0.00 m/s)" in texts[0]


def test_waiting_for_a_team(at_step):
    stage = at_step(CARRY_O2)
    (text,) = stage.supervision.waiting_for(stage.progress, stage.now)
    assert text.startswith("o2 (carried by a2, a3) is 2")
    assert "from its place in pi3" in text


def test_waiting_for_a_grasp_says_how_far_off_it_is(at_step):
    stage = approaching(at_step)
    stage.world.q["a1"][0] += 2e-3
    texts = stage.supervision.waiting_for(stage.progress, stage.now)
    assert texts[0] == "a1 is still grasping o1 (2.0 mm and 0.00 degrees off)"


# Shares.


def test_shares_are_those_of_the_team_while_it_carries(at_step):
    stage = at_step(CARRY_O2)
    np.testing.assert_allclose(stage.supervision.shares(stage.progress, "o2"), [0, 4 / 7, 3 / 7])
    np.testing.assert_array_equal(stage.supervision.shares(stage.progress, "o1"), np.zeros(3))
    at_rest = replace(stage.progress, phase=Phase.REACH)
    np.testing.assert_array_equal(stage.supervision.shares(at_rest, "o2"), np.zeros(3))


def test_a_team_that_waits_for_its_turn_shares_nothing(at_step, program):
    stage = at_step(CARRY_O2)
    other = replace(stage.progress, active=5)  # somebody else is on the way alone
    stage.supervision.program = replace(program, steps=_with_travels(program, 5))
    np.testing.assert_array_equal(stage.supervision.shares(other, "o2"), np.zeros(3))


def _with_travels(program, number: int):
    """Step 2 with that many travels ahead of its transport; only how many there are counts."""
    (task,) = (task for task in program.steps[0].travels if task.agent == "a2")
    step = replace(program.steps[CARRY_O2], travels=(task,) * (number + 1))
    return (*program.steps[:CARRY_O2], step, *program.steps[CARRY_O2 + 1 :])


# Movers that stop short of their goals.

BETWEEN = {"a2": (10.0, -5.0), "a3": (5.0, -2.5)}
"""Where they got stuck: a3 in the way of a2 to pi1."""


def stalled(puppets, models) -> Puppets:
    """Step 0, both travellers at rest for as long as the supervisor's patience lasts."""
    stage = puppets()
    stage.begin()
    for name, place in BETWEEN.items():
        stand(stage, models, name, place)
    stage.look()
    return stage


def stand(stage, models, name: str, place) -> None:
    q = stage.world.q[name].copy()
    q[:2] += np.array(place) - models.agents[name].centre(q)[:2]
    stage.world.q[name] = q


def test_movers_may_rest_for_a_while(puppets, models):
    stage = stalled(puppets, models)
    assert stage.look(STALL_TIME - 0.1).active == ALL
    stage.world.qd["a3"][1] = 0.05
    assert stage.look().slow_since == np.inf  # it goes on
    stage.world.qd["a3"][1] = 0.0
    stage.look()
    assert stage.look(STALL_TIME - 0.1).active == ALL


def test_after_a_stall_they_go_one_by_one(puppets, models):
    stage = stalled(puppets, models)
    first = stage.look(STALL_TIME + 0.1)
    assert (first.active, first.interval, first.phase) == (0, 1, Phase.NAVIGATE)
    assert stage.modes() == {"a1": Mode.HOLD, "a2": Mode.TRANSITION, "a3": Mode.HOLD}
    np.testing.assert_array_equal(stage.signals()["a3"].hold, stage.world.q["a3"])
    np.testing.assert_array_equal(first.anchor, stage.world.anchor)
    assert first.way  # a3 stands between a2 and its goal
    assert first.leg.via == first.way[0]


def test_each_way_point_begins_an_interval(puppets, models):
    stage = stalled(puppets, models)
    progress = stage.look(STALL_TIME + 0.1)
    number = len(progress.way)
    for passed, point in enumerate(progress.way, start=1):
        stage.world.qd["a2"][0] = 1.0
        stand(stage, models, "a2", np.array(point) + np.array([2 * PASSED, 0.0]))
        assert len(stage.look().way) == number - passed + 1
        stand(stage, models, "a2", np.array(point) + np.array([0.5 * PASSED, 0.0]))
        if passed == number:  # the last one only counts when it is passed slowly
            assert len(stage.look().way) == 1
            stage.world.qd["a2"][0] = 0.5 * PASSED_SPEED
        progress = stage.look()
        assert (progress.interval, len(progress.way)) == (1 + passed, number - passed)
        np.testing.assert_array_equal(progress.anchor, stage.world.anchor)
    assert progress.leg.via is None


def test_then_the_next_one_goes_and_the_step_ends(puppets, models):
    stage = stalled(puppets, models)
    stage.look(STALL_TIME + 0.1)
    stage.progress = replace(stage.progress, way=())
    first, second = stage.step.travels
    stage.move(first)
    progress = stage.look()
    assert progress.active == 1
    assert stage.modes() == {"a1": Mode.HOLD, "a2": Mode.HOLD, "a3": Mode.TRANSITION}
    np.testing.assert_array_equal(stage.signals()["a2"].hold, first.q_goal)
    stage.progress = replace(progress, way=())
    stage.move(second)
    progress = stage.look()
    assert (progress.count, progress.active, progress.way, progress.interval) == (1, ALL, (), 0)


def test_a_mover_whose_goal_is_taken_waits_for_the_other(puppets, models):
    """a3 stands where a2 is to go: a3 goes first."""
    stage = stalled(puppets, models)
    (task,) = (task for task in stage.step.travels if task.agent == "a2")
    stand(stage, models, "a3", models.agents["a2"].centre(task.q_goal)[:2])
    assert stage.look(STALL_TIME + 0.1).active == 1


def test_all_wait_where_nobody_can_go(puppets, models, monkeypatch):
    """Both stand where the other is to go, have exchanged places too often, and there is nowhere to get out of the
    way; all that is done is to look later."""
    monkeypatch.setattr(detours, "evasion", lambda evader, barred: None)
    stage = stalled(puppets, models)
    stage.progress = replace(stage.progress, exchanges=MOST_EXCHANGES)
    goals = {task.agent: models.agents[task.agent].centre(task.q_goal)[:2] for task in stage.step.travels}
    stand(stage, models, "a2", goals["a3"])
    stand(stage, models, "a3", goals["a2"])
    progress = stage.look(STALL_TIME + 0.1)
    assert (progress.active, progress.interval, progress.slow_since) == (ALL, 0, stage.time)
    assert stage.modes() == {"a1": Mode.HOLD, "a2": Mode.TRANSITION, "a3": Mode.TRANSITION}


def test_all_go_at_once_again_where_one_that_went_alone_bars_the_way(puppets, models, monkeypatch):
    """a2 is on its way alone and stalls; both stand where the other is to go, and nobody can get out of the way."""
    monkeypatch.setattr(detours, "evasion", lambda evader, barred: None)
    stage = stalled(puppets, models)
    stage.progress = replace(stage.progress, exchanges=MOST_EXCHANGES)
    stage.look(STALL_TIME + 0.1)
    goals = {task.agent: models.agents[task.agent].centre(task.q_goal)[:2] for task in stage.step.travels}
    stand(stage, models, "a2", goals["a3"])
    stand(stage, models, "a3", goals["a2"])
    stage.progress = replace(stage.progress, way=())
    before = stage.look()
    assert before.active == 0
    progress = stage.look(STALL_TIME + 0.1)
    assert (progress.active, progress.way, progress.interval) == (ALL, (), before.interval + 1)
    assert progress.slow_since == np.inf
    assert stage.modes() == {"a1": Mode.HOLD, "a2": Mode.TRANSITION, "a3": Mode.TRANSITION}
    np.testing.assert_array_equal(progress.anchor, stage.world.anchor)


def test_a_mover_that_stalls_alone_lets_the_next_one_try(puppets, models):
    stage = stalled(puppets, models)
    stage.look(STALL_TIME + 0.1)
    stage.look()
    assert stage.look(STALL_TIME + 0.1).active == 1


def test_nobody_counts_as_stalled_while_others_reach(at_step, program):
    """Agents that grasp or release may free the way."""
    (task,) = (task for task in program.steps[0].travels if task.agent == "a2")
    step = replace(program.steps[FIRST_GRASPS_AT_HAND], travels=(replace(task, q_goal=task.q_goal + 9.0),))
    steps = list(program.steps)
    steps[FIRST_GRASPS_AT_HAND] = step
    stage = at_step(FIRST_GRASPS_AT_HAND, program=replace(program, steps=tuple(steps)))
    before = stage.progress
    assert stage.look() is before  # no count of seconds begins


# Who only holds comes to rest, too.


def test_a_step_does_not_end_while_an_idle_robot_moves(puppets):
    stage = puppets()
    stage.begin()
    for task in stage.step.travels:
        stage.move(task)
    stage.world.qd["a1"] = np.array([0.0, 0.0, 0.0, 0.05])  # verdicts bear 0.06
    assert stage.look().count == 0
    assert stage.supervision.waiting_for(stage.progress, stage.now) == ["a1 has not come to rest"]
    stage.world.qd["a1"] = np.array([0.0, 0.0, 0.0, 0.04])
    assert stage.look().count == 1


def test_nobody_waits_for_who_is_out_of_service(puppets, program, case_ii, models):
    stage = puppets()
    stage.supervision = Supervision(program, case_ii, models, ONE_ROUND, ignored=frozenset({"a1"}))
    stage.begin()
    for task in stage.step.travels:
        stage.move(task)
    stage.world.qd["a1"] = np.array([3.0, 0.0, 0.0, 0.0])
    assert stage.look().count == 1


def test_a_step_does_not_end_while_what_is_held_falls(puppets, program):
    """What was carried a millimetre above the floor falls on it when its team holds."""
    stage = puppets()
    stage.begin()
    for task in stage.step.travels:
        stage.move(task)
    weld = next(index for index, weld in enumerate(program.welds) if weld.agent == "a1")
    stage.progress = stage.progress.with_agent(0, grasp=weld)
    held = program.welds[weld].object
    stage.world.V_WO[held] = np.array([0.0, 0.0, 0.0, 0.0, 0.0, -0.05])
    assert stage.look().count == 0
    assert stage.supervision.waiting_for(stage.progress, stage.now) == [f"{held} has not come to rest"]
