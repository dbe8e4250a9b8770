"""Errands, routes, timetables and annealing: whatever chance makes of them must obey Def. 5."""

from __future__ import annotations

import math
import random
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_ltl.planning.bounded.annealing import Annealing
from drake_ltl.planning.bounded.bounds import lone_members
from drake_ltl.planning.bounded.crowding import Crowding
from drake_ltl.planning.bounded.errands import Errand, agenda_of, visit
from drake_ltl.planning.bounded.moves import Moves
from drake_ltl.planning.bounded.problem import Problem
from drake_ltl.planning.bounded.routes import MOVE, Routes, errands_cost
from drake_ltl.planning.bounded.timetable import timetable
from drake_ltl.planning.bounded.walks import Walker
from drake_ltl.planning.certificate import transition_fault
from drake_ltl.planning.plan import State
from drake_ltl.planning.power import sum_rule
from drake_ltl.planning.words import letter_of, satisfies
from drake_ltl.scenario.formulas import global_formula
from drake_ltl.scenario.model import PublishedFits

CENTRES = {"r0": (0.0, 0.0, 0.0), "r1": (10.0, 0.0, 0.0), "r2": (20.0, 0.0, 0.0), "r3": (10.0, 10.0, 0.0)}


def anything_fits(region, content):
    return True


def parts_of(scenario, start, seed=0):
    """The problem, its routes and moves."""
    problem = Problem(scenario, start, sum_rule(scenario), True)
    members = lone_members(problem)
    routes = Routes(problem, members)
    walkers = [None if lone is None else Walker(lone) for lone in members]
    return problem, routes, Moves(problem, routes, walkers, random.Random(seed))


def team_problem(make_scenario):
    """Four agents, two of them with formulas of their own, and two objects that two or three can carry."""
    agents = {"a0": (2.0, "GF r3"), "a1": (3.0, "G !r3"), "a2": (2.0, "1"), "a3": (1.0, "1")}
    objects = {"o0": (4.0, "GF r0 & GF r2"), "o1": (3.0, "F r3 & GF r1")}
    scenario = make_scenario(agents, objects, CENTRES)
    return scenario, State(("r0", "r1", "r2", "r2"), ("r1", "r0"), (None,) * 4)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6), n_moves=st.integers(0, 60), together=st.booleans())
def test_timetables_of_any_agenda_obey_the_transition_system(make_scenario, seed, n_moves, together):
    scenario, start = team_problem(make_scenario)
    problem, routes, moves = parts_of(scenario, start, seed)
    agenda = moves.first()
    for _ in range(n_moves):
        changed = moves.any(agenda)
        agenda = agenda if changed is None else changed[0]
    states, loop = timetable(problem, routes, agenda, together=together)
    assert states[0] == start
    run = (*states, states[loop])
    for before, after in pairwise(run):
        assert transition_fault(scenario, before, after, anything_fits, sum_rule(scenario)) is None
    trips = [routes.trip(i, agenda) for i in range(4)]
    wrong = [i for i, walker in enumerate(routes.walkers[:4]) if walker and not walker.accepts(routes.walk(i, agenda))]
    if wrong:
        return
    expected = errands_cost(routes, agenda) + sum(cost for cost, _ in trips)
    assert expected // MOVE == problem.cost(run)
    word = [letter_of(scenario, state) for state in states]
    assert satisfies(global_formula(scenario), word[:loop], word[loop:])


def test_a_move_names_all_agents_whose_errands_it_changes(make_scenario):
    scenario, start = team_problem(make_scenario)
    _, routes, moves = parts_of(scenario, start)
    agenda = moves.first()
    for _ in range(500):
        changed = moves.any(agenda)
        if changed is None:
            continue
        new, affected = changed
        for i in set(range(4)) - set(affected):
            assert routes.trip(i, new) == routes.trip(i, agenda)
        agenda = new


def test_agendas_of_timetables_give_them_back(make_scenario):
    scenario, start = team_problem(make_scenario)
    problem, routes, moves = parts_of(scenario, start)
    states, loop = timetable(problem, routes, moves.first())
    again, loop_again = timetable(problem, routes, agenda_of(problem, (states, loop)))
    costs = [problem.cost((*s, s[k])) for s, k in ((states, loop), (again, loop_again))]
    assert costs[0] == costs[1]


def test_who_grasps_at_the_start_releases_or_carries(make_scenario):
    scenario = make_scenario({"a0": (1.0, "1"), "a1": (1.0, "1")}, {"o0": (1.0, "F r1")}, CENTRES)
    start = State(("r0", "r0"), ("r0",), ("o0", "o0"))
    problem, routes, _ = parts_of(scenario, start)
    agenda = (Errand(0, 1, frozenset({0}), 0),), ()
    states, loop = timetable(problem, routes, agenda)
    for before, after in pairwise((*states, states[loop])):
        assert transition_fault(scenario, before, after, anything_fits, sum_rule(scenario)) is None
    assert states[loop].objects == ("r1",)


def test_routes_keep_to_ways_that_the_own_formula_allows(make_scenario):
    scenario = make_scenario({"a0": (1.0, "G !r1"), "a1": (1.0, "1")}, {}, CENTRES)
    _, routes, _ = parts_of(scenario, State(("r0", "r0"), (), (None, None)))
    agenda = (), (visit(0, 2), visit(1, 2))
    assert routes.path(1, 0, 2) == [1, 2]
    assert 1 not in routes.path(0, 0, 2)
    assert routes.trip(1, agenda)[0] // MOVE == 200  # there once, and it stays
    assert routes.trip(0, agenda)[0] // MOVE == 400


@pytest.mark.parametrize(
    ("spec", "walk", "holds"),
    [
        ("GF r1 & GF r2", ((), (1, 2, 0)), True),
        ("GF r1 & GF r2", ((2,), (1,)), False),
        ("FG r1", ((2, 1), ()), True),
        ("FG r1", ((1,), (2, 1)), False),
        ("F r2 & GF r1", ((), (2, 1)), True),
        ("G(r1 -> F r2)", ((1,), ()), False),
        ("G !r1", ((2,), (1, 2)), False),
    ],
)
def test_own_walks_are_judged(make_scenario, spec, walk, holds):
    scenario = make_scenario({"a0": (1.0, spec)}, {}, CENTRES)
    problem = Problem(scenario, State(("r0",), (), (None,)), sum_rule(scenario), True)
    walker = Walker(lone_members(problem)[0])
    assert walker.accepts(walk) == holds


@pytest.mark.parametrize("spec", ["GF r1 & GF r2", "FG r1", "F r2 & GF r1", "G(r0 -> F r2)", "G !r1 & F r3"])
def test_cheapest_walks_are_accepted_and_no_dearer_than_others(make_scenario, spec):
    scenario = make_scenario({"a0": (1.0, spec)}, {}, CENTRES)
    problem = Problem(scenario, State(("r0",), (), (None,)), sum_rule(scenario), True)
    walker, costs = Walker(lone_members(problem)[0]), problem.integer_ways()

    def cost(walk):
        return sum(costs[a][b] for a, b in pairwise((0, *walk[0], *walk[1])))

    best = walker.cheapest(lambda a, b: costs[a][b])
    assert walker.accepts(best)
    chance = random.Random(spec)
    for _ in range(300):
        prefix = [chance.randrange(4) for _ in range(chance.randint(0, 3))]
        suffix = [chance.randrange(4) for _ in range(chance.randint(0, 4))]
        end = prefix[-1] if prefix else 0
        walk = tuple(prefix), (*suffix, end) if suffix else ()
        if walker.accepts(walk):
            assert cost(best) <= cost(walk)


def test_crowding_counts_bodies_where_an_object_leaves_or_arrives(make_scenario):
    scenario = make_scenario({f"a{i}": (1.0, "1") for i in range(3)}, {"o0": (1.0, "F r1")}, CENTRES)
    problem = Problem(scenario, State(("r0", "r0", "r1"), ("r0",), (None,) * 3), sum_rule(scenario), True)
    agenda = (Errand(0, 1, frozenset({0}), 0),), ()
    rule = PublishedFits(agent=1.0, grasping=2.0, object=0.5, capacity=3.0)
    # 2 + 1 + 0.5 where it leaves, 2 + 1 + 0.5 where it arrives
    assert Crowding(problem, rule).excess(agenda, [1, 0, 1]) == pytest.approx(1.0)
    roomy = PublishedFits(agent=1.0, grasping=2.0, object=0.5, capacity=3.5)
    assert Crowding(problem, roomy).excess(agenda, [1, 0, 1]) == 0.0


def test_annealing_ends_at_the_best_order(make_scenario):
    """o0 goes from r0 to r2; the agent at r1 is of no use to it, and the two at r0 carry it all the way: 3 x 200."""
    scenario = make_scenario({"a0": (1.0, "1"), "a1": (1.0, "1"), "a2": (1.0, "1")}, {"o0": (2.0, "F r2")}, CENTRES)
    start = State(("r1", "r0", "r0"), ("r0",), (None,) * 3)
    problem = Problem(scenario, start, sum_rule(scenario), True)
    annealing = Annealing(problem, lone_members(problem), None, random.Random(1))
    best, least = None, math.inf

    def offer(run):
        nonlocal best, least
        states, loop = run
        cost = problem.cost((*states, states[loop]))
        if cost < least:
            best, least = run, cost
            return True
        return False

    for _ in range(4):
        assert annealing.round(best, least if best else 0, offer, lambda: False)
    assert least == 600
