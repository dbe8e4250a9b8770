"""Plans for large teams: lassos of growing length, with a bound that holds for every length."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise

from ortools.sat.python import cp_model

from drake_ltl.errors import InfeasibleError, SearchLimitError
from drake_ltl.planning.actions import actions_between
from drake_ltl.planning.bounded.conjuncts import Conjunct, conjuncts, is_contradictory
from drake_ltl.planning.bounded.lassos import Lassos, Run
from drake_ltl.planning.bounded.problem import Problem
from drake_ltl.planning.bounded.reading import Letters, Reader
from drake_ltl.planning.bounded.refusals import Refusals, counting_rule
from drake_ltl.planning.certificate import check, state_fault
from drake_ltl.planning.costs import path_cost, sum_of_ways
from drake_ltl.planning.fits import Fits
from drake_ltl.planning.plan import Plan, State
from drake_ltl.planning.power import CanCarry, sum_rule
from drake_ltl.scenario.formulas import global_formula
from drake_ltl.scenario.model import Scenario

FIRST_HORIZON = 6
GROWTH = 1.5
MARGIN = 4
"""The search ends when twice the best lasso's steps, and so many more, are searched to the end."""


@dataclass(frozen=True)
class Progress:
    """How far the search has come."""

    seconds: float
    cost: float | None
    """Of the best plan so far."""
    lower_bound: float
    """No plan of any length costs less."""
    horizon: int
    """Lassos of up to so many steps are being searched."""

    @property
    def gap(self) -> float | None:
        """What a cheaper plan could save at most, as a share of the cost; None without a plan."""
        if self.cost is None:
            return None
        return max(0.0, 1.0 - self.lower_bound / self.cost) if self.cost else 0.0


Report = Callable[[Progress], None]


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

    Lassos of up to 6, 9, 13 .. steps are searched by OR-Tools CP-SAT. That none of some length is cheaper proves
    nothing about longer ones: `Plan.status` is "optimal" only if the relaxation (`counting`) reaches the cost.

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
    search = _Search(
        problem,
        Refusals(problem, fits),
        conjuncts(scenario),
        forbidden,
        report,
        workers,
        scenario.seed if seed is None else seed,
        time_limit,
    )
    plan = search.run()
    check(plan, scenario, start, fits, can_carry)
    return plan


@dataclass
class _Search:
    problem: Problem
    refusals: Refusals
    conjuncts: list[Conjunct]
    forbidden: frozenset[tuple[State, State]]
    report: Report | None
    workers: int
    seed: int
    time_limit: float
    began: float = field(default_factory=time.perf_counter)
    best: Run | None = None
    best_cost: int = 0
    """In the problem's units."""
    lower_bound: float = 0.0
    horizon: int = FIRST_HORIZON

    @property
    def seconds(self) -> float:
        return time.perf_counter() - self.began

    @property
    def left(self) -> float:
        return self.time_limit - self.seconds

    @property
    def proven(self) -> bool:
        return self.best is not None and self.best_cost * self.problem.unit <= self.lower_bound * (1 + 1e-9)

    def run(self) -> Plan:
        while self.left > 0 and not self.proven:
            finished = self._search_horizon()
            if finished and self.best is not None and self.horizon >= 2 * len(self.best[0]) + MARGIN:
                break
            self.horizon = max(self.horizon + 1, int(self.horizon * GROWTH))
        if self.best is None:
            what = f"neither a plan nor a proof that there is none after {self.seconds:.1f} s"
            raise SearchLimitError(f"{what}; lassos of up to {self.horizon} steps were looked at")
        return self._plan(self.best)

    def _search_horizon(self) -> bool:
        """Whether all lassos up to this length have been searched."""
        capacity = counting_rule(self.problem, self.refusals.fits)
        lassos = Lassos(self.problem, self.horizon, capacity)
        letters = Letters(lassos)
        for conjunct in self.conjuncts:
            Reader(lassos, conjunct, letters)
        for before, after in self.forbidden:
            lassos.forbid_transition(before, after)
        if self.best is not None:
            lassos.limit(self.best_cost, better=True)
        n_cuts = n_weak = 0
        while self.left > 0:
            for cut in self.refusals.cuts[n_cuts:]:
                lassos.forbid(cut)
            for weak in self.refusals.weak[n_weak:]:
                lassos.forbid_team(weak)
            n_cuts, n_weak = len(self.refusals.cuts), len(self.refusals.weak)
            solver = cp_model.CpSolver()
            solver.parameters.max_time_in_seconds = max(0.01, min(self.left, self._slice()))
            solver.parameters.num_workers = self.workers
            solver.parameters.random_seed = self.seed
            callback = _Callback(self, lassos)
            status = solver.solve(lassos.model, callback)
            if not callback.refused:
                return status in (cp_model.OPTIMAL, cp_model.INFEASIBLE)
            if self.best is not None:
                lassos.limit(self.best_cost, better=True)
        return False

    def _slice(self) -> float:
        """Time for one length: short as long as there is no plan at all."""
        return max(1.0, self.time_limit * (0.15 if self.best is None else 0.4))

    def accept(self, run: Run, cost: int) -> None:
        self.best, self.best_cost = run, cost
        if self.report:
            self.report(Progress(self.seconds, float(cost * self.problem.unit), self.lower_bound, self.horizon))

    def _plan(self, run: Run) -> Plan:
        states, loop = run
        scenario, chi = self.problem.scenario, sum_of_ways(self.problem.scenario)
        whole = (*states, states[loop])
        prefix_cost, suffix_cost = path_cost(whole[: loop + 1], chi), path_cost(whole[loop:], chi)
        cost = prefix_cost + suffix_cost
        return Plan(
            prefix=states[:loop],
            suffix=states[loop:],
            moves=tuple(actions_between(scenario, *ends) for ends in pairwise(whole)),
            prefix_cost=prefix_cost,
            suffix_cost=suffix_cost,
            lower_bound=cost if self.proven else min(self.lower_bound, cost),
            status="optimal" if self.proven else "feasible",
            counts=dict.fromkeys(
                ("ts_states", "ts_transitions", "automaton_states", "automaton_edges", "product_states")
            ),
            seconds={"total": self.seconds},
        )


class _Callback(cp_model.CpSolverSolutionCallback):
    """Takes each better lasso, or stops the solver at one that is refused."""

    def __init__(self, search: _Search, lassos: Lassos):
        super().__init__()
        self._search, self._lassos = search, lassos
        self.refused = False

    def on_solution_callback(self) -> None:
        run = self._lassos.run(self.value)
        if self._search.refusals.find(run):
            self.refused = True
            self.stop_search()
            return
        self._search.accept(run, self._lassos.cost(self.objective_value))
        if self._search.proven:
            self.stop_search()
