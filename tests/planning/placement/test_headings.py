"""Objects that are turned: their headings along a plan, and those who hold them turn along."""

from __future__ import annotations

import dataclasses
import math

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drake_ltl.planning.geometry import Geometry, turned, turned_posture
from drake_ltl.planning.headings import Headings
from drake_ltl.planning.placement import place
from drake_ltl.planning.plan import State
from drake_ltl.planning.stays import Timeline
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.starts import check_starts

START = 0.5
GOALS = {"pi1": 2.0, "pi4": -1.0}
TURNS = [0.0, *(goal - START for goal in GOALS.values())]


def with_headings(scenario: Scenario) -> Scenario:
    """o1 is turned in pi1 and pi4; the others keep what they have."""
    first, *others = scenario.objects
    turning = dataclasses.replace(first, orientation=(0.0, 0.0, START), headings=GOALS)
    return dataclasses.replace(scenario, objects=(turning, *others))


def with_turned_postures(geometry: Geometry) -> Geometry:
    """As agents with yaw joints have them."""
    postures = {
        agent: {turned_posture(name, turn): turned(p, turn) for turn in TURNS for name, p in table.items()}
        for agent, table in geometry.postures.items()
    }
    return dataclasses.replace(geometry, postures=postures)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])  # it only reads
@given(regions=st.lists(st.sampled_from(["pi1", "pi2", "pi3", "pi4"]), min_size=2, max_size=7), data=st.data())
def test_headings_follow_the_transports(case_ii, tools, regions, data):
    """Walked once more, move by move; a loop closes if its walk ends as it began, after one round it always does."""
    scenario = with_headings(case_ii.scenario)
    loop = data.draw(st.integers(0, len(regions) - 1))
    states = [State((region, region, "pi3"), (region, "pi3"), ("o1", "o1", None)) for region in regions]
    plan = tools.plan(scenario, states, loop)
    for rounds in (0, 1):
        timeline = Timeline.of(plan, scenario.agent_names, scenario.object_names, rounds=rounds)
        headings = Headings(scenario, timeline)
        heading = START
        for move, actions in enumerate(timeline.moves):
            assert headings.at("o1", move) == heading
            assert headings.turn("o1", move) == heading - START
            assert headings.at("o2", move) == headings.turn("o2", move) == 0.0
            for action in actions:
                heading = GOALS.get(action.goal, heading)
        assert headings.closing == {"o1": heading == headings.at("o1", timeline.loop), "o2": True}
    assert headings.closing["o1"]


def test_who_holds_turns_along(case_ii):
    """Grasps and postures are those of the object as it stands; the plan is that of Table 2."""
    scenario, geometry = with_headings(case_ii.scenario), with_turned_postures(case_ii.geometry)
    mission = place(case_ii.plan, scenario, geometry, check_starts(scenario, geometry))
    seen = set()
    for step in mission.steps:
        for layout in (step.before, step.after):
            for agent, stand in layout.agents.items():
                if stand.grasp is None:
                    continue
                obj, name = stand.grasp
                turn = layout.headings[obj] - (START if obj == "o1" else 0.0)
                (option,) = (o for o in geometry.grasps[agent, obj] if o.name == name)
                offset = [a - b for a, b in zip(stand.p_WC, layout.objects[obj], strict=True)]
                assert offset == pytest.approx(turned(option.p_OoC_grasp, turn), abs=1e-9)
                assert stand.posture == turned_posture(option.standoff_posture, turn)
                seen.add((obj, turn))
    assert seen == {("o2", 0.0), ("o1", TURNS[0]), ("o1", TURNS[1]), ("o1", TURNS[2])}
    assert mission.steps[mission.loop].before == mission.steps[-1].after


def test_a_loop_that_turns_an_object_anew_is_unrolled_once(case_ii, tools):
    """o1 stands in pi2 as at the start when the loop begins, and as it was turned in pi1 when it comes back."""
    scenario, geometry = with_headings(case_ii.scenario), with_turned_postures(case_ii.geometry)
    start = State(("pi1", "pi3", "pi4"), ("pi2", "pi1"), (None, None, None))
    here = State(("pi2", "pi3", "pi2"), ("pi2", "pi1"), (None, None, None))
    held = State(("pi2", "pi3", "pi2"), ("pi2", "pi1"), ("o1", None, "o1"))
    there = State(("pi4", "pi3", "pi4"), ("pi4", "pi1"), ("o1", None, "o1"))
    plan = tools.plan(scenario, [start, here, held, there], 2)
    mission = place(plan, scenario, geometry, check_starts(scenario, geometry))
    assert mission.loop == 4
    assert mission.steps[2].before.headings["o1"] == START
    assert mission.steps[4].before.headings["o1"] == GOALS["pi4"]


@given(st.floats(-10.0, 10.0), st.tuples(*3 * [st.floats(-5.0, 5.0)]))
def test_vectors_turn_about_the_vertical(angle, p):
    x, y, z = turned(p, angle)
    assert math.hypot(x, y) == pytest.approx(math.hypot(p[0], p[1]), abs=1e-12)
    assert z == p[2]
    assert turned((x, y, z), -angle) == pytest.approx(p, abs=1e-12)
    assert turned((1.0, 0.0, 0.0), math.pi / 2) == pytest.approx((0.0, 1.0, 0.0), abs=1e-12)
