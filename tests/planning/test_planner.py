"""Plans: the paper's costs, and nothing better found by trying every lasso."""

from __future__ import annotations

import zlib
from dataclasses import replace
from functools import cache
from itertools import pairwise

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from drake_ltl.errors import InfeasibleError, InvalidInputError
from drake_ltl.planning import models, planner, rounds, search
from drake_ltl.planning.certificate import check, transition_fault
from drake_ltl.planning.costs import sum_of_ways
from drake_ltl.planning.factored import search as factored
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.plan import State
from drake_ltl.planning.planner import plan
from drake_ltl.planning.power import sum_rule
from drake_ltl.planning.transition_system import form
from drake_ltl.planning.words import letter_of
from drake_ltl.scenario.formulas import global_formula
from drake_ltl.spot_support import require_spot


def anything_fits(region, content):
    return True


@pytest.mark.parametrize(
    ("case", "prefix_cost", "suffix_cost", "moves", "counts"),
    [
        ("case_i", 10080.0, 4848.0, 22, (560, 7680, 7, 29, 3920)),
        ("case_ii", 4941.0, 2886.0, 10, (3112, 160504, 9, 59, 28008)),
    ],
)
def test_the_papers_cases(case, prefix_cost, suffix_cost, moves, counts, request):
    scenario, start = request.getfixturevalue(case)
    found = plan(scenario, start, published_fits(scenario.fits))
    assert (found.prefix_cost, found.suffix_cost) == (prefix_cost, suffix_cost)
    assert found.cost == found.lower_bound
    assert found.status == "optimal"
    assert len(found.moves) == moves
    assert tuple(found.counts.values()) == counts
    assert set(found.seconds) == {"transition_system", "automaton", "search", "total"}


def test_case_ii_does_what_table_2_does(case_ii):
    scenario, start = case_ii
    found = plan(scenario, start, published_fits(scenario.fits))
    kinds = {(action.kind, action.agents, action.object) for actions in found.moves for action in actions}
    assert ("transport", ("a2", "a3"), "o2") in kinds
    assert ("transport", ("a1", "a3"), "o1") in kinds
    assert ("release", ("a3",), "o2") in kinds
    assert [a.kind for actions in found.moves[found.loop :] for a in actions] == ["transport", "transport"]


# Lassos by brute force


def steps_of(actions):
    return sum(len(action.agents) for action in actions)


class Oracle:
    """All lassos of a small TS, made by Def. 5's clauses and judged by Spot alone."""

    def __init__(self, scenario, start, fits, can_carry, chi, weights=(1.0, 1.0), seen=()):
        self.weights, self.seen = weights, seen
        spot = require_spot()
        formula = spot.formula(global_formula(scenario))
        self.wrong = spot.formula.Not(formula).translate()
        self.names = sorted(ap.ap_name() for ap in spot.atomic_prop_collect(formula))
        self.spot, self.start, self.chi, self.scenario = spot, start, chi, scenario
        system = form(scenario, fits, can_carry)  # checked against the clauses in test_transition_system
        states = [system.state(i) for i in range(system.n_states)]
        self.successors = {
            before: [s for s in states if transition_fault(scenario, before, s, fits, can_carry) is None]
            for before in states
        }
        self.satisfied = cache(self._satisfied)

    def _satisfied(self, prefix, cycle):
        def literals(letter):
            return " & ".join(n if n in letter else f"!{n}" for n in self.names) or "1"

        text = "".join(literals(x) + "; " for x in prefix) + "cycle{" + "; ".join(map(literals, cycle)) + "}"
        return not self.spot.parse_word(text).as_automaton().intersects(self.wrong)

    def effort(self, before, after):
        ways = zip(before.agents, before.grasps, after.agents, after.grasps, strict=True)
        return sum((a, g) != (b, h) for a, g, b, h in ways)

    def best(self, most_moves, worth=(float("inf"),)):
        """The least (cost, moves, actions) of lassos with a number of moves, below `worth`; else None."""
        best = None
        alpha, beta = self.weights
        stack = [((self.start,), (0.0,), 0)]
        while stack:
            run, ways, efforts = stack.pop()
            for after in self.successors[run[-1]]:
                onwards = (*ways, ways[-1] + self.chi(run[-1], after))
                effort = efforts + self.effort(run[-1], after)
                if min(alpha, beta) * onwards[-1] > worth[0]:
                    continue
                for loop, state in enumerate(run):
                    cost = alpha * onwards[loop] + beta * (onwards[-1] - onwards[loop])
                    value = cost, len(run), effort
                    if state == after and value < worth and self._holds(run, loop):
                        best = worth = value
                if len(run) < most_moves:
                    stack.append(((*run, after), onwards, effort))
        return best

    def _holds(self, run, loop):
        word = tuple(letter_of(self.scenario, state) & set(self.names) for state in (*self.seen, *run))
        return self.satisfied(word[: len(self.seen) + loop], word[len(self.seen) + loop :])


def formulas(names):
    atoms = st.sampled_from(names).flatmap(lambda name: st.sampled_from([name, f"!{name}"]))
    return st.recursive(
        atoms,
        lambda inner: st.one_of(
            st.tuples(st.sampled_from(["X", "F", "G", "GF", "FG", "!"]), inner).map(lambda x: f"{x[0]}({x[1]})"),
            st.tuples(inner, st.sampled_from(["&", "|", "U", "R", "->"]), inner).map(
                lambda x: f"({x[0]}) {x[1]} ({x[2]})"
            ),
        ),
        max_leaves=5,
    )


def assert_nothing_is_better(scenario, start, fits, can_carry, chi, most_moves, weights=(1.0, 1.0), seen=()):
    """The plan is at least as good as every lasso of up to `most_moves` moves; it is certified itself."""
    oracle = Oracle(scenario, start, fits, can_carry, chi, weights, seen)
    alpha, beta = weights
    try:
        found = plan(scenario, start, fits, can_carry=can_carry, chi=chi, alpha=alpha, beta=beta, seen=seen)
    except InfeasibleError:
        assert oracle.best(most_moves) is None
        return
    assert found.status == "optimal"
    value = found.cost, len(found.moves), sum(map(steps_of, found.moves))
    assert oracle.best(most_moves, worth=value) is None


def ways(table):
    """chi from a table of small integers, zeros among them, so that equal costs are frequent."""

    def chi(before, after):
        moved = zip(before.agents + before.objects, after.agents + after.objects, strict=True)
        return float(sum(table[int(a[1:])][int(b[1:])] for a, b in moved if a != b))

    return chi


tables = st.lists(st.lists(st.sampled_from([0, 0, 1, 1, 2, 3]), min_size=3, max_size=3), min_size=3, max_size=3)
UNIT = [[1, 1, 1]] * 3
FREE = [[0, 0, 0]] * 3


@settings(deadline=None, max_examples=60)
@given(spec=formulas(["r0", "r1", "r2"]), table=tables)
@example(spec="G(r0 -> X r1) & G(r1 -> X r0) & F r1", table=UNIT)  # the loop settles after one round
@example(spec="F(r1 & X(r0 & F r1)) & G(r0 -> X r1) & G(r1 -> X r0)", table=UNIT)  # after two rounds
@example(spec="GF r1 & GF r2 & GF r0", table=[[0, 1, 3], [3, 0, 1], [1, 3, 0]])  # one direction is cheaper
@example(spec="GF r1 & GF r2 & GF r0", table=[[0, 3, 1], [1, 0, 3], [3, 1, 0]])
@example(spec="FG r1 & F r2", table=UNIT)  # no deterministic automaton
@example(spec="FG r1 | GF r2 & GF !r2", table=FREE)
@example(spec="GF(r1 & X r2) & GF(r2 & X r1)", table=UNIT)
@example(spec="G(r0 | r1) & GF r1", table=FREE)
@example(spec="G !r1 & F r1", table=UNIT)
@example(spec="G !r1", table=UNIT)
@example(spec="!r0", table=UNIT)
@example(spec="1", table=FREE)
def test_one_agent_against_all_lassos(make_scenario, spec, table):
    centres = {f"r{k}": (10.0 * k, 0.0, 0.0) for k in range(3)}
    scenario = make_scenario({"a1": (1.0, spec)}, {}, centres)
    start = State(("r0",), (), (None,))
    assert_nothing_is_better(scenario, start, anything_fits, sum_rule(scenario), ways(table), 6)


@settings(deadline=None, max_examples=40)
@given(
    agent=formulas(["r0", "r1"]),
    obj=formulas(["r0", "r1"]),
    table=tables,
    salt=st.integers(0, 10**6),
    refusals=st.integers(0, 2),
)
@example(agent="GF r0 & GF r1", obj="GF r0 & GF r1", table=FREE, salt=0, refusals=0)
@example(agent="F r1 & X X r0", obj="F r1", table=UNIT, salt=0, refusals=0)
@example(agent="GF r0", obj="FG r1", table=UNIT, salt=0, refusals=0)
def test_agent_and_object_against_all_lassos(make_scenario, agent, obj, table, salt, refusals):
    centres = {f"r{k}": (10.0 * k, 0.0, 0.0) for k in range(2)}
    scenario = make_scenario({"a1": (1.0, agent)}, {"o1": (1.0, obj)}, centres)

    def fits(region, content):
        empty = not content.holds and not content.carried  # the start is possible
        return empty or zlib.crc32(repr((salt, region.name, content)).encode()) % 8 >= refusals

    start = State(("r0",), ("r0",), (None,))
    assert_nothing_is_better(scenario, start, fits, sum_rule(scenario), ways(table), 6)


@settings(deadline=None, max_examples=15)
@given(first=formulas(["r0", "r1"]), second=formulas(["r0", "r1"]), spec=formulas(["a1.r0", "a2.r1"]), table=tables)
@example(first="GF r0", second="GF r1", spec="GF(a1.r1 & a2.r1) & GF(a1.r0 & a2.r0)", table=UNIT)
@example(first="1", second="1", spec="G(a1.r0 -> X a2.r1) & GF a1.r0 & GF a2.r0", table=UNIT)
def test_two_agents_against_all_lassos(make_scenario, first, second, spec, table):
    centres = {f"r{k}": (10.0 * k, 0.0, 0.0) for k in range(2)}
    scenario = make_scenario({"a1": (1.0, first), "a2": (1.0, second)}, {}, centres, spec)
    start = State(("r0", "r1"), (), (None, None))
    assert_nothing_is_better(scenario, start, anything_fits, sum_rule(scenario), ways(table), 5)


@settings(deadline=None, max_examples=40)
@given(
    spec=formulas(["r0", "r1", "r2"]),
    table=tables,
    weights=st.tuples(st.sampled_from([0.0, 1.0, 3.0]), st.sampled_from([0.0, 1.0, 2.5])),
    seen=st.lists(st.sampled_from(["r0", "r1", "r2"]), max_size=3),
)
@example(spec="F r1 & GF r2", table=UNIT, weights=(0.0, 1.0), seen=[])  # what is settled once costs nothing
@example(spec="F r1 & GF r2", table=UNIT, weights=(1.0, 0.0), seen=[])
@example(spec="F r1 & X r2", table=UNIT, weights=(1.0, 1.0), seen=["r1", "r2"])  # all done before
@example(spec="G(r1 -> X r2) & GF r0", table=UNIT, weights=(1.0, 1.0), seen=["r1"])  # too late
@example(spec="FG r1 | X FG r2", table=UNIT, weights=(1.0, 1.0), seen=["r0", "r1"])  # a choice is still open
def test_weights_and_what_was_seen_against_all_lassos(make_scenario, spec, table, weights, seen):
    centres = {f"r{k}": (10.0 * k, 0.0, 0.0) for k in range(3)}
    scenario = make_scenario({"a1": (1.0, spec)}, {}, centres)
    start, *past = (State((region,), (), (None,)) for region in ("r0", *seen))
    arguments = anything_fits, sum_rule(scenario), ways(table), 5
    assert_nothing_is_better(scenario, start, *arguments, weights=weights, seen=past)


def test_replanning_on_the_way_costs_what_is_left(case_ii):
    """The rest of an optimal plan is optimal, wherever in its prefix one asks again."""
    scenario, start = case_ii
    found = plan(scenario, start, published_fits(scenario.fits))
    chi, fits = sum_of_ways(scenario), published_fits(scenario.fits)
    for step in range(found.loop + 1):
        again = plan(scenario, found.states[step], fits, seen=found.states[:step])
        passed = sum(chi(*ends) for ends in pairwise(found.states[: step + 1]))
        assert again.cost == found.cost - passed


@pytest.mark.parametrize("weights", [{"alpha": -1.0}, {"beta": float("nan")}, {"alpha": float("inf")}])
def test_weights_that_are_none_are_refused(case_i, weights):
    scenario, start = case_i
    with pytest.raises(InvalidInputError, match="at least zero"):
        plan(scenario, start, published_fits(scenario.fits), **weights)


def test_what_was_seen_must_be_of_the_scenario(case_i):
    scenario, start = case_i
    with pytest.raises(InvalidInputError, match="pi9"):
        plan(scenario, start, published_fits(scenario.fits), seen=[replace(start, agents=("pi9", "pi1"))])


def test_a_loop_of_ts_may_settle_after_its_first_round(make_scenario):
    """No product node recurs after one round from the start, yet start, suffix, suffix .. satisfies the formula."""
    centres = {f"r{k}": (10.0 * k, 0.0, 0.0) for k in range(2)}
    scenario = make_scenario({"a1": (1.0, "G(r0 -> X r1) & G(r1 -> X r0) & F r1")}, {}, centres)
    found = plan(scenario, State(("r0",), (), (None,)), anything_fits)
    assert found.prefix == ()
    assert (found.prefix_cost, found.suffix_cost) == (0.0, 200.0)


# Where the exact search would be too large


@pytest.mark.parametrize("spec", ["GF r0 & GF r1 & GF r2", "FG r1 & GF !r1 | GF r0 & GF r1", "GF(r0 & X r1) & GF r2"])
def test_limits_cost_the_proof_not_the_plan(make_scenario, spec, monkeypatch):
    centres = {"r0": (0.0, 0.0, 0.0), "r1": (10.0, 0.0, 0.0), "r2": (4.0, 9.0, 0.0)}
    scenario = make_scenario({"a1": (1.0, spec)}, {}, centres)
    start = State(("r0",), (), (None,))
    best = plan(scenario, start, anything_fits)
    monkeypatch.setattr(rounds, "FEW_LAYERED_EDGES", -1)
    monkeypatch.setattr(search, "MOST_LAYERS", 0)
    monkeypatch.setattr(search, "MOST_PROFILES", 0)
    found = plan(scenario, start, anything_fits)
    check(found, scenario, start, anything_fits)
    assert found.status == "feasible"
    assert found.lower_bound <= best.cost <= found.cost


@pytest.mark.parametrize(
    ("case", "most_edges", "status"),
    [("case_i", 500, "optimal"), ("case_i", 100, "feasible"), ("case_ii", 3000, "optimal")],
)
def test_loops_are_shared_out_where_they_are_many(case, most_edges, status, request, monkeypatch):
    scenario, start = request.getfixturevalue(case)
    fits = published_fits(scenario.fits)
    best = plan(scenario, start, fits)
    monkeypatch.setattr(rounds, "FEW_LAYERED_EDGES", -1)
    monkeypatch.setattr(search, "MOST_LAYERED_EDGES", most_edges)
    found = plan(scenario, start, fits, system=form(scenario, fits, sum_rule(scenario)))
    assert found.status == status
    assert found.lower_bound <= best.cost <= found.cost
    if status == "optimal":
        assert (found.cost, len(found.moves)) == (best.cost, len(best.moves))


def test_what_the_list_cannot_prove_is_proven_without(case_ii, monkeypatch):
    """Where bounds leave few nodes there are few loops."""
    scenario, start = case_ii
    fits = published_fits(scenario.fits)
    monkeypatch.setattr(search, "MOST_LAYERED_EDGES", 500)
    assert plan(scenario, start, fits, system=form(scenario, fits, sum_rule(scenario))).status == "feasible"
    found = plan(scenario, start, fits)
    assert (found.status, found.cost, len(found.moves)) == ("optimal", 7827.0, 10)


def test_what_is_too_much_without_a_list_is_listed(case_i, monkeypatch):
    scenario, start = case_i
    monkeypatch.setattr(models, "MOST_LISTED", 0)
    monkeypatch.setattr(factored, "MOST_NODES", 0)
    found = plan(scenario, start, published_fits(scenario.fits))
    assert (found.status, found.cost, found.counts["ts_transitions"]) == ("optimal", 14928.0, 7680)


# Variations


def test_names_do_not_matter(case_i):
    scenario, start = case_i
    names = {"pi1": "home", "pi2": "dock", "pi3": "yard", "pi4": "shed"}

    def renamed(formula):
        for old, new in names.items():
            formula = formula.replace(old, new)
        return formula

    other = replace(
        scenario,
        regions=tuple(replace(r, name=names[r.name]) for r in reversed(scenario.regions)),
        agents=tuple(replace(a, name=f"z_{a.name}", spec=renamed(a.spec)) for a in reversed(scenario.agents)),
        objects=tuple(replace(o, name=f"b_{o.name}", spec=renamed(o.spec)) for o in reversed(scenario.objects)),
    )
    there = State(
        tuple(names[region] for region in reversed(start.agents)),
        tuple(names[region] for region in reversed(start.objects)),
        (None, None),
    )
    found = plan(scenario, start, published_fits(scenario.fits))
    same = plan(other, there, published_fits(other.fits))
    assert (same.cost, len(same.moves)) == (found.cost, len(found.moves))
    assert same.counts == found.counts


def test_the_same_problem_gives_the_same_plan(case_ii):
    scenario, start = case_ii
    first, second = (plan(scenario, start, published_fits(scenario.fits)) for _ in range(2))
    assert first == second


def test_services_are_what_formulas_speak_of(make_scenario):
    scenario = make_scenario({"a1": (1.0, "GF charge")}, {}, services={"a1": {"pi4": ("charge", "rest")}})
    found = plan(scenario, State(("pi1",), (), (None,)), anything_fits)
    assert found.suffix == (State(("pi4",), (), (None,)),)


def test_forbidden_transitions_are_avoided(make_scenario):
    scenario = make_scenario({"a1": (1.0, "F pi3 & GF pi2")}, {})
    start, far, goal = (State((region,), (), (None,)) for region in ("pi1", "pi3", "pi2"))
    system = form(scenario, anything_fits, sum_rule(scenario))
    direct = plan(scenario, start, anything_fits, system=system)
    assert direct.states == (start, far, start, goal)  # squared distances favour the way over pi1
    forbidden = frozenset({(start, far)})
    around = plan(scenario, start, anything_fits, forbidden=forbidden, system=system)
    assert (start, far) not in pairwise(around.states)
    assert around.cost > direct.cost
    assert around.counts == direct.counts  # those of Def. 5
    fewer = system.without(forbidden)
    assert plan(scenario, start, anything_fits, system=fewer) == around
    assert plan(scenario, start, anything_fits, system=fewer).counts == direct.counts
    everywhere = frozenset((state, far) for state in (start, goal, State(("pi4",), (), (None,))))
    with pytest.raises(InfeasibleError, match="3 transitions excluded"):
        plan(scenario, start, anything_fits, forbidden=everywhere, system=system)


def test_who_can_carry_is_up_to_the_caller(make_scenario):
    scenario = make_scenario({"a1": (1.0, "1"), "a2": (1.0, "1")}, {"o1": (2.0, "F pi2")})
    start = State(("pi1", "pi1"), ("pi1",), (None, None))

    def teams(found):
        return {a.agents for actions in found.moves for a in actions if a.kind == "transport"}

    assert teams(plan(scenario, start, anything_fits)) == {("a1", "a2")}
    second = plan(scenario, start, anything_fits, can_carry=lambda obj, team: team == {"a2"})
    assert teams(second) == {("a2",)}
    with pytest.raises(InfeasibleError, match="formula of o1"):
        plan(scenario, start, anything_fits, can_carry=lambda obj, team: False)


def test_chi_is_up_to_the_caller(make_scenario):
    scenario = make_scenario({"a1": (1.0, "F pi3")}, {})
    start, goal = (State((region,), (), (None,)) for region in ("pi1", "pi3"))

    def tolls(before, after):
        return 100.0 if (before, after) == (start, goal) else 1.0  # waiting costs as much as moving

    found = plan(scenario, start, anything_fits, chi=tolls)
    assert (found.cost, len(found.moves)) == (3.0, 3)
    assert goal in found.states


def test_distance_is_a_cost_too(make_scenario):
    scenario = make_scenario({"a1": (1.0, "F pi3")}, {}, cost="distance")
    found = plan(scenario, State(("pi1",), (), (None,)), anything_fits)
    assert found.cost == pytest.approx(500.0**0.5, rel=1e-15)
    assert sum_of_ways(scenario)(found.states[0], found.states[1]) == found.cost


def test_transports_need_room_for_the_team(make_scenario):
    """The direct way to pi3 is closed to a carried object, though the states at both ends exist."""
    scenario = make_scenario({"a1": (1.0, "1")}, {"o1": (1.0, "FG pi3")})

    def fits(region, content):
        return not (region.name == "pi3" and content.carried)

    with pytest.raises(InfeasibleError, match="formula of o1"):
        plan(scenario, State(("pi1",), ("pi1",), (None,)), fits)


# Why there is no plan


@pytest.mark.parametrize(
    ("agent", "obj", "spec", "reason"),
    [
        ("G pi1 & F !pi1", "1", "1", "no word at all satisfies the formula of a1"),
        ("1", "F(pi1 & pi2)", "1", "no run from the initial state satisfies the formula of o1"),
        ("1", "1", "G a1.pi3", "no run from the initial state satisfies the global formula"),
        ("F pi2", "1", "G !a1.pi2", "no word at all satisfies the formulas together"),
        ("G pi1", "F pi2", "1", "no run from the initial state satisfies the formulas together"),
    ],
)
def test_reasons(make_scenario, agent, obj, spec, reason):
    scenario = make_scenario({"a1": (1.0, agent)}, {"o1": (1.0, obj)}, spec=spec)
    with pytest.raises(InfeasibleError, match=reason):
        plan(scenario, State(("pi1",), ("pi1",), (None,)), anything_fits)


def test_an_impossible_start_is_named(case_i):
    scenario, _ = case_i
    crowd = State(("pi1", "pi1"), ("pi1", "pi1"), ("o1", "o1"))
    with pytest.raises(InfeasibleError, match="pi1 has no room for o1, o2, a1 grasping o1, a2 grasping o1"):
        plan(scenario, crowd, published_fits(scenario.fits))


def test_every_plan_is_checked(case_i, monkeypatch):
    seen = []
    monkeypatch.setattr(planner, "check", lambda *arguments: seen.append(arguments[0]))
    scenario, start = case_i
    assert [plan(scenario, start, published_fits(scenario.fits))] == seen
