"""Planning in the middle of a mission: what was seen counts, what is stuck stays."""

from __future__ import annotations

import dataclasses

import pytest

from drake_ltl.errors import InfeasibleError
from drake_ltl.planning.geometric_fits import GeometricFits
from drake_ltl.planning.replanning import BETWEEN, Situation, replan
from drake_ltl.scenario.starts import AgentStart, check_starts

BOTH_LEFT = {"a1": "left", "a2": "left"}


def again(relay, spec: str, seen, stuck=frozenset(), blocked=frozenset(), **moved: AgentStart):
    scenario, models, _ = relay
    scenario = dataclasses.replace(scenario, spec=spec)
    agents = dict(check_starts(scenario, models.geometry).agents) | moved
    fits = GeometricFits(scenario, models.geometry)
    situation = Situation(agents, {}, frozenset(stuck), blocked=frozenset(blocked))
    return replan(scenario, models.geometry, fits, situation, seen)


def visited(mission, agent: str) -> set[str]:
    index = ("a1", "a2").index(agent)
    return {state.agents[index] for state in mission.plan.states}


def test_what_was_done_need_not_be_done_again(relay):
    spec = "F a1.right"
    assert "right" in visited(again(relay, spec, [BOTH_LEFT]), "a1")
    assert "right" not in visited(again(relay, spec, [BOTH_LEFT, {"a1": "right", "a2": "left"}]), "a1")


def test_what_was_violated_stays_so(relay):
    with pytest.raises(InfeasibleError):
        again(relay, "G !a1.right", [BOTH_LEFT, {"a1": "right", "a2": "left"}])


def test_who_was_between_regions_was_offered_nothing(relay):
    with pytest.raises(InfeasibleError):
        again(relay, "G a1.left", [BOTH_LEFT, {"a1": None, "a2": "left"}])
    assert again(relay, "G !a1.right", [BOTH_LEFT, {"a1": None, "a2": "left"}]).plan.cost == 0.0


def test_who_is_stuck_is_not_asked_to_move(relay):
    spec = "F(a1.right | a2.right)"
    for stuck, other in (("a1", "a2"), ("a2", "a1")):
        mission = again(relay, spec, [BOTH_LEFT], {stuck})
        assert visited(mission, stuck) == {"left"}
        assert "right" in visited(mission, other)
    with pytest.raises(InfeasibleError):
        again(relay, spec, [BOTH_LEFT], {"a1", "a2"})


def test_nobody_is_sent_to_a_region_that_is_blocked(relay):
    mission = again(relay, "F(a1.right | a1.top)", [BOTH_LEFT], blocked={"right"})
    assert "top" in visited(mission, "a1")
    assert "right" not in visited(mission, "a1") | visited(mission, "a2")
    with pytest.raises(InfeasibleError):
        again(relay, "F a1.right", [BOTH_LEFT], blocked={"right"})


def test_who_is_in_a_region_that_is_blocked_may_stay_or_leave_but_not_come_back(relay):
    assert again(relay, "G a1.left", [BOTH_LEFT], blocked={"left"}).plan.cost == 0.0
    assert "right" in visited(again(relay, "F a1.right", [BOTH_LEFT], blocked={"left"}), "a1")
    with pytest.raises(InfeasibleError):
        again(relay, "F(a1.right & F a1.left)", [BOTH_LEFT], blocked={"left"})


def test_who_is_stuck_between_regions_stays_there(relay):
    away = AgentStart(BETWEEN, "plus", (0.0, 0.0, 0.5))
    mission = again(relay, "F(a1.right | a2.right)", [BOTH_LEFT], {"a1"}, a1=away)
    assert visited(mission, "a1") == {BETWEEN}
    assert "right" in visited(mission, "a2")


def test_who_is_between_regions_must_be_stuck(relay):
    away = AgentStart(BETWEEN, "plus", (0.0, 0.0, 0.5))
    with pytest.raises(InfeasibleError, match="a1 cannot be brought back"):
        again(relay, "F a2.right", [BOTH_LEFT], a1=away)
