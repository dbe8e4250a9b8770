"""Plans for large teams: lassos of growing length, with a bound that holds for every length."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

from drake_ltl.errors import InfeasibleError, SearchLimitError
from drake_ltl.planning.actions import actions_between
from drake_ltl.planning.bounded.bounds import lone_members, raise_bound
from drake_ltl.planning.bounded.conjuncts import conjuncts, is_contradictory
from drake_ltl.planning.bounded.problem import Problem, Run
from drake_ltl.planning.bounded.refusals import Refusals
from drake_ltl.planning.bounded.search import Search
from drake_ltl.planning.bounded.standing import Report, Standing
from drake_ltl.planning.certificate import check, state_fault
from drake_ltl.planning.costs import path_cost, sum_of_ways
from drake_ltl.planning.fits import Fits
from drake_ltl.planning.plan import Plan, State
from drake_ltl.planning.power import CanCarry, sum_rule
from drake_ltl.scenario.formulas import global_formula
from drake_ltl.scenario.model import Scenario


def plan_bounded(
    scenario: Scenario,
    start: State,
    fits: Fits,
    *,
    can_carry: CanCarry | None = None,
    forbidden: frozenset[tuple[State, State]] = frozenset(),
    time_limit: float,
    report: Report | None = None,
    workers: int = 2,
    seed: int | None = None,
) -> Plan:
    """The cheapest plan found within a time, with a lower bound on the cost of all plans.

    Who does what in which order is annealed (`annealing`), and lassos of up to 6, 9, 13 .. steps are searched by
    OR-Tools CP-SAT. That none of some length is cheaper proves nothing about longer ones: `Plan.status` is "optimal"
    only if the relaxation (`bounds`) reaches the cost.

    Args:
        scenario: the problem; its `cost` is chi.
        start: initial state.
        fits: P_s. Taken to be monotone (see `refusals`); every plan returned fits.
        can_carry: Lambda; None takes the sum rule of the scenario's powers.
        forbidden: transitions that the plan must not use, as pairs (before, after).
        time_limit: for all of it [s]; kept but for the solver's presolve and the last check.
        report: called with each better plan and bound.
        workers: threads of the solver.
        seed: of the solver; None takes the scenario's.

    Returns:
        A plan that passed `certificate.check`. Among equal costs, fewer steps are preferred.

    Raises:
        InfeasibleError: it is proven that no lasso of any length satisfies the formula.
        SearchLimitError: nothing was found in time, and nothing proven.
    """
    if fault := state_fault(scenario, start, fits):
        raise InfeasibleError(f"the initial state is impossible: {fault}")
    if is_contradictory(scenario):
        raise InfeasibleError(f"no word at all satisfies {global_formula(scenario)}")
    problem = Problem(scenario, start, can_carry or sum_rule(scenario), can_carry is None)
    members = lone_members(problem)
    search = Search(
        problem,
        members,
        conjuncts(scenario),
        Refusals(problem, fits),
        forbidden,
        Standing(time_limit, report),
        workers=workers,
        seed=scenario.seed if seed is None else seed,
    )
    with ThreadPoolExecutor(1) as executor:
        bounds = executor.submit(raise_bound, problem, members, search.standing)
        try:
            run = search.run()
        finally:
            search.standing.stopped = True
        bounds.result()
    if run is None:
        what = f"neither a plan nor a proof that there is none after {search.standing.seconds:.1f} s"
        raise SearchLimitError(f"{what}; lassos of up to {search.horizon} steps were looked at")
    plan = _plan(problem, run, search.standing)
    check(plan, scenario, start, fits, can_carry)
    return plan


def _plan(problem: Problem, run: Run, standing: Standing) -> Plan:
    states, loop = run
    scenario, chi = problem.scenario, sum_of_ways(problem.scenario)
    whole = (*states, states[loop])
    prefix_cost, suffix_cost = path_cost(whole[: loop + 1], chi), path_cost(whole[loop:], chi)
    cost = prefix_cost + suffix_cost
    proven = standing.proven
    return Plan(
        prefix=states[:loop],
        suffix=states[loop:],
        moves=tuple(actions_between(scenario, *ends) for ends in pairwise(whole)),
        prefix_cost=prefix_cost,
        suffix_cost=suffix_cost,
        lower_bound=cost if proven else min(standing.lower_bound, cost),
        status="optimal" if proven else "feasible",
        counts=dict.fromkeys(("ts_states", "ts_transitions", "automaton_states", "automaton_edges", "product_states")),
        seconds={"total": standing.seconds},
    )
