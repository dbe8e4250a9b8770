"""The search for ever better lassos of growing length."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

from ortools.sat.python import cp_model

from drake_ltl.planning.bounded.conjuncts import Conjunct
from drake_ltl.planning.bounded.lassos import Lassos, Run
from drake_ltl.planning.bounded.problem import Problem
from drake_ltl.planning.bounded.reading import Letters, Reader
from drake_ltl.planning.bounded.refusals import Refusals, counting_rule
from drake_ltl.planning.bounded.standing import Standing
from drake_ltl.planning.plan import State
from drake_ltl.scenario.model import PublishedFits

FIRST_HORIZON = 6
GROWTH = 1.5
MARGIN = 4
"""The search ends when twice the best lasso's steps, and so many more, are searched to the end."""
LONGEST = 60
"""So many steps are tried at most, unless no lasso is found."""


@dataclass
class Search:
    """Keeps the best lasso and what has been learnt about contents that do not fit."""

    problem: Problem
    conjuncts: list[Conjunct]
    refusals: Refusals
    forbidden: frozenset[tuple[State, State]]
    standing: Standing
    workers: int
    seed: int
    horizon: int = FIRST_HORIZON
    best: Run | None = None
    best_cost: int = 0
    """In the problem's units."""

    def run(self) -> Run | None:
        """The best lasso found until it is proven, time is over, or no longer one seems to be better."""
        finished = False
        while self.standing.left > 0 and not self.standing.proven:
            finished = self._search_horizon(finished)
            if finished and self.best is not None and self.horizon >= 2 * len(self.best[0]) + MARGIN:
                break
            self._grow(finished)
        return self.best

    def accept(self, run: Run, cost: int) -> None:
        """A better lasso, which fits."""
        if self.best is None or cost <= self.best_cost:
            self.best, self.best_cost = run, cost
            self.standing.improve(float(cost * self.problem.unit))

    def _grow(self, finished: bool) -> None:
        longer = max(self.horizon + 1, int(self.horizon * GROWTH))
        if finished or self.best is None or longer <= min(LONGEST, 3 * len(self.best[0])):
            self.horizon = longer
        else:
            self.seed += 1

    @cached_property
    def _capacity(self) -> PublishedFits | None:
        return counting_rule(self.problem, self.refusals.fits)

    def _search_horizon(self, only_better: bool) -> bool:
        """Whether all lassos up to this length have been searched.

        Args:
            only_better: the best lasso so far is known to be the best of its length; else the search starts from it.
        """
        lassos = self._lassos(only_better)
        n_cuts = n_weak = 0
        while self.standing.left > 0:
            for cut in self.refusals.cuts[n_cuts:]:
                lassos.forbid(cut)
            for weak in self.refusals.weak[n_weak:]:
                lassos.forbid_team(weak)
            n_cuts, n_weak = len(self.refusals.cuts), len(self.refusals.weak)
            callback = _Callback(self, lassos)
            status = self._solver().solve(lassos.model, callback)
            if not callback.refused:
                return status in (cp_model.OPTIMAL, cp_model.INFEASIBLE)
        return False

    def _lassos(self, only_better: bool) -> Lassos:
        lassos = Lassos(self.problem, self.horizon, self._capacity)
        letters = Letters(lassos)
        for conjunct in self.conjuncts:
            Reader(lassos, conjunct, letters)
        for before, after in self.forbidden:
            lassos.forbid_transition(before, after)
        lassos.at_least(math.floor(self.standing.lower_bound / self.problem.unit * (1.0 - 1e-9)))
        if self.best is not None:
            lassos.limit(self.best_cost, better=only_better)
            if not only_better:
                lassos.hint(self.best)
        return lassos

    def _solver(self) -> cp_model.CpSolver:
        solver = cp_model.CpSolver()
        solver.parameters.max_time_in_seconds = max(0.01, min(self.standing.left, self._slice()))
        solver.parameters.num_workers = self.workers
        solver.parameters.random_seed = self.seed
        return solver

    def _slice(self) -> float:
        """Time for one length [s]."""
        return max(1.0, 0.15 * self.standing.time_limit)


class _Callback(cp_model.CpSolverSolutionCallback):
    """Takes each better lasso, or stops the solver at one that is refused."""

    def __init__(self, search: Search, lassos: Lassos):
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
        if self._search.standing.proven:
            self.stop_search()
