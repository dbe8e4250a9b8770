"""Placed missions against a checker that knows distances alone."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_ltl.errors import PlacementError
from drake_ltl.planning.geometric_fits import GeometricFits
from drake_ltl.planning.initial import initial_state
from drake_ltl.planning.placement import place
from drake_ltl.planning.plan import State
from drake_ltl.scenario.starts import check_starts

ROOMY = {
    "agents": {"a1": (1.9, -1.5), "a2": (18.5, -11.5), "a3": (-14.0, 15.0)},
    "objects": {"o1": (-14.0, -14.0), "o2": (0.0, 0.0)},
    "radius": 4.5,
}
"""Regions in which most plans can be carried out."""


def _placed(tools, states, loop, **kwargs):
    """The mission through some states; the checker finds nothing wrong with it."""
    scenario = tools.scenario(**kwargs)
    geometry = tools.geometry(scenario)
    starts = check_starts(scenario, geometry)
    mission = place(tools.plan(scenario, states, loop), scenario, geometry, starts)
    assert tools.violations(mission, scenario, geometry, starts) == []
    return mission


def test_table_2_of_the_paper_is_placed(case_ii, tools):
    mission = place(case_ii.plan, case_ii.scenario, case_ii.geometry, case_ii.starts)
    assert tools.violations(mission, case_ii.scenario, case_ii.geometry, case_ii.starts) == []
    assert (len(mission.steps), mission.loop) == (len(case_ii.plan.states), case_ii.plan.loop)


def test_who_is_about_to_grasp_travels_to_the_stand_off_at_once(case_ii):
    mission = place(case_ii.plan, case_ii.scenario, case_ii.geometry, case_ii.starts)
    for step in mission.steps:
        for agent, stand in step.standoffs.items():
            assert step.before.agents[agent] == stand


def test_the_same_plan_gets_the_same_places(case_ii):
    arguments = (case_ii.plan, case_ii.scenario, case_ii.geometry, case_ii.starts)
    assert place(*arguments) == place(*arguments)


def test_the_checker_notices_what_is_wrong(case_ii, tools):
    """A checker that finds nothing in good missions must find something in bad ones."""
    scenario, geometry, starts = case_ii.scenario, case_ii.geometry, case_ii.starts
    mission = place(case_ii.plan, scenario, geometry, starts)
    last = mission.steps[-1]
    moved = dict(last.after.objects) | {"o2": (20.0, -10.0, 0.25)}
    bad = replace(mission, steps=(*mission.steps[:-1], replace(last, after=replace(last.after, objects=moved))))
    found = tools.violations(bad, scenario, geometry, starts)
    assert any("loop does not close" in text for text in found)
    assert any("o2 moves by itself" in text for text in found)
    assert any("a2 is not at its grasp" in text for text in found)
    large = replace(geometry, agent_radius=dict(geometry.agent_radius) | {"a1": 1.7})
    assert tools.violations(mission, scenario, large, starts)
    wide = replace(geometry, team_radius=dict.fromkeys(geometry.team_radius, 3.6))
    assert any("team" in text for text in tools.violations(mission, scenario, wide, starts))


def test_a_loop_back_to_the_start_returns_to_the_given_places(tools):
    here, there = State(("pi1",), (), ()), State(("pi2",), (), ())
    here, there = replace(here, grasps=(None,)), replace(there, grasps=(None,))
    mission = _placed(tools, [here, there], 0, agents={"a1": (0.5, 0.0)}, objects={})
    assert (len(mission.steps), mission.loop) == (2, 0)


def test_a_loop_that_cannot_return_to_the_start_is_unrolled_once(tools):
    """The agent begins upright, where no other posture fits, and has another posture once it has grasped."""
    states = [
        State(("pi1",), ("pi2",), (None,)),
        State(("pi2",), ("pi2",), (None,)),
        State(("pi2",), ("pi2",), ("o1",)),
        State(("pi2",), ("pi2",), (None,)),
    ]
    near_rim = {"a1": (0.0, 0.0)}
    scenario = tools.scenario(agents=near_rim, objects={"o1": (-14.0, -14.0)})
    geometry = tools.geometry(scenario)
    upright_first = {"upright": (0.0, 0.0, 1.0)} | dict(geometry.postures["a1"])
    geometry = replace(geometry, postures={"a1": upright_first})
    starts = check_starts(scenario, geometry)
    assert starts.agents["a1"].posture == "upright"
    mission = place(tools.plan(scenario, states, 0), scenario, geometry, starts)
    assert tools.violations(mission, scenario, geometry, starts) == []
    assert (len(mission.steps), mission.loop) == (8, 4)
    assert mission.steps[4].before.agents["a1"].posture != "upright"


def test_a_plan_whose_suffix_is_one_idle_state(tools):
    states = [State(("pi1",), (), (None,)), State(("pi2",), (), (None,))]
    mission = _placed(tools, states, 1, agents={"a1": (0.5, 0.0)}, objects={})
    assert mission.steps[1].before == mission.steps[1].after
    assert mission.steps[1].actions == ()


def test_five_agents_that_just_fit_are_placed_one_after_another(tools):
    """At 0.1 m they do not fit, at 0.05 m just so: the regular pentagon has 2 mm to spare."""
    names = [f"a{k}" for k in range(5)]
    centres = {"goal": (0.0, 0.0, 0.0)} | {
        f"p{k}": (15.0 * math.cos(1.2 * k), 15.0 * math.sin(1.2 * k), 0.0) for k in range(5)
    }
    agents = {name: centres[f"p{k}"][:2] for k, name in enumerate(names)}
    at = [f"p{k}" for k in range(5)]
    states = [State(tuple(at), (), (None,) * 5)]
    for k in range(5):
        at[k] = "goal"
        states.append(State(tuple(at), (), (None,) * 5))
    _placed(tools, states, 5, agents=agents, objects={}, centres=centres)


def test_bodies_may_start_closer_than_any_margin(tools):
    states = [State(("pi1", "pi1"), (), (None, None)), State(("pi2", "pi1"), (), (None, None))]
    agents = {"a1": (-2.1, 0.0), "a2": (1.596, -0.679)}
    scenario = tools.scenario(agents=agents, objects={})
    starts = check_starts(scenario, tools.geometry(scenario))
    gap = math.dist(starts.agents["a1"].p_WC, starts.agents["a2"].p_WC) - 2.5
    mission = _placed(tools, states, 1, agents=agents, objects={})
    assert len(mission.steps) == 2
    assert 0.0 < gap < 0.05


def test_a_team_whose_options_do_not_work_together_is_refused_where_it_fails(case_ii, tools):
    """Around o2 at (-1.5, 0.2) agents 1 and 2 can only stand 60 degrees apart."""
    states = [
        State(("pi1", "pi3", "pi4"), ("pi2", "pi1"), (None, None, None)),
        State(("pi1", "pi1", "pi4"), ("pi2", "pi1"), (None, None, None)),
        State(("pi1", "pi1", "pi4"), ("pi2", "pi1"), ("o2", "o2", None)),
    ]
    plan = tools.plan(case_ii.scenario, states, 2)
    with pytest.raises(PlacementError, match="a1 grasps o2 in pi1; a2 grasps o2 in pi1") as caught:
        place(plan, case_ii.scenario, case_ii.geometry, case_ii.starts)
    assert caught.value.step == 1
    assert caught.value.region == "pi1"
    assert {"a1", "a2"} <= set(caught.value.bodies)


def test_who_cannot_grasp_is_named(case_ii, tools):
    states = [
        State(("pi1", "pi3", "pi4"), ("pi2", "pi1"), (None, None, None)),
        State(("pi1", "pi3", "pi4"), ("pi2", "pi1"), ("o2", None, None)),
    ]
    grasps = {key: ways for key, ways in case_ii.geometry.grasps.items() if key != ("a1", "o2")}
    with pytest.raises(PlacementError, match="a1 has no way to grasp o2"):
        place(
            tools.plan(case_ii.scenario, states, 1),
            case_ii.scenario,
            replace(case_ii.geometry, grasps=grasps),
            case_ii.starts,
        )


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(2, 8), st.booleans())
def test_whatever_is_placed_can_be_carried_out(tools, seed, length, roomy):

    scenario = tools.scenario(**ROOMY) if roomy else tools.scenario()
    geometry = tools.geometry(scenario)
    starts = check_starts(scenario, geometry)
    rng = random.Random(seed)
    fits = GeometricFits(scenario, geometry)
    walk = tools.random_states(scenario, initial_state(scenario, starts), fits, rng, length)
    loop = rng.randrange(max(1, len(walk) - 1))
    plan = tools.plan(scenario, tools.there_and_back(walk, loop), loop)
    failure = None
    try:
        mission = place(plan, scenario, geometry, starts)
    except PlacementError as error:
        failure = error
    if failure is None:
        assert tools.violations(mission, scenario, geometry, starts) == []
    else:
        assert 0 <= failure.step < len(plan.moves)
        assert failure.region in scenario.region_names
        assert failure.bodies


def test_most_plans_in_roomy_regions_are_placed(tools):
    """Guards against a search that gives up: where a walk fits region by region, 6 of 10 were placed."""
    scenario = tools.scenario(**ROOMY)
    geometry = tools.geometry(scenario)
    starts = check_starts(scenario, geometry)
    fits, placed = GeometricFits(scenario, geometry), 0
    for seed in range(20):
        walk = tools.random_states(scenario, initial_state(scenario, starts), fits, random.Random(seed), 5)
        try:
            place(tools.plan(scenario, tools.there_and_back(walk, 0), 0), scenario, geometry, starts)
            placed += 1
        except PlacementError:
            pass
    assert placed >= 8
