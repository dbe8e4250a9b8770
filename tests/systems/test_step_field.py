"""The relations of a step as the bodies stand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from drake_ltl.errors import InvalidInputError
from drake_ltl.navigation.shaping import gathering_exponent
from drake_ltl.systems.legs import Leg, Moving, moving_tasks
from drake_ltl.systems.step_field import KAPPA_PER_FACTOR, FieldBuilder, Snapshot

TRAVEL, TRANSPORT = 0, 2  # steps of case ii


@pytest.fixture(scope="module")
def builder(case_ii, models) -> FieldBuilder:
    return FieldBuilder(case_ii, models)


@pytest.fixture(scope="module")
def snapshot_at(mission, world_at):
    def make(step: int) -> Snapshot:
        world = world_at(mission.steps[step].before)
        return Snapshot(world.q, {name: X.translation() for name, X in world.X_WO.items()})

    return make


def radius_to(relations, mover: str, other: str) -> float:
    """Sum of radii in the relation between two points."""
    a, b = relations.index(mover), relations.index(other)
    (apart,) = (apart for apart in relations.relations.apart if {apart.a, apart.b} == {a, b})
    return apart.radius


shifts = arrays(float, 2, elements=st.floats(-1.0, 1.0))
directions = arrays(float, 3, elements=st.floats(-1.0, 1.0)).filter(lambda d: np.linalg.norm(d) > 1e-3)


@given(shift=shifts, share=st.floats(0.0, 1.0), direction=directions, depth=st.floats(0.0, 1.0))
def test_both_ends_of_a_reach_cover_its_way(builder, program, snapshot_at, models, shift, share, direction, depth):
    """Any point of the agent's sphere anywhere on its straight way lies in one of the two spheres that stand for it."""
    step, snapshot = program.steps[TRAVEL], snapshot_at(TRAVEL)
    q = snapshot.q["a1"]
    ends = (q, q + np.array([*shift, 0.0, 0.0]))
    relations = builder.relations(Moving(step.travels, (), ()), snapshot, {"a1": ends})
    centres = [models.agents["a1"].centre(q) for q in ends]
    r = models.geometry.agent_radius
    point = centres[0] + share * (centres[1] - centres[0])
    point = point + depth * r["a1"] * direction / np.linalg.norm(direction)
    spheres = ["a1 at the stand-off", "a1 at the grasp"]
    covered = [
        np.linalg.norm(point - centre) <= radius_to(relations, "a2", name) - r["a2"] + 1e-9
        for centre, name in zip(centres, spheres, strict=True)
    ]
    assert any(covered)
    assert "a1" not in relations.points


def test_everybody_and_everything_is_in_the_relations(builder, program, snapshot_at, case_ii):
    step, snapshot = program.steps[TRAVEL], snapshot_at(TRAVEL)
    relations = builder.relations(Moving(step.travels, step.transports, ()), snapshot, {})
    assert relations.points == ("a2", "a3", "a1", "o1", "o2", *case_ii.region_names)
    assert relations.movers == ("a2", "a3")


def test_a_team_is_one_sphere(builder, program, snapshot_at, models):
    step, snapshot = program.steps[TRANSPORT], snapshot_at(TRANSPORT)
    relations = builder.relations(Moving((), step.transports, ()), snapshot, {})
    assert relations.movers == ("o2",)
    assert not {"a2", "a3"} & set(relations.points)
    expected = models.geometry.team_radius["o2"] + models.geometry.agent_radius["a1"]
    assert radius_to(relations, "o2", "a1") == expected


def test_a_team_that_waits_is_one_sphere_too(builder, program, snapshot_at, models):
    """While one mover of the step is on its way alone."""
    (drive,) = (task for task in program.steps[1].travels if task.agent == "a1")
    (transport,) = program.steps[TRANSPORT].transports
    relations = builder.relations(Moving((drive,), (), (transport,)), snapshot_at(TRANSPORT), {})
    assert relations.movers == ("a1",)
    assert not {"a2", "a3"} & set(relations.points)
    expected = models.geometry.team_radius["o2"] + models.geometry.agent_radius["a1"]
    assert radius_to(relations, "a1", "o2") == expected
    assert radius_to(relations, "a1", "o1") == models.geometry.object_radius["o1"] + models.geometry.agent_radius["a1"]


def test_points_are_where_things_stand_and_go(builder, program, snapshot_at, models):
    step, snapshot = program.steps[TRAVEL], snapshot_at(TRAVEL)
    relations = builder.relations(Moving(step.travels, (), ()), snapshot, {})
    for name in ("a1", "a2", "a3"):
        start = models.agents[name].centre(snapshot.q[name])
        np.testing.assert_array_equal(relations.start[relations.index(name)], start)
    for task in step.travels:
        goal = models.agents[task.agent].centre(task.q_goal)
        np.testing.assert_array_equal(relations.goal[relations.index(task.agent)], goal)


def test_kappa_grows_with_the_relations_unless_it_is_given(case_ii, models, program, snapshot_at):
    step, snapshot = program.steps[TRAVEL], snapshot_at(TRAVEL)
    free = FieldBuilder(case_ii, models).field(Moving(step.travels, (), ()), snapshot, {})
    assert free.function.kappa == KAPPA_PER_FACTOR * len(free.relations.relations)
    scenario = replace(case_ii, controller=replace(case_ii.controller, kappa=17.0))
    assert FieldBuilder(scenario, models).field(Moving(step.travels, (), ()), snapshot, {}).function.kappa == 17.0


def test_with_relations_of_all_levels_kappa_grows_with_all_of_them(case_ii, models, program, snapshot_at):
    """Else G has a higher degree than w can bear, and what is close at the start is driven apart with 1e4 N."""
    step, snapshot = program.steps[TRAVEL], snapshot_at(TRAVEL)
    scenario = replace(case_ii, controller=replace(case_ii.controller, lambda_=1.0))
    function = FieldBuilder(scenario, models).field(Moving(step.travels, (), ()), snapshot, {}).function
    factors = len(function.realisable.sets) + len(function.relations.inside)
    assert factors > 2 * len(function.relations)
    assert function.kappa == KAPPA_PER_FACTOR * factors


def test_the_potential_grows_faster_only_for_who_gathers(builder, program, snapshot_at):
    """The two travellers of the first step meet; those who begin where they have met do not gather any more."""
    step, snapshot = program.steps[TRAVEL], snapshot_at(TRAVEL)
    moving = Moving(step.travels, (), ())
    met = {**snapshot.q, **{task.agent: task.q_goal for task in step.travels}}
    gathering = builder.field(moving, snapshot, {}).function
    gathered = builder.field(moving, Snapshot(met, snapshot.p_WO), {}).function
    assert gathering.shaping.exponent == gathering_exponent(2, gathering.kappa) > 0.5
    assert gathered.shaping.exponent == 0.5


def test_a_goal_that_is_taken_is_refused(builder, program, snapshot_at, models):
    step, snapshot = program.steps[TRAVEL], snapshot_at(TRAVEL)
    (task,) = (task for task in step.travels if task.agent == "a2")
    taken = Snapshot({**snapshot.q, "a1": snapshot.q["a1"] * 0.0}, snapshot.p_WO)
    shift = models.agents["a2"].centre(task.q_goal) - models.agents["a1"].centre(taken.q["a1"])
    taken.q["a1"][:2] += shift[:2]
    with pytest.raises(InvalidInputError, match="a2 and a1"):
        builder.field(Moving(step.travels, (), ()), taken, {})


def test_legs_select_movers(program, models):
    step = program.steps[TRAVEL]
    assert moving_tasks(step, Leg(), models) == (step.travels, step.transports, ())
    assert moving_tasks(step, Leg(1), models) == ((step.travels[1],), (), ())
    ((via,), _, _) = moving_tasks(step, Leg(1, (3.0, -2.0)), models)
    np.testing.assert_allclose(models.agents[via.agent].centre(via.q_goal)[:2], (3.0, -2.0))
    np.testing.assert_array_equal(via.q_goal[2:], step.travels[1].q_goal[2:])
    (transport,) = program.steps[TRANSPORT].transports
    ((), (moved,), ()) = moving_tasks(program.steps[TRANSPORT], Leg(0, (3.0, -2.0)), models)
    np.testing.assert_array_equal(moved.p_goal, [3.0, -2.0, transport.p_goal[2]])


def test_other_teams_wait_for_the_one_on_its_way(program, models):
    (first,) = program.steps[TRANSPORT].transports
    second = replace(first, object="o1")
    travels = program.steps[TRAVEL].travels
    step = replace(program.steps[TRANSPORT], travels=travels, transports=(first, second))
    assert moving_tasks(step, Leg(0), models) == ((travels[0],), (), (first, second))
    assert moving_tasks(step, Leg(2), models) == ((), (first,), (second,))
    assert moving_tasks(step, Leg(3), models) == ((), (second,), (first,))
