"""Explanations: what clashes is named, nothing too much, and leaving any of it out really helps."""

from __future__ import annotations

from itertools import chain, combinations

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from drake_ltl.errors import CertificateError, InfeasibleError, SearchLimitError
from drake_ltl.planning import existence
from drake_ltl.planning.abilities import able_teams, may_enter
from drake_ltl.planning.certificate import check
from drake_ltl.planning.demands import Demand, demands, in_words, with_demands
from drake_ltl.planning.explanation import explain_infeasible
from drake_ltl.planning.feasibility import feasible_starts
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.plan import State
from drake_ltl.planning.planner import plan
from drake_ltl.planning.power import sum_rule
from drake_ltl.planning.refutation import Refutation
from drake_ltl.planning.relaxation import Power, Problem, Room, Start
from drake_ltl.planning.transition_system import form
from drake_ltl.scenario.formulas import global_formula
from drake_ltl.spot_support import require_spot

TWO = {f"r{k}": (10.0 * k, 0.0, 0.0) for k in range(2)}


def anything_fits(region, content):
    return True


def has_plan(scenario, start, fits, can_carry=None):
    try:
        plan(scenario, start, fits, can_carry=can_carry)
    except InfeasibleError:
        return False
    return True


# Demands


def test_formulas_are_split_at_their_conjunctions(case_i):
    scenario, _ = case_i
    assert demands(scenario) == (
        Demand("a1", "G!pi3"),
        Demand("a2", "GFpi3"),
        Demand("o1", "GFpi1"),
        Demand("o1", "G(pi1 -> Xpi4)"),
        Demand("o2", "Fpi4"),
    )


def test_always_splits_at_conjunctions(make_scenario):
    scenario = make_scenario({"a1": (1.0, "G(!pi1 & (G pi2 & (pi1 -> F pi3)))")}, {})
    assert [demand.formula for demand in demands(scenario)] == ["G!pi1", "Gpi2", "G(pi1 -> Fpi3)"]


def test_all_demands_together_are_the_specification(make_scenario):
    scenario = make_scenario(
        {"a1": (1.0, "G !pi3 & (F pi1 | X pi2) & 1")}, {"o1": (1.0, "1")}, spec="F a1.pi2 & (X o1.pi1 & G !o1.pi4)"
    )
    spot = require_spot()
    again = with_demands(scenario, demands(scenario))
    assert spot.are_equivalent(spot.formula(global_formula(again)), spot.formula(global_formula(scenario)))
    assert global_formula(with_demands(scenario, [])) == "1"


@pytest.mark.parametrize(
    ("owner", "formula", "text"),
    [
        ("a1", "GFpi3", "a1 must visit pi3 again and again (a1: GF pi3)"),
        ("a1", "G!pi3", "a1 must never enter pi3 (a1: G !pi3)"),
        ("a1", "Fcharge", "a1 must experience charge at some time (a1: F charge)"),
        ("a1", "G(pi1 -> XXpi3)", "a1 must satisfy G(pi1 -> XX pi3)"),
        ("a1", "GFXpi3", "a1 must satisfy GFX pi3"),
        ("a1", "0", "a1 must satisfy 0"),
        ("", "FGo1.pi3", "o1 must stay in pi3 from some time on (spec: FG o1.pi3)"),
        ("", "!o1.pi3 U o1.pi2", "o1 must satisfy !o1.pi3 U o1.pi2"),
        ("", "F(a1.pi2 & o1.pi4)", "the team must satisfy F(a1.pi2 & o1.pi4)"),
    ],
)
def test_words(make_scenario, owner, formula, text):
    services = {"a1": {"pi4": ("charge",)}}
    scenario = make_scenario({"a1": (1.0, "1")}, {"o1": (1.0, "1")}, services=services)
    assert in_words(scenario, Demand(owner, formula)) == text


# What is found


def explained(scenario, start, fits=None, **others):
    found = explain_infeasible(scenario, start, fits or published_fits(scenario.fits), **others)
    assert found.minimal
    assert found.verified
    return found


def test_too_weak_where_others_may_not_go(make_scenario):
    scenario = make_scenario(
        {"a1": (2.0, "G !pi3"), "a2": (4.0, "GF pi3"), "a3": (1.0, "1")},
        {"o1": (5.0, "GF pi1 & G(pi1 -> F pi4)"), "o2": (6.0, "GF pi3")},
    )
    found = explained(scenario, State(("pi1", "pi3", "pi4"), ("pi2", "pi1"), (None,) * 3))
    assert found.lines == (
        "these cannot hold together:",
        "  a1 must never enter pi3 (a1: G !pi3)",
        "  o2 must visit pi3 again and again (o2: GF pi3)",
        "  o2 needs power 6",
        "  o2 starts in pi1",
        "for",
        "  a2 + a3 give 5, too little for o2 in pi3; no other may enter it",
        "without any one of them the others alone have a plan, found and checked",
    )


def test_too_weak_anywhere(make_scenario):
    scenario = make_scenario({"a1": (2.0, "1"), "a2": (3.0, "GF pi1")}, {"o1": (6.0, "F pi4")})
    found = explained(scenario, State(("pi1", "pi3"), ("pi2",), (None, None)))
    assert found.reasons == (Demand("o1", "Fpi4"), Power("o1"), Start("o1"))
    assert found.remarks == ("a1 + a2 give 5, too little for o1",)


def test_no_room_for_the_team(make_scenario):
    scenario = make_scenario({"a1": (2.0, "1"), "a2": (3.0, "1")}, {"o1": (5.0, "F pi4")}, fits=None)

    def fits(region, content):
        return not (region.name == "pi4" and len(content.holds) > 1)

    found = explained(scenario, State(("pi1", "pi3"), ("pi2",), (None, None)), fits)
    assert found.reasons == (Demand("o1", "Fpi4"), Power("o1"), Room("pi4"), Start("o1"))
    assert found.remarks == ("o1 can be carried by a1 + a2 only", "pi4 has no room for a1 + a2 with o1")
    assert "  pi4 has room for what fits within 3.5 m of its centre" in found.lines


def test_who_cannot_grasp_at_all(make_scenario):
    """It is not for want of room that a1 holds nothing, and a2 is too weak alone."""
    scenario = make_scenario({"a1": (2.0, "1"), "a2": (3.0, "1")}, {"o1": (5.0, "F pi4")}, fits=None)
    found = explained(
        scenario,
        State(("pi1", "pi3"), ("pi2",), (None, None)),
        lambda region, content: "a1" not in dict(content.holds),
    )
    assert "a1 cannot grasp o1 in any region" in found.remarks
    assert not any("no room" in remark for remark in found.remarks)


def test_no_room_for_a_crowd(make_scenario):
    scenario = make_scenario({f"a{i}": (1.0, "1") for i in range(1, 4)}, {}, spec="F(a1.pi4 & a2.pi4 & a3.pi4)")
    found = explained(
        scenario, State(("pi1", "pi2", "pi3"), (), (None,) * 3), lambda region, content: len(content.free_agents) < 3
    )
    assert found.reasons == (Demand("", "F(a1.pi4 & a2.pi4 & a3.pi4)"), Room("pi4"))
    assert found.remarks == ("pi4 has no room for a1 + a2 + a3",)


def test_an_impossible_start(make_scenario):
    scenario = make_scenario({"a1": (1.0, "1"), "a2": (1.0, "G pi3")}, {"o1": (9.0, "1")})
    found = explained(
        scenario,
        State(("pi1", "pi3"), ("pi1",), (None, None)),
        lambda region, content: not (content.free_agents and content.objects),
    )
    assert found.reasons == (Room("pi1"), Start("a1"), Start("o1"))
    assert found.lines[0] == "these cannot hold together:"


def test_a_start_where_it_must_not_be(make_scenario):
    scenario = make_scenario({"a1": (1.0, "G !pi1"), "a2": (1.0, "GF pi1")}, {})
    found = explained(scenario, State(("pi1", "pi2"), (), (None, None)))
    assert found.reasons == (Demand("a1", "G!pi1"), Start("a1"))
    assert found.without[Start("a1")].states[0].agents[0] != "pi1"
    assert found.without[Start("a1")].states[0].agents[1] == "pi2"  # who starts where is changed as little as possible


def test_a_formula_that_nothing_satisfies(make_scenario):
    scenario = make_scenario({"a1": (1.0, "F(pi1 & pi2) & GF pi3"), "a2": (1.0, "GF pi1")}, {}, spec="G !a2.pi3")
    found = explained(scenario, State(("pi1", "pi2"), (), (None, None)))
    assert found.lines == (
        "this cannot hold:",
        "  a1 must satisfy F(pi1 & pi2)",
        "without it there is a plan, found and checked",
    )


def test_two_members_clash_through_the_global_formula(make_scenario):
    scenario = make_scenario(
        {"a1": (1.0, "GF pi1 & GF pi4"), "a2": (1.0, "G !pi1")},
        {"o1": (1.0, "GF pi2")},
        spec="G(a1.pi1 -> a2.pi1) & F o1.pi3",
    )
    found = explained(scenario, State(("pi3", "pi2"), ("pi3",), (None, None)))
    assert found.reasons == (
        Demand("a1", "GFpi1"),
        Demand("a2", "G!pi1"),
        Demand("", "G(a1.pi1 -> a2.pi1)"),
    )


def test_callers_who_say_themselves_who_can_carry(make_scenario):
    scenario = make_scenario({"a1": (9.0, "G !pi2"), "a2": (9.0, "1")}, {"o1": (1.0, "F pi2")})
    start = State(("pi1", "pi1"), ("pi1",), (None, None))
    found = explained(scenario, start, can_carry=lambda obj, team: team == {"a1"})
    assert found.reasons == (Demand("a1", "G!pi2"), Demand("o1", "Fpi2"), Power("o1"), Start("o1"))
    assert "  o1 can be carried by some teams only" in found.lines
    assert found.remarks == ("a2 cannot carry o1 in pi2; no other may enter it",)


def test_grasps_at_the_start_are_facts(make_scenario):
    scenario = make_scenario({"a1": (1.0, "G pi1"), "a2": (1.0, "1")}, {"o1": (1.0, "X pi2")})
    start = State(("pi1", "pi1"), ("pi1",), ("o1", None))
    found = explained(scenario, start)
    assert Start("o1") in found.reasons
    assert Demand("o1", "Xpi2") in found.reasons


# Limits


def test_what_has_a_plan_needs_no_explanation(case_i):
    scenario, start = case_i
    with pytest.raises(ValueError, match="there is a plan"):
        explain_infeasible(scenario, start, published_fits(scenario.fits))


def weak_pair(make_scenario):
    scenario = make_scenario({"a1": (1.0, "G !pi2"), "a2": (1.0, "1")}, {"o1": (2.0, "F pi2")})
    return scenario, State(("pi1", "pi1"), ("pi1",), (None, None))


def test_without_time_nothing_is_claimed(make_scenario):
    scenario, start = weak_pair(make_scenario)
    found = explain_infeasible(scenario, start, anything_fits, time_limit=0.0)
    everything = Problem(scenario, start, anything_fits, sum_rule(scenario)).reasons
    assert found.reasons == everything
    assert found.unsure == set(everything)
    assert not found.minimal
    assert not found.verified
    assert found.lines[0] == "these, or some of them, clash:"


def test_beyond_enumeration_the_planner_decides(make_scenario, monkeypatch):
    scenario, start = weak_pair(make_scenario)

    def too_large(*arguments):
        raise SearchLimitError("too large")

    monkeypatch.setattr(existence, "form", too_large)
    found = explained(scenario, start, anything_fits)
    assert found.reasons == (Demand("a1", "G!pi2"), Demand("o1", "Fpi2"), Power("o1"), Start("o1"))


def test_beyond_enumeration_starts_are_not_proven(make_scenario, monkeypatch):
    """Only the planner can tell, which cannot rule out all other starts of a member that does not matter."""
    scenario = make_scenario({"a1": (1.0, "1")}, {"o1": (1.0, "F pi2")})
    start = State(("pi1",), ("pi1",), (None,))

    def too_large(*arguments):
        raise SearchLimitError("too large")

    def nothing_fits(region, content):
        return not content.carried

    monkeypatch.setattr(existence, "form", too_large)
    found = explain_infeasible(scenario, start, nothing_fits)
    assert found.unsure == {Start("a1")}
    assert {Demand("o1", "Fpi2"), Start("o1")} <= set(found.reasons)
    assert not found.verified
    assert "together with these, or some of them:" in found.lines


@pytest.mark.parametrize(
    ("agents", "spec", "reasons"),
    [
        ("1", "G !o1.pi2", (Demand("o1", "GFpi2"), Demand("", "G!o1.pi2"))),
        ("G !pi2", "F a1.pi3", (*(Demand(f"a{i}", "G!pi2") for i in range(1, 13)), Demand("o1", "GFpi2"), Start("o1"))),
    ],
)
def test_large_teams(make_scenario, agents, spec, reasons):
    """Twelve agents, of whom any may carry; nobody can plan, all is refuted by what members can do alone."""

    def too_large(*arguments, **others):
        raise SearchLimitError("too large")

    names = [f"a{i}" for i in range(1, 13)]
    scenario = make_scenario(dict.fromkeys(names, (1.0, agents)), {"o1": (1.0, "GF pi2")}, spec=spec)
    start = State(("pi1",) * 12, ("pi1",), (None,) * 12)
    found = explain_infeasible(scenario, start, anything_fits, find_plan=too_large)
    assert found.reasons == reasons
    assert found.unsure == set(reasons)


def test_a_planner_that_gives_up_leaves_the_rest_unverified(make_scenario):
    scenario, start = weak_pair(make_scenario)

    def slow(*arguments, **others):
        raise TimeoutError("too slow")

    found = explain_infeasible(scenario, start, anything_fits, find_plan=slow)
    assert found.minimal
    assert not found.verified
    assert found.lines[-1] == "without any one of them the others alone have a plan"


def test_a_planner_that_contradicts_is_a_defect(make_scenario):
    scenario, start = weak_pair(make_scenario)

    def never(*arguments, **others):
        raise InfeasibleError("never")

    with pytest.raises(CertificateError, match="there should be a plan with only"):
        explain_infeasible(scenario, start, anything_fits, find_plan=never)


# Against the planner, subset by subset

AGENT = st.sampled_from(["G r0", "G !r1", "F r1", "GF r1", "FG r0", "X r1", "G(r0 -> X r1)", "r1", "F(r0 & r1)"])
OBJECT = st.sampled_from(["F r1", "G !r1", "GF r0", "GF r1", "X X r1", "G r0", "FG r1"])
TEAM = st.sampled_from(["G(a1.r0 -> o1.r0)", "F(a1.r1 & o1.r0)", "G !(a1.r1 & o1.r1)", "GF(a1.r0 & o1.r1)", "X o1.r1"])


@settings(deadline=None, max_examples=25)
@given(
    agent=st.lists(AGENT, max_size=2),
    obj=st.lists(OBJECT, max_size=2),
    team=st.lists(TEAM, max_size=1),
    need=st.sampled_from([1.0, 2.0]),
    tight=st.booleans(),
)
@example(agent=[], obj=["F r1"], team=[], need=2.0, tight=False)
@example(agent=["G r0"], obj=["F r1"], team=[], need=1.0, tight=True)
@example(agent=["r1"], obj=[], team=[], need=1.0, tight=True)
def test_minimal_by_every_subset(make_scenario, agent, obj, team, need, tight):
    """No proper subset clashes, judged by the planner from every start that the subset leaves open."""
    scenario = make_scenario(
        {"a1": (1.0, " & ".join(agent) or "1")}, {"o1": (need, " & ".join(obj) or "1")}, TWO, " & ".join(team) or "1"
    )
    start = State(("r0",), ("r0",), (None,))

    def fits(region, content):
        return not (tight and region.name == "r1" and content.holds)

    assume(not has_plan(scenario, start, fits))
    found = explained(scenario, start, fits)
    problem = Problem(scenario, start, fits, sum_rule(scenario))
    everywhere = [
        State((a,), (o,), (grasp,)) for a in TWO for o in TWO for grasp in (None, "o1") if grasp is None or a == o
    ]

    def possible(kept):
        relaxed = problem.with_only(kept)
        open_starts = [
            s
            for s in everywhere
            if (Start("a1") not in kept or (s.agents, s.grasps) == (start.agents, start.grasps))
            and (Start("o1") not in kept or s.objects == start.objects)
        ]
        return any(has_plan(relaxed.scenario, s, relaxed.fits, relaxed.can_carry) for s in open_starts)

    assert not possible(found.reasons)
    proper = chain.from_iterable(combinations(found.reasons, size) for size in range(len(found.reasons)))
    assert all(possible(subset) for subset in proper)
    for reason, way_out in found.without.items():
        relaxed = problem.with_only(set(found.reasons) - {reason})
        check(way_out, relaxed.scenario, way_out.states[0], relaxed.fits, relaxed.can_carry)


@settings(deadline=None, max_examples=25)
@given(agent=AGENT, obj=OBJECT, team=TEAM, need=st.sampled_from([1.0, 2.0]))
def test_feasible_starts_are_those_with_plans(make_scenario, agent, obj, team, need):
    scenario = make_scenario({"a1": (1.0, agent)}, {"o1": (need, obj)}, TWO, team)
    system = form(scenario, anything_fits, sum_rule(scenario))
    planned = [has_plan(scenario, system.state(i), anything_fits) for i in range(system.n_states)]
    np.testing.assert_array_equal(feasible_starts(scenario, system), planned)


@settings(deadline=None, max_examples=60)
@given(agents=st.tuples(AGENT, AGENT), obj=OBJECT, team=TEAM, powers=st.tuples(*[st.sampled_from([1.0, 2.0])] * 2))
@example(agents=("G r0", "GF r1"), obj="F r1", team="F a1.r0", powers=(2.0, 1.0))
@example(agents=("F r1", "GF r1"), obj="F r1", team="F a1.r0", powers=(1.0, 1.0))
def test_refutations_are_right(make_scenario, agents, obj, team, powers):
    """What is refuted has no plan, with all reasons and with some of them."""
    scenario = make_scenario(
        {f"a{i}": (power, own) for i, (power, own) in enumerate(zip(powers, agents, strict=True), 1)},
        {"o1": (3.0, obj)},
        TWO,
        team,
    )
    problem = Problem(scenario, State(("r0", "r0"), ("r0",), (None, None)), anything_fits, sum_rule(scenario))
    refutation, existing = Refutation(problem), existence.Existence(problem)
    for left_out in (*problem.reasons, None):
        kept = frozenset(problem.reasons) - {left_out}
        if refutation.refutes(kept):
            assert existing.witness(kept) is None


def test_regions_that_look_the_same_are_not_refuted(make_scenario):
    """Nobody may carry it into pi3; but pi2 offers it the same."""
    services = {"o1": {"pi2": ("dock",), "pi3": ("dock",)}}
    scenario = make_scenario({"a1": (1.0, "G !pi3")}, {"o1": (1.0, "F dock")}, services=services)
    start = State(("pi1",), ("pi1",), (None,))
    problem = Problem(scenario, start, anything_fits, sum_rule(scenario))
    assert has_plan(scenario, start, anything_fits)
    assert not Refutation(problem).refutes(frozenset(problem.reasons))


# Remarks


def test_able_teams_are_the_smallest(make_scenario):
    scenario = make_scenario({"a1": (2.0, "1"), "a2": (4.0, "1"), "a3": (3.0, "1")}, {"o1": (5.0, "1")})
    problem = Problem(scenario, State((), (), ()), anything_fits, sum_rule(scenario))
    assert able_teams(problem, "o1") == (("a1", "a2"), ("a1", "a3"), ("a2", "a3"))


@pytest.mark.parametrize(
    ("spec", "team", "entered"),
    [
        ("G !pi3", "1", {"pi1", "pi2", "pi4"}),
        ("F pi2", "G(a1.pi1 | a1.pi2)", {"pi1", "pi2"}),
        ("G pi1", "F o1.pi3", {"pi1"}),
        ("1", "G !(a1.pi1 & o1.pi1)", {"pi1", "pi2", "pi3", "pi4"}),
    ],
)
def test_where_an_agent_may_go(make_scenario, spec, team, entered):
    scenario = make_scenario({"a1": (1.0, spec)}, {"o1": (1.0, "1")}, spec=team)
    problem = Problem(scenario, State(("pi1",), ("pi2",), (None,)), anything_fits, sum_rule(scenario))
    assert {r for r in scenario.region_names if may_enter(problem, "a1", r, problem.reasons)} == entered
