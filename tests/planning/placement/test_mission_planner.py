"""Plans that can be placed, found by giving up those that cannot."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest

from drake_ltl.errors import NoPlacesError
from drake_ltl.planning.mission_planner import plan_mission
from drake_ltl.scenario.starts import check_starts


def _with_specs(scenario, specs, powers, needs):
    return replace(
        scenario,
        agents=tuple(replace(a, spec=specs.get(a.name, "1"), power=powers[a.name]) for a in scenario.agents),
        objects=tuple(replace(o, spec=specs.get(o.name, "1"), power_needed=needs[o.name]) for o in scenario.objects),
    )


def _case_i(tools, turn):
    """The paper's first example, o1 nearer to the centre; headings are turned by `turn` thirds of a circle."""
    objects = {"o1": (-14.0, -14.2), "o2": (-1.5, 0.2)}
    scenario = tools.scenario(agents={"a1": (0.5, 0.0), "a2": (18.5, -11.5)}, objects=objects)
    specs = {"a1": "G !pi3", "a2": "GF pi3", "o1": "GF pi1 & G(pi1 -> X pi4)", "o2": "F pi4"}
    scenario = _with_specs(scenario, specs, {"a1": 2.0, "a2": 4.0}, {"o1": 5.0, "o2": 6.0})
    agents = (replace(a, heading=a.heading + 2.0 * math.pi * turn / 3.0) for a in scenario.agents)
    return replace(scenario, agents=tuple(agents))


def test_the_papers_second_example_costs_what_it_must(case_ii, tools):
    specs = {"a1": "G !pi3", "a2": "GF pi3", "o1": "GF pi1 & G(pi1 -> F pi4)", "o2": "GF pi3"}
    scenario = _with_specs(case_ii.scenario, specs, {"a1": 2.0, "a2": 4.0, "a3": 3.0}, {"o1": 5.0, "o2": 6.0})
    mission = plan_mission(scenario, case_ii.geometry, case_ii.starts)
    assert tools.violations(mission, scenario, case_ii.geometry, case_ii.starts) == []
    assert (mission.plan.prefix_cost, mission.plan.suffix_cost) == pytest.approx((4941.0, 2886.0))


def test_headings_decide_whether_two_agents_can_fetch_the_object(tools):
    """Around o2 at (-1.5, 0.2) only stands at 60 and 300 degrees from it are inside and far enough apart."""
    scenario = _case_i(tools, turn=1)
    geometry = tools.geometry(scenario)
    starts = check_starts(scenario, geometry)
    mission = plan_mission(scenario, geometry, starts)
    assert tools.violations(mission, scenario, geometry, starts) == []
    assert mission.plan.lower_bound <= mission.plan.cost + 1e-9

    scenario = _case_i(tools, turn=0)
    geometry = tools.geometry(scenario)
    with pytest.raises(NoPlacesError, match=r"fails at step \d+ \(.*a2 grasps o2 in pi1.* apart in pi1") as caught:
        plan_mission(scenario, geometry, check_starts(scenario, geometry))
    assert re.match(r"no places for the bodies were found in any of the \d+ plans tried; ", str(caught.value))
    assert "formula" not in str(caught.value)  # each of them can be satisfied


def test_a_plan_in_the_way_of_a_given_object_is_planned_around(tools):
    """o1 stands where o2 should be brought: the cheapest plan carries it straight in, which cannot be placed."""
    centres = {"pi1": (0.0, 0.0, 0.0), "pi2": (-14.0, -14.0, 0.0), "pi3": (20.0, -10.0, 0.0)}
    objects = {"o1": (-14.0, -14.0), "o2": (0.0, 0.0)}
    scenario = tools.scenario(agents={"a1": (1.9, -1.5)}, objects=objects, centres=centres, radius=4.0)
    scenario = _with_specs(scenario, {"o2": "F pi2"}, {"a1": 2.0}, {"o1": 2.0, "o2": 2.0})
    geometry = tools.geometry(scenario)
    starts = check_starts(scenario, geometry)
    mission = plan_mission(scenario, geometry, starts)
    assert tools.violations(mission, scenario, geometry, starts) == []
    carried = [a.object for step in mission.steps for a in step.actions if a.kind == "transport"]
    assert carried[0] == "o1"


def test_attempts_are_bounded(tools):
    scenario = _case_i(tools, turn=0)
    geometry = tools.geometry(scenario)
    with pytest.raises(NoPlacesError, match=r"no places .* in the only plan tried; the cheapest fails at step \d+ "):
        plan_mission(scenario, geometry, check_starts(scenario, geometry), max_attempts=1)
