"""A region is blocked while a robot is on its way there: it turns back, and another region will do."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from pydrake.math import RigidTransform

from drake_ltl import mission
from drake_ltl.execution.under_way import UnderWay
from drake_ltl.faults.legs import Bodies, finishing, gathering
from drake_ltl.faults.losses import DOOR, DRIVE, Losses
from drake_ltl.monitoring.violation import Violation
from drake_ltl.planning.mission import Stand
from drake_ltl.scenario import loads
from drake_ltl.systems.program import mission_program, start_configuration
from drake_ltl.systems.progress import Measurement
from drake_ltl.verification import verify
from drake_ltl.verification.blocked import NOTICED_WITHIN


@pytest.fixture(scope="module")
def errand(mission_text):
    """(scenario, models, mission)"""
    fault = "faults:\n  - {kind: blocked_region, region: yard, time: 2.0}\n"
    scenario = loads(mission_text("errand") + fault)
    models = mission.measure(scenario)
    planned = mission.plan_and_place(scenario, models)
    assert planned.plan.moves[0][0].goal == "yard"
    return scenario, models, planned


@pytest.fixture(scope="module")
def blocked(errand):
    """(run, scenario)"""
    scenario, models, planned = errand
    return mission.simulate(planned, scenario, models, announce=lambda line: None), scenario


def test_it_turns_back_and_another_region_will_do(blocked):
    run, scenario = blocked
    (noticed,) = run.noticed
    assert 2.0 <= noticed.seen.time <= 2.0 + NOTICED_WITHIN
    assert noticed.seen.who == ("yard",)
    assert (noticed.lost, noticed.went_on) == ("nobody may enter yard any more", "planned again")
    ways = [(action["from"], action["to"]) for step in run.recording.steps for action in step.actions]
    assert ways == [("home", "yard"), ("yard", "home"), ("home", "shed")]
    verdict = verify(run.recording, scenario)
    assert verdict.satisfied, [str(violation) for violation in verdict.violations]
    assert verdict.word[-1] == ("a1.shed",)


def test_who_had_gone_on_would_be_found_out(blocked):
    """The same run, but the region had been blocked to which it went."""
    run, scenario = blocked
    (fault,) = scenario.faults
    other = dataclasses.replace(scenario, faults=(dataclasses.replace(fault, who="shed"),))
    kinds = [violation.what for violation in verify(run.recording, other).violations]
    assert kinds == ["a1 enters shed, which is blocked"]


@pytest.mark.parametrize("before", [0.3, 0.03])  # the second is noticed in the next part of the run
def test_what_happens_in_safe_mode_is_noticed_as_soon(errand, blocked, before):
    """The door of the region that it should go back to closes just before it rests."""
    scenario, models, planned = errand
    (fault,) = scenario.faults
    first = blocked[0].recording.steps[0]
    other = dataclasses.replace(fault, who="home", time=first.start + first.duration - before)
    both = dataclasses.replace(scenario, faults=(fault, other))
    run = mission.simulate(planned, both, models, announce=lambda line: None)
    assert [what.who for _, what in run.happened] == ["yard", "home"]
    assert [noticed.seen.who for noticed in run.noticed] == [("yard",), ("home",)]
    assert 0.0 < run.noticed[1].seen.time - other.time <= NOTICED_WITHIN
    assert "nobody may enter home any more; nobody may enter yard any more: a1 cannot be" in run.recording.reason


def test_a_region_may_be_called_like_an_agent():
    going = UnderWay(None, None, None, 1, None, None, losses=Losses(agents=frozenset({"yard"})))
    assert going.knows(Violation(DRIVE, 1.0, 0, ("yard",), "is weak"))
    assert not going.knows(Violation(DOOR, 1.0, 0, ("yard",), "has closed"))
    going.losses = Losses(regions=frozenset({"yard"}))
    assert going.knows(Violation(DOOR, 1.0, 0, ("yard",), "has closed"))
    assert not going.knows(Violation(DRIVE, 1.0, 0, ("yard",), "is weak"))


def bodies_of(scenario, models, q, p_WO) -> Bodies:
    """Everything at rest."""
    X_WO = {name: RigidTransform(np.asarray(p)) for name, p in p_WO.items()}
    return Bodies(scenario, models, Measurement(0.0, q, dict.fromkeys(q, np.zeros(4)), X_WO, {}))


@pytest.fixture
def carrying(case_ii, models, program):
    """(task, step, bodies, began): a team is between two regions with its object, all others are where they were."""
    number, step = next((k, step) for k, step in enumerate(program.steps) if step.transports and not step.travels)
    task, before = step.transports[0], program.mission.steps[number].before
    began = {name: np.asarray(p) for name, p in before.objects.items()}
    objects = began | {task.object: 0.5 * (began[task.object] + task.p_goal)}
    q = {}
    for name, stand in before.agents.items():
        if stand.grasp is None:
            q[name] = start_configuration(stand, name, models)
        else:
            obj, option = stand.grasp
            q[name] = models.grasp(name, obj, option).q + np.array([*objects[obj][:2], 0.0, 0.0])
    return task, step, bodies_of(case_ii, models, q, objects), began


def test_a_team_goes_on_to_a_region_that_is_open(carrying):
    task, step, bodies, began = carrying
    assert bodies.region(task.object) is None
    assert finishing(step, Losses(regions=frozenset({task.start})), bodies, began).transports == (task,)


def test_a_team_brings_its_object_back_from_a_region_that_is_blocked(carrying):
    task, step, bodies, began = carrying
    (back,) = finishing(step, Losses(regions=frozenset({task.goal})), bodies, began).transports
    assert (back.start, back.goal, back.team) == (task.goal, task.start, task.team)
    np.testing.assert_array_equal(back.p_goal, began[task.object])


def test_a_team_does_not_go_back_to_where_it_was_halted_before_or_to_what_is_blocked_too(carrying):
    task, step, bodies, began = carrying
    blocked = Losses(regions=frozenset({task.goal}))
    halted_before = began | {task.object: bodies.now.X_WO[task.object].translation()}
    assert finishing(step, blocked, bodies, halted_before).transports == ()
    both = Losses(regions=frozenset({task.start, task.goal}))
    assert finishing(step, both, bodies, began).transports == ()


@pytest.mark.parametrize(("blocked", "goals"), [((), ["right"]), (("right",), ["left"]), (("left", "right"), [])])
def test_who_is_between_regions_comes_to_one_that_is_not_blocked(relay, blocked, goals):
    scenario, models, _ = relay
    stands = {"a1": Stand((1.0, 0.0, 0.5), "zero"), "a2": Stand((-6.5, -1.6, 0.5), "zero")}
    q = {name: start_configuration(stand, name, models) for name, stand in stands.items()}
    bodies = bodies_of(scenario, models, q, {})
    program = gathering({"a1": ("left", "right")}, Losses(regions=frozenset(blocked)), bodies)
    assert [task.goal for task in program.travels] == goals


def test_a_mover_does_not_finish_into_a_region_that_is_blocked(relay):
    scenario, models, planned = relay
    step = next(step for step in mission_program(planned, models, scenario).steps if step.travels)
    (task,) = step.travels
    q = {name: start_configuration(stand, name, models) for name, stand in planned.steps[0].before.agents.items()}
    q[task.agent] = q[task.agent] + [5.0, 0.0, 0.0, 0.0]
    bodies = bodies_of(scenario, models, q, {})
    assert finishing(step, Losses(), bodies, {}).travels == (task,)
    assert finishing(step, Losses(regions=frozenset({task.goal})), bodies, {}).travels == ()
