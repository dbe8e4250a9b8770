"""Bounds against the exact optimum."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from drake_ltl.errors import InfeasibleError
from drake_ltl.planning.bounded.bounds import lone_members, raise_bound
from drake_ltl.planning.bounded.counting import Counting
from drake_ltl.planning.bounded.detours import needed_ways
from drake_ltl.planning.bounded.problem import Problem
from drake_ltl.planning.bounded.standing import Standing
from drake_ltl.planning.bounded.teams import least_team
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.plan import State
from drake_ltl.planning.planner import plan
from drake_ltl.planning.power import sum_rule


def bound_of(scenario, start, can_carry=None):
    problem = Problem(scenario, start, can_carry or sum_rule(scenario), can_carry is None)
    standing = Standing(10.0, cost=math.inf)  # as if there were a plan already
    raise_bound(problem, lone_members(problem), standing)
    return standing.lower_bound


@pytest.mark.parametrize("block", range(8))
def test_never_above_the_optimum(random_problem, block):
    tight = feasible = 0
    for seed in range(30 * block, 30 * (block + 1)):
        scenario, start = random_problem(seed)
        try:
            best = plan(scenario, start, published_fits(scenario.fits)).cost
        except InfeasibleError:
            continue
        feasible += 1
        bound = bound_of(scenario, start)  # raises InfeasibleError if it were wrong
        assert bound <= best * (1.0 + 1e-9), seed
        tight += bound >= best * (1.0 - 1e-9)
    assert tight >= 0.75 * feasible  # nine of ten are, so that a bound gone weak is noticed


def test_ways_with_a_detour_as_good_are_not_missed(random_problem):
    """The programs with and without them have the same minima."""

    def all_ways(problem, members):
        every = {(a, b) for a in range(problem.n_regions) for b in range(problem.n_regions) if a != b}
        return [sorted(every if lone is None else lone.ways) for lone in members]

    fewer = compared = 0
    for seed in range(60):
        scenario, start = random_problem(seed, 4)
        scenario = replace(scenario, spec="1")  # quicker; the relaxation leaves it out anyway if it joins members
        try:
            problem = Problem(scenario, start, sum_rule(scenario), True)
            members = lone_members(problem)
        except InfeasibleError:
            continue
        both = [find(problem, members) for find in (needed_ways, all_ways)]
        bounds = [Counting(problem, members, ways).bound(20.0) for ways in both]
        assert bounds[0] == bounds[1], seed
        compared += 1
        fewer += both[0] != both[1]
    assert compared >= 20
    assert fewer >= 5


def test_the_papers_cases(case_i, case_ii):
    assert 7000.0 <= bound_of(*case_i) <= 14928.0
    assert 7000.0 <= bound_of(*case_ii) <= 7827.0


def test_each_carrier_counts(make_scenario):
    """One way of 100 m^2 for the object and for two agents; both start elsewhere, 100 m^2 away."""
    centres = {"r0": (0.0, 0.0, 0.0), "r1": (10.0, 0.0, 0.0), "r2": (20.0, 0.0, 0.0)}
    scenario = make_scenario({"a1": (1.0, "1"), "a2": (1.0, "1"), "a3": (1.0, "1")}, {"o1": (2.0, "F r2")}, centres)
    start = State(("r0", "r0", "r0"), ("r1",), (None,) * 3)
    assert bound_of(scenario, start) == 500.0


def test_a_duty_met_while_carrying_counts_once(make_scenario):
    centres = {"r0": (0.0, 0.0, 0.0), "r1": (10.0, 0.0, 0.0)}
    scenario = make_scenario({"a1": (1.0, "F r1")}, {"o1": (1.0, "F r1")}, centres)
    assert bound_of(scenario, State(("r0",), ("r0",), (None,))) == 200.0


def test_the_suffix_counts_once_however_many_rounds_the_automaton_needs(make_scenario):
    centres = {"r0": (0.0, 0.0, 0.0), "r1": (10.0, 0.0, 0.0)}
    scenario = make_scenario({"a1": (1.0, "G(r0 -> X r1) & G(r1 -> X r0) & F r1")}, {}, centres)
    assert bound_of(scenario, State(("r0",), (), (None,))) == 200.0


def test_who_can_carry_is_up_to_the_caller(make_scenario):
    centres = {"r0": (0.0, 0.0, 0.0), "r1": (10.0, 0.0, 0.0)}
    scenario = make_scenario({"a1": (1.0, "1"), "a2": (1.0, "1")}, {"o1": (1.0, "F r1")}, centres)
    start = State(("r0", "r0"), ("r0",), (None, None))
    assert bound_of(scenario, start, lambda obj, team: len(team) == 2) == 300.0
    with pytest.raises(InfeasibleError):
        bound_of(scenario, start, lambda obj, team: False)


def test_forbidden_ways_weaken_teams(make_scenario):
    """Only both agents together are strong enough, and one of them may never go there."""
    scenario = make_scenario({"a1": (1.0, "G !pi3"), "a2": (1.0, "1")}, {"o1": (2.0, "F pi3")})
    with pytest.raises(InfeasibleError, match="pi3"):
        bound_of(scenario, State(("pi1", "pi1"), ("pi1",), (None, None)))


def test_least_team(make_scenario):
    scenario = make_scenario({f"a{i}": (float(i), "1") for i in range(1, 5)}, {"o1": (6.0, "1"), "o2": (9.0, "1")})
    start = State(("pi1",) * 4, ("pi1", "pi1"), (None,) * 4)
    problem = Problem(scenario, start, sum_rule(scenario), True)
    assert [least_team(problem, [None] * 4, j, (0, 1)) for j in range(2)] == [2, 3]


def test_least_team_of_those_who_may_go(make_scenario):
    agents = {"a1": (5.0, "G !pi3"), "a2": (2.0, "1"), "a3": (2.0, "1"), "a4": (1.0, "1")}
    scenario = make_scenario(agents, {"o1": (5.0, "1")})
    problem = Problem(scenario, State(("pi1",) * 4, ("pi1",), (None,) * 4), sum_rule(scenario), True)
    agents = lone_members(problem)
    assert [least_team(problem, agents, 0, way) for way in ((0, 1), (1, 2))] == [1, 3]
