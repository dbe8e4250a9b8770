"""Travellers that take each other's places: which may, and who goes where."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations
from math import factorial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_ltl.mission import measure, plan_and_place
from drake_ltl.scenario import loads
from drake_ltl.systems.detours import MOST_EXCHANGES, STALL_TIME
from drake_ltl.systems.exchange import (
    MOST_TRAVELLERS,
    alike_travels,
    better_rank,
    exchanged,
    order_of,
    rank_of,
)
from drake_ltl.systems.legs import ALL
from drake_ltl.systems.preflight import snapshot
from drake_ltl.systems.program import mission_program
from drake_ltl.systems.progress import Measurement
from drake_ltl.systems.signals import Mode
from drake_ltl.systems.supervision import Supervision

GATHERING = """
name: gathering
workspace: {radius: 30}
regions:
  out: {centre: [-10, 0, 0], radius: 9.0}
  mid: {centre: [12, 0, 0], radius: 5.0}
agents:
  a1: {model: "package://drake_ltl_models/agents/planar_arm.urdf", position: [-6, 0], radius: 1.25}
  a2: {model: "package://drake_ltl_models/agents/planar_arm.urdf", position: [-10, 4], radius: 1.25}
  a3: {model: "package://drake_ltl_models/agents/planar_arm.urdf", position: [-10, -4], radius: 1.25}
objects: {}
spec: "F(a1.mid & a2.mid & a3.mid)"
"""


@pytest.fixture(scope="module")
def gathering():
    """Scenario, models, placed mission and program: three travel in the first step, and stay for ever."""
    scenario = loads(GATHERING)
    models = measure(scenario)
    mission = plan_and_place(scenario, models)
    return scenario, models, mission, mission_program(mission, models, scenario)


def places(step, models):
    return np.array([models.agents[task.agent].centre(task.q_goal) for task in step.travels])


@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_ranks_number_all_permutations_in_order(n):
    found = [tuple(order_of(rank, n)) for rank in range(factorial(n))]
    assert found == list(permutations(range(n)))
    assert [rank_of(order) for order in found] == list(range(factorial(n)))


def test_the_largest_rank_is_a_number_that_signals_hold():
    largest = factorial(MOST_TRAVELLERS) - 1
    assert int(float(largest)) == largest
    assert rank_of(order_of(largest, MOST_TRAVELLERS)) == largest


def test_whoever_leaves_a_region_for_ever_alike_may_exchange_places(gathering):
    _, models, _, program = gathering
    assert alike_travels(program, 0, models) == [(0, 1, 2)]


def test_who_is_to_grasp_from_where_it_stands_keeps_its_place(program, models):
    """In case ii a2 and a3 travel to pi1, and in the next step first to their stand-offs."""
    assert {task.agent for task in program.steps[0].travels} == {"a2", "a3"}
    assert alike_travels(program, 0, models) == [(0, 1)]
    assert alike_travels(program, 1, models) == []  # three travel: one elsewhere, two to stand-offs
    drives, late = program.steps[1].travels, program.steps[1].late_grasps
    at_hand = replace(program.steps[1], travels=drives[:1], grasps=late, late_grasps=())
    there_already = replace(program, steps=(program.steps[0], at_hand, *program.steps[2:]))
    assert alike_travels(there_already, 0, models) == []
    assert better_rank(there_already, 0, 0, models, [np.zeros(3), np.ones(3)]) is None


def test_spheres_of_different_sizes_and_stays_of_different_lengths_are_not_alike(gathering):
    _, models, _, program = gathering
    radii = dict(models.geometry.agent_radius) | {"a2": 1.3}
    other = replace(models, geometry=replace(models.geometry, agent_radius=radii))
    assert alike_travels(program, 0, other) == [(0, 2)]
    leaving = replace(program.steps[0].actions[0], agents=("a3",))
    back = replace(program.steps[0], actions=(leaving,), travels=program.steps[0].travels[2:])
    longer = replace(program, steps=(program.steps[0], back), loop=1)
    assert alike_travels(longer, 0, models) == [(0, 1)]
    still = replace(program.steps[0], actions=(), travels=())
    assert alike_travels(replace(program, steps=(program.steps[0], still), loop=1), 0, models) == [(0, 1, 2)]


def test_exchanged_travellers_stand_in_the_same_places_with_their_own_postures(gathering):
    _, models, _, program = gathering
    step = program.steps[0]
    assert exchanged(step, 0, models) is step
    for rank in range(1, 6):
        moved, order = exchanged(step, rank, models), order_of(rank, 3)
        np.testing.assert_allclose(places(moved, models), places(step, models)[order], atol=1e-12)
        for task, before in zip(moved.travels, step.travels, strict=True):
            np.testing.assert_array_equal(task.q_goal[2:], before.q_goal[2:])
            assert (task.agent, task.start, task.goal) == (before.agent, before.start, before.goal)


@settings(max_examples=30)
@given(st.lists(st.tuples(st.floats(5, 19), st.floats(-7, 7)), min_size=3, max_size=3), st.integers(0, 5))
def test_the_exchange_is_the_one_with_the_least_sum_of_squares(gathering, here, rank):
    """Against all permutations; and none is proposed that gains nothing."""
    _, models, _, program = gathering
    there = places(program.steps[0], models)[:, :2]
    centres = np.column_stack([here, np.ones(3)])
    found = better_rank(program, 0, rank, models, list(centres))

    def squares(number):
        return float(((centres[:, :2] - there[order_of(number, 3)]) ** 2).sum())

    least = min(map(squares, range(6)))
    if found is None:
        assert squares(rank) <= least + 0.1 + 1e-9
    else:
        assert squares(found) == pytest.approx(least)
        assert squares(found) < squares(rank) - 0.1


class Stage:
    """Travellers at rest where they are put, and the supervision that looks at them."""

    def __init__(self, gathering):
        scenario, self.models, mission, program = gathering
        self.supervision = Supervision(program, scenario, self.models, num_steps=1)
        self.q = {name: q.copy() for name, q in snapshot(mission.steps[0].before, self.models).q.items()}
        self.time = 0.0
        self.progress = self.supervision.begin(self.now)

    @property
    def now(self):
        return Measurement(self.time, dict(self.q), {name: np.zeros_like(q) for name, q in self.q.items()}, {}, {})

    def put(self, agent, p):
        self.q[agent][:2] += np.asarray(p)[:2] - self.models.agents[agent].centre(self.q[agent])[:2]

    def stall(self):
        """Nobody moves until a stall is noticed."""
        for after in (0.02, STALL_TIME + 0.1):
            self.time += after
            self.progress = self.supervision.advance(self.progress, 0, self.now)
        return self.progress


def barred(gathering):
    """a1 stands in its place and bars the way of a2, whose place lies behind; a3 has arrived."""
    stage = Stage(gathering)
    first, second, third = places(stage.supervision.step(stage.progress), stage.models)
    stage.put("a1", first)
    stage.put("a3", third)
    stage.put("a2", first + 1.1 * (first - second))
    return stage, first, second


def test_who_bars_a_way_moves_on_to_the_place_behind(gathering):
    stage, first, second = barred(gathering)
    before = stage.progress
    progress = stage.stall()
    assert (progress.active, progress.interval, progress.exchanges) == (ALL, before.interval + 1, 1)
    np.testing.assert_array_equal(progress.anchor, stage.now.anchor)
    assert {signals.mode for signals in progress.agents} == {Mode.TRANSITION}
    now = places(stage.supervision.step(progress), stage.models)
    np.testing.assert_allclose(now[:2], [second, first], atol=1e-12)
    assert progress.leg.exchange == progress.exchange == rank_of([1, 0, 2])


def test_the_step_ends_at_exchanged_places_and_the_next_one_begins_with_its_own(gathering):
    stage, _, _ = barred(gathering)
    step = stage.supervision.step(stage.stall())
    for task in step.travels:
        stage.q[task.agent] = task.q_goal.copy()
    stage.time += 0.02
    progress = stage.supervision.advance(stage.progress, 0, stage.now)
    assert progress.count == 1


def test_who_stands_where_another_is_to_go_stays_there(gathering):
    """Nobody could go alone."""
    stage = Stage(gathering)
    there = places(stage.supervision.step(stage.progress), stage.models)
    for name, place in zip(("a1", "a2", "a3"), there[[1, 2, 0]], strict=True):
        stage.put(name, place)
        stage.q[name][2:] = stage.supervision.step(stage.progress).travels[0].q_goal[2:]
    assert stage.stall().exchange == rank_of([1, 2, 0])
    stage.time += 0.02
    assert stage.supervision.advance(stage.progress, 0, stage.now).count == 1


def test_where_an_exchange_changes_nothing_they_go_one_by_one(gathering):
    stage, _, _ = barred(gathering)
    first = stage.stall()
    assert stage.stall().active != ALL
    assert stage.progress.exchange == first.exchange


def test_after_so_many_exchanges_they_go_one_by_one(gathering):
    stage, _, _ = barred(gathering)
    stage.progress = replace(stage.progress, exchanges=MOST_EXCHANGES)
    assert stage.stall().active != ALL


def test_who_bars_another_lets_it_by_and_follows(gathering):
    """Two stand in each other's places, and may exchange these no more."""
    stage = Stage(gathering)
    there = places(stage.supervision.step(stage.progress), stage.models)
    tasks = stage.supervision.step(stage.progress).travels
    for task, place in zip(tasks, there[[1, 0, 2]], strict=True):
        stage.q[task.agent][2:] = task.q_goal[2:]
        stage.put(task.agent, place)
    stage.progress = replace(stage.progress, exchanges=MOST_EXCHANGES)
    progress = stage.stall()
    evader, barred = progress.active, progress.lets_by
    assert {evader, barred} == {0, 1}
    assert np.linalg.norm(np.array(progress.way[-1]) - there[evader][:2]) > 1.25
    for _ in progress.way:
        stage.put(tasks[evader].agent, stage.progress.way[0])
        stage.time += 0.02
        stage.progress = stage.supervision.advance(stage.progress, 0, stage.now)
    assert (stage.progress.active, stage.progress.lets_by) == (barred, ALL)
    modes = [signals.mode for signals in stage.progress.agents]
    assert [modes[barred], modes[evader]] == [Mode.TRANSITION, Mode.HOLD]
    stage.progress = replace(stage.progress, way=())
    stage.put(tasks[barred].agent, there[barred])
    stage.time += 0.02
    stage.progress = stage.supervision.advance(stage.progress, 0, stage.now)
    assert (stage.progress.active, stage.progress.lets_by) == (evader, ALL)
