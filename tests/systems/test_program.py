"""A placed mission in joint coordinates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from drake_ltl.planning.mission import Stand
from drake_ltl.systems.program import SAME_PLACE, Weld, all_welds, mission_program, start_configuration


def test_every_action_has_its_task(program):
    """Who acts in a step, and with what, is what the plan says."""
    for step in program.steps:
        of_kind = {kind: [a for a in step.actions if a.kind == kind] for kind in ("travel", "grasp", "release")}
        drives = {task.weld.agent for task in step.late_grasps}
        assert {t.agent for t in step.travels} == {a.agents[0] for a in of_kind["travel"]} | drives
        assert {(t.weld.agent, t.weld.object) for t in (*step.grasps, *step.late_grasps)} == {
            (a.agents[0], a.object) for a in of_kind["grasp"]
        }
        assert {(t.weld.agent, t.weld.object) for t in step.releases} == {
            (a.agents[0], a.object) for a in of_kind["release"]
        }
        carried = [(a.object, a.agents, a.start, a.goal) for a in step.actions if a.kind == "transport"]
        assert [(t.object, t.team, t.start, t.goal) for t in step.transports] == carried


def test_travellers_stand_at_their_places(program, mission, models):
    seen = 0
    for step, placed in zip(program.steps, mission.steps, strict=True):
        for task in step.travels:
            stand = placed.standoffs.get(task.agent, placed.after.agents[task.agent])
            p_WC = models.agents[task.agent].centre(task.q_goal)
            np.testing.assert_allclose(p_WC, stand.p_WC, atol=1e-9)
            np.testing.assert_array_equal(task.q_goal[2:], models.postures[task.agent][stand.posture])
            seen += 1
    assert seen >= 6


def test_transports_end_at_their_places_pressed_to_the_floor(program, mission):
    for step, placed in zip(program.steps, mission.steps, strict=True):
        for task in step.transports:
            x, y, z = placed.after.objects[task.object]
            np.testing.assert_array_equal(task.p_goal[:2], [x, y])
            assert z - 0.01 < task.p_goal[2] < z  # well within the tolerance of places


def test_shares_are_in_proportion_to_powers(program, case_ii):
    power = {agent.name: agent.power for agent in case_ii.agents}
    for step in program.steps:
        for task in step.transports:
            total = sum(power[name] for name in task.team)
            expected = [power[name] / total if name in task.team else 0.0 for name in power]
            np.testing.assert_allclose(task.shares, expected)


def test_grasps_begin_at_once_where_the_agent_stands_ready(program, mission):
    """Else it first drives to its stand-off, and grasps late."""
    early = late = 0
    for step, placed in zip(program.steps, mission.steps, strict=True):
        for agent, standoff in placed.standoffs.items():
            here = placed.before.agents[agent]
            apart = np.linalg.norm(np.subtract(here.p_WC, standoff.p_WC))
            ready = apart < SAME_PLACE and here.posture == standoff.posture
            tasks = step.grasps if ready else step.late_grasps
            assert [task.weld.agent for task in tasks].count(agent) == 1
            drives = [travel for travel in step.travels if travel.agent == agent]
            assert len(drives) == (0 if ready else 1)
            assert all(travel.start == travel.goal for travel in drives)
            early, late = early + ready, late + (not ready)
    assert early
    assert late


@pytest.mark.parametrize(("moved", "late"), [(0.5 * SAME_PLACE, False), (2.0 * SAME_PLACE, True)])
def test_how_far_off_an_agent_may_stand_to_grasp_at_once(mission, models, case_ii, moved, late):
    index = next(k for k, step in enumerate(mission.steps) if step.standoffs)
    step = mission.steps[index]
    agent, standoff = next(iter(step.standoffs.items()))
    x, y, z = standoff.p_WC
    stands = dict(step.before.agents) | {agent: Stand((x + moved, y, z), standoff.posture)}
    steps = list(mission.steps)
    steps[index] = replace(step, before=replace(step.before, agents=stands))
    program = mission_program(replace(mission, steps=tuple(steps)), models, case_ii)
    agents = {task.weld.agent for task in program.steps[index].late_grasps}
    assert (agent in agents) is late


def test_grasp_configurations_hold_the_object(program, models):
    for step in program.steps:
        for task in (*step.grasps, *step.late_grasps):
            assert program.welds[task.weld_index] == task.weld
            (grasp,) = (g for g in models.grasps[task.weld.agent, task.weld.object] if g.name == task.weld.option)
            height = models.objects[task.weld.object].height
            X_WE = models.agents[task.weld.agent].grasp_pose(task.q_OE)
            np.testing.assert_allclose(
                X_WE.translation(), grasp.X_OE.translation() + np.array([0, 0, height]), atol=1e-5
            )


def test_releases_back_off_to_the_stand_off(program, mission, models):
    for step, placed in zip(program.steps, mission.steps, strict=True):
        for task in step.releases:
            held, free = placed.before.agents[task.weld.agent], placed.after.agents[task.weld.agent]
            # held grasps are placed where the object stands, so what counts is the way
            np.testing.assert_allclose(np.subtract(free.p_WC, held.p_WC)[:2], task.retreat, atol=1e-6)


def test_welds_are_all_grasps_there_are(models):
    welds = all_welds(models)
    assert len(set(welds)) == len(welds)
    assert set(welds) == {Weld(a, o, g.name) for (a, o), grasps in models.grasps.items() for g in grasps}


def test_after_the_last_step_comes_the_loop(program):
    n, loop = len(program.steps), program.loop
    assert [program.index(count) for count in range(n)] == list(range(n))
    round_ = list(range(loop, n))
    assert [program.index(n + k) for k in range(3 * len(round_))] == 3 * round_


def test_start_configurations_put_the_sphere_in_its_place(models):
    for agent, model in models.agents.items():
        for posture in models.geometry.postures[agent]:
            z = models.geometry.postures[agent][posture][2]
            q = start_configuration(Stand((3.0, -4.0, z), posture), agent, models)
            np.testing.assert_allclose(model.centre(q), [3.0, -4.0, z], atol=1e-9)
