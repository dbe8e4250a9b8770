"""Bounded plans against explicit ones."""

from __future__ import annotations

import sys
import zlib
from itertools import combinations, pairwise

import pytest

from drake_ltl.errors import InfeasibleError, SearchLimitError
from drake_ltl.planning.bounded import plan_bounded
from drake_ltl.planning.certificate import check
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.plan import State
from drake_ltl.planning.planner import plan


def anything_fits(region, content):
    return True


def assert_agrees(scenario, start, fits, time_limit, **options):
    """Never better than the optimum, never proven wrongly; as good, unless the optimum is much longer."""
    try:
        best = plan(scenario, start, fits, **options)
    except InfeasibleError:
        with pytest.raises((InfeasibleError, SearchLimitError)):
            plan_bounded(scenario, start, fits, time_limit=1.0, **options)
        return "infeasible"
    found = plan_bounded(scenario, start, fits, time_limit=time_limit, **options)
    check(found, scenario, start, fits, options.get("can_carry"))
    assert found.lower_bound <= best.cost * (1.0 + 1e-9)
    assert found.cost >= best.cost * (1.0 - 1e-9)
    if found.status == "optimal" or len(best.moves) <= 2 * len(found.moves) + 4:
        assert found.cost == pytest.approx(best.cost, rel=1e-9)
    return found.status


@pytest.mark.parametrize("block", range(5))
def test_random_problems(random_problem, block):
    seeds = range(1000 + 8 * block, 1008 + 8 * block)
    for seed in seeds:
        scenario, start = random_problem(seed)
        assert_agrees(scenario, start, published_fits(scenario.fits), 4.0)


def test_case_ii(case_ii):
    scenario, start = case_ii
    reports = []
    found = plan_bounded(scenario, start, published_fits(scenario.fits), time_limit=6.0, report=reports.append)
    assert found.cost == 7827.0
    assert found.status == "feasible"  # the relaxation cannot prove it
    assert 7000.0 <= found.lower_bound <= 7827.0
    assert reports[-1].cost == 7827.0
    for before, after in pairwise(reports):
        assert before.lower_bound <= after.lower_bound
        assert before.cost is None or after.cost <= before.cost
        assert before.seconds <= after.seconds
    assert 0.0 <= reports[-1].gap <= 0.11


@pytest.mark.parametrize(
    "spec",
    [
        "1",
        "G !r2",
        "!r1",
        "F r2",
        "X X r2",
        "GF r1 & GF r2",
        "FG r1 & F r2",
        "GF(r1 & X r2) & GF(r2 & X r1)",
        "G(r0 -> X r1) & G(r1 -> X r0) & F r1",
        "F(r1 & X(r0 & F r1)) & G(r0 -> X r1) & G(r1 -> X r0)",
        "GF r1 -> GF r2",
        "F(r1 & X r1 & X X r1) & GF r0",
    ],
)
def test_single_formulas_are_solved_and_proven(make_scenario, spec):
    """X, safety alone, waiting at no cost, loops that settle after several rounds."""
    centres = {"r0": (0.0, 0.0, 0.0), "r1": (10.0, 0.0, 0.0), "r2": (4.0, 9.0, 0.0)}
    scenario = make_scenario({"a1": (1.0, spec)}, {}, centres)
    status = assert_agrees(scenario, State(("r0",), (), (None,)), anything_fits, 5.0)
    assert status == "optimal" or "X" in spec  # where a loop settles late, the relaxation may be weaker


@pytest.mark.parametrize("spec", ["G !r1 & F r1", "F(r1 & r2)", "!r0", "X X !r0 & G r0"])
def test_what_one_member_cannot_do_is_proven(make_scenario, spec):
    centres = {"r0": (0.0, 0.0, 0.0), "r1": (10.0, 0.0, 0.0), "r2": (4.0, 9.0, 0.0)}
    scenario = make_scenario({"a1": (1.0, spec)}, {}, centres)
    with pytest.raises(InfeasibleError):
        plan_bounded(scenario, State(("r0",), (), (None,)), anything_fits, time_limit=5.0)


def test_too_little_time_is_no_proof(make_scenario):
    """The two may not be in pi3 together, which no member's own formula says."""
    scenario = make_scenario({"a1": (1.0, "1"), "a2": (1.0, "1")}, {}, spec="F(a1.pi3 & a2.pi3)")
    start = State(("pi1", "pi1"), (), (None, None))

    def fits(region, content):
        return region.name != "pi3" or len(content.free_agents) < 2

    with pytest.raises(InfeasibleError):
        plan(scenario, start, fits)
    with pytest.raises(SearchLimitError, match="neither a plan nor a proof"):
        plan_bounded(scenario, start, fits, time_limit=1.0)


@pytest.mark.parametrize("salt", range(4))
def test_any_monotone_predicate(make_scenario, salt):
    """Contents are refused if they contain a pair of bodies that chance refuses, carried or not."""
    centres = {f"r{k}": (7.0 * k, float(k * k), 0.0) for k in range(3)}
    scenario = make_scenario({"a1": (1.0, "GF r1"), "a2": (1.0, "1")}, {"o1": (1.0, "F r2 & GF r0")}, centres)
    start = State(("r0", "r1"), ("r1",), (None, None))

    def fits(region, content):
        bodies = [*content.free_agents, *(f"{a} at {o}" for a, o in content.holds), *content.objects]
        bodies += [f"{o} carried" for o in sorted(content.carried)]
        pairs = combinations(sorted(bodies), 2)
        bad = (zlib.crc32(f"{salt} {region.name} {pair}".encode()) % 8 == 0 for pair in pairs if pair != ("a2", "o1"))
        return not any(bad)

    assert_agrees(scenario, start, fits, 4.0)


def test_forbidden_transitions_are_avoided(make_scenario):
    scenario = make_scenario({"a1": (1.0, "F pi3 & GF pi2")}, {})
    start, far = State(("pi1",), (), (None,)), State(("pi3",), (), (None,))
    found = plan_bounded(scenario, start, anything_fits, forbidden=frozenset({(start, far)}), time_limit=3.0)
    assert (start, far) not in pairwise(found.states)
    assert_agrees(scenario, start, anything_fits, 3.0, forbidden=frozenset({(start, far)}))


@pytest.mark.parametrize("team", [{"a2"}, {"a1", "a2"}])
def test_who_can_carry_is_up_to_the_caller(make_scenario, team):
    scenario = make_scenario({"a1": (1.0, "1"), "a2": (1.0, "1")}, {"o1": (9.0, "F pi2")})
    start = State(("pi1", "pi1"), ("pi1",), (None, None))
    options = {"can_carry": lambda obj, those: those == team}
    assert assert_agrees(scenario, start, anything_fits, 3.0, **options) == "optimal"


def test_ties_go_to_fewer_steps(make_scenario):
    scenario = make_scenario({"a1": (1.0, "F pi2")}, {})
    found = plan_bounded(scenario, State(("pi1",), (), (None,)), anything_fits, time_limit=3.0)
    assert len(found.moves) == len(plan(scenario, State(("pi1",), (), (None,)), anything_fits).moves)


def test_a_start_that_does_not_fit(case_i):
    scenario, start = case_i
    with pytest.raises(InfeasibleError, match="initial state"):
        plan_bounded(scenario, start, lambda region, content: False, time_limit=1.0)


def test_a_team_too_large_to_enumerate(monkeypatch):
    """Ten agents and four objects: a plan that passes the certificate, with an honest bound."""
    monkeypatch.syspath_prepend("benchmarks")
    monkeypatch.delitem(sys.modules, "ring", raising=False)
    from ring import ring

    scenario, start = ring(10, 4, 6)
    found = plan_bounded(scenario, start, published_fits(scenario.fits), time_limit=6.0)
    assert 0.0 < found.lower_bound <= found.cost
