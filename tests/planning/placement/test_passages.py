"""Ways within a region to where an agent grasps from, against a lattice search that knows nothing of arcs."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from drake_ltl.errors import InvalidInputError, PlacementError
from drake_ltl.navigation import RegionBall, StaticBody, Traveller, step_relations
from drake_ltl.navigation.detour import detour
from drake_ltl.planning.passages import _arc
from drake_ltl.planning.placement import place
from drake_ltl.planning.plan import State
from drake_ltl.scenario.starts import check_starts

CENTRES = {"home": (0.0, 0.0, 0.0), "away": (20.0, 0.0, 0.0)}


def _grasp_where_it_stands(tools, agents, radius=3.6) -> SimpleNamespace:
    """a1 grasps o1, at home; the others stand by."""
    scenario = tools.scenario(agents=agents, objects={"o1": (0.0, 0.0)}, centres=CENTRES, radius=radius)
    geometry = tools.geometry(scenario)
    starts = check_starts(scenario, geometry)
    regions, idle = ("home",) * len(agents), (None,) * (len(agents) - 1)
    states = [State(regions, ("home",), (None, *idle)), State(regions, ("home",), ("o1", *idle))]
    plan = tools.plan(scenario, states, 1)
    return SimpleNamespace(scenario=scenario, geometry=geometry, starts=starts, plan=plan)


def _has_a_way(case, mission) -> bool:
    step = mission.steps[0]
    start, goal = step.before.agents["a1"], step.standoffs["a1"]
    others = [name for name in case.scenario.agent_names if name != "a1"]
    relations = step_relations(
        travellers=[Traveller("a1", 1.25, "home", "home", start.p_WC, goal.p_WC)],
        static_agents=[StaticBody(name, 1.25, step.before.agents[name].p_WC) for name in others],
        static_objects=[StaticBody("o1", 0.5, step.before.objects["o1"])],
        regions=[RegionBall(region.name, region.centre, region.radius) for region in case.scenario.regions],
        workspace_radius=30.0,
    )
    return detour(relations) is not None


@settings(max_examples=40, deadline=None)
@given(st.floats(0.0, 2.0 * math.pi), st.floats(1.9, 2.3), st.floats(0.0, 2.0 * math.pi), st.floats(1.9, 2.3))
def test_what_is_placed_has_a_way(tools_, angle, distance, other_angle, other_distance):
    agents = {
        "a1": (distance * math.cos(angle), distance * math.sin(angle)),
        "a2": (other_distance * math.cos(other_angle), other_distance * math.sin(other_angle)),
    }
    try:
        case = _grasp_where_it_stands(tools_, agents, radius=4.2)
        mission = place(case.plan, case.scenario, case.geometry, case.starts)
    except (InvalidInputError, PlacementError):
        assume(False)
    assert _has_a_way(case, mission)


@pytest.fixture(scope="module")
def tools_(tools):
    return tools


def test_takes_the_side_that_it_can_reach(tools):
    """a1 grasps from the left or from the right; a2 stands to the right, between it and the right side."""
    case = _grasp_where_it_stands(tools, {"a1": (-1.5, 1.2), "a2": (1.9, 0.9)}, radius=4.0)
    mission = place(case.plan, case.scenario, case.geometry, case.starts)
    assert mission.steps[0].standoffs["a1"].p_WC[0] < 0.0
    assert _has_a_way(case, mission)


@given(
    st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    st.sampled_from([-1.0, 1.0]),
)
def test_arcs_keep_the_distance_of_their_ends(start, goal, side):
    start, goal, around = np.array(start), np.array(goal), np.zeros(3)
    ends = sorted(np.hypot(*point[:2]) for point in (start, goal))
    distance = np.hypot(*_arc(start, goal, around, side)[:, :2].T)
    assert np.all(distance >= ends[0] - 1e-9)
    assert np.all(distance <= ends[1] + 1e-9)


def test_arcs_to_both_sides_go_once_around_together():
    start, goal = np.array([2.0, 0.0, 0.0]), np.array([0.0, 2.0, 0.0])
    left, right = (_arc(start, goal, np.zeros(3), side) for side in (1.0, -1.0))
    assert np.all(left[:, 1] > 0.0)
    assert np.any(right[:, 1] < 0.0)
