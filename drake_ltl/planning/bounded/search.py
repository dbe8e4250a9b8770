"""The search for ever better lassos: by chance where teams are large, by constraint models of growing length."""

from __future__ import annotations

import random
import threading
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

from ortools.sat.python import cp_model

from drake_ltl.planning.bounded.alone import Alone
from drake_ltl.planning.bounded.annealing import Annealing
from drake_ltl.planning.bounded.conjuncts import Conjunct
from drake_ltl.planning.bounded.cuts import forbid, forbid_team, forbid_transition
from drake_ltl.planning.bounded.lassos import Lassos
from drake_ltl.planning.bounded.polish import SIZE, neighbourhood, stretched
from drake_ltl.planning.bounded.problem import Problem, Run
from drake_ltl.planning.bounded.reading import Letters, Reader
from drake_ltl.planning.bounded.refusals import Refusals, counting_rule
from drake_ltl.planning.bounded.standing import Standing
from drake_ltl.planning.bounded.tidying import shortened, tidied
from drake_ltl.planning.bounded.translation import around, hint, run_of
from drake_ltl.planning.plan import State
from drake_ltl.planning.words import letter_of
from drake_ltl.scenario.model import PublishedFits

FIRST_HORIZON = 6
GROWTH = 1.5
"""Lengths are tried in this ratio until a lasso is found,"""
MOST_GROWTH = 5
"""but no longer than so many times the longest length that is known to have none; then from the beginning,"""
STRETCHES = (1.3, 1.7, 2.2, 3.0)
"""then these multiples of the best lasso's length, again and again with more patience."""
PATIENCE = 0.05
"""A length is given up when nothing better was found for this share of the time limit, and at least a second."""
FIRST_PATIENCE = 0.25
"""The same while there is no plan at all."""
SLACK = 0.7
"""So much longer is a lasso made before its parts are improved."""
MISSES = 10
"""Parts of a lasso are improved until this many in a row cannot be."""
LARGEST_MODEL = 30_000
"""Constraint models are not tried beyond so many ways: steps times members times pairs of regions."""
TIDYING, MOST_TIDYING = 0.05, 5.0
"""Share of the time limit that is kept for tidying up, and the most of it [s]."""
MARGIN = 4
"""The search ends when twice the best lasso's steps, and so many more, are searched to the end."""


@dataclass
class Search:
    """Keeps the best lasso and what has been learnt about contents that do not fit."""

    problem: Problem
    members: list[Alone | None]
    """From `lone_members`."""
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
    searched: int = 0
    """All lassos of up to so many steps have been searched: none is better than the best."""
    patience: float = 1.0
    """Multiple of the usual patience."""

    def run(self) -> Run | None:
        """The best lasso found until it is proven, time is over, or no longer one seems to be better."""
        self._anneal()
        while self.best is None and self._left > 0:
            self._search_horizon()
            self.horizon = max(self.horizon + 1, int(self.horizon * GROWTH))
            if self.horizon > MOST_GROWTH * max(FIRST_HORIZON, self.searched):
                self.horizon, self.patience = self.searched + FIRST_HORIZON, 2.0 * self.patience
                self._anneal()
        self.patience = 1.0
        while self.best is not None and not self._is_over():
            for stretch in STRETCHES:
                self._anneal()
                if not self._is_over():
                    self._search_longer(stretch)
            self.patience *= 2.0
            self.seed += 1
        return self.best and self._tidied(self.best)

    def _search_longer(self, stretch: float) -> None:
        """Lassos of up to a multiple of the best one's length, and parts of it, if the models are not too large."""
        step = len(self.problem.members) * self.problem.n_regions**2
        if step * FIRST_HORIZON > LARGEST_MODEL:
            return
        self.best = self._tidied(self.best)
        self.horizon = max(int(len(self.best[0]) * stretch) + 1, self.searched + 1)
        if step * self.horizon > LARGEST_MODEL:
            return
        self._search_horizon()
        if not self._is_over() and self.searched < self.horizon:
            self._polish(self.best)

    def _anneal(self) -> None:
        """Rounds of annealing until patience ends; two in a row without gain, from chance and from the best, end it."""
        end, idle = self.standing.seconds + self._seconds(), 0
        while idle < 2 and not self._is_over() and self.standing.seconds < end:
            before = self.best_cost, self.best
            if not self._annealing.round(self.best, self.best_cost, self._offer, self._is_over):
                return
            idle = idle + 1 if before == (self.best_cost, self.best) else 0

    @cached_property
    def _annealing(self) -> Annealing:
        return Annealing(self.problem, self.members, self._capacity, random.Random(self.seed))

    def _offer(self, run: Run) -> bool:
        """Take a lasso that is not known to be one, if it is and costs less."""
        states, loop = run
        cost = self.problem.cost((*states, states[loop]))
        if self.best is not None and cost >= self.best_cost:
            return False
        return self._is_lasso(run) and self.accept(run, cost)

    def _is_lasso(self, run: Run) -> bool:
        """Whether a run fits, avoids what is forbidden and satisfies the formulas."""
        states, loop = run
        if not self.refusals.allows(run):
            return False
        if self.forbidden and not self.forbidden.isdisjoint(pairwise((*states, states[loop]))):
            return False
        word = [letter_of(self.problem.scenario, state) for state in states]
        return all(conjunct.accepts(word[:loop], word[loop:]) for conjunct in self.conjuncts)

    @property
    def _left(self) -> float:
        """Time for searching; what is left after it is for tidying up."""
        return self.standing.left - min(MOST_TIDYING, TIDYING * self.standing.time_limit)

    def _is_over(self) -> bool:
        enough = self.best is not None and self.searched >= 2 * len(self.best[0]) + MARGIN
        return self._left <= 0 or self.standing.proven or enough

    def accept(self, run: Run, cost: int) -> bool:
        """Take a lasso that fits; whether it is better than the best so far."""
        value = cost, len(run[0])
        if self.best is not None and value >= (self.best_cost, len(self.best[0])):
            return False
        self.best, self.best_cost = run, cost
        self.standing.improve(float(cost * self.problem.unit))
        return True

    @cached_property
    def _capacity(self) -> PublishedFits | None:
        return counting_rule(self.problem, self.refusals.fits)

    def _search_horizon(self) -> None:
        """Search lassos of up to `horizon` steps, with ever more cuts, until all are searched or patience ends."""
        lassos = self._lassos()
        while self._left > 0:
            n_cuts, n_weak = len(self.refusals.cuts), len(self.refusals.weak)
            solver = self._solver()
            with _Callback(self, lassos, solver, self._seconds()) as callback:
                status = solver.solve(lassos.model, callback)
            if status == cp_model.INFEASIBLE or (status == cp_model.OPTIMAL and lassos.costs and not callback.refused):
                self.searched = max(self.searched, self.horizon)
            if not callback.refused:
                return
            self._forbid(lassos, n_cuts, n_weak)

    def _forbid(self, lassos: Lassos, n_cuts: int = 0, n_weak: int = 0) -> None:
        for cut in self.refusals.cuts[n_cuts:]:
            forbid(lassos, cut)
        for weak in self.refusals.weak[n_weak:]:
            forbid_team(lassos, weak)

    def _polish(self, best: Run) -> None:
        """Improve parts of a lasso that has time to spare, until several in a row are as good as they get."""
        run = stretched(best, int(len(best[0]) * (1.0 + SLACK)) + 1)
        self.horizon = len(run[0])
        lassos, chance, misses, size = self._lassos(), random.Random(self.seed), 0, SIZE
        while misses < MISSES and not self._is_over():
            lassos.limit(self.best_cost, better=True)
            model = around(lassos, run, *neighbourhood(self.problem, run, chance, size))
            solver = self._solver()
            with _Callback(self, lassos, solver, self._seconds()) as callback:
                status = solver.solve(model, callback)
            if callback.refused:
                lassos = self._lassos()
            misses += 1
            size = max(0, size - 1) if status == cp_model.UNKNOWN else size + int(status == cp_model.INFEASIBLE)
            if status in (cp_model.OPTIMAL, cp_model.FEASIBLE) and not callback.refused and self.best:
                run, misses = self.best, 0
        if self.best:
            self.best = shortened(self.best, self._is_lasso)

    def _tidied(self, run: Run) -> Run:
        names, is_step = self.problem.scenario.object_names, self.refusals.allows_step
        return tidied(names, run, self._is_lasso, is_step, lambda: self.standing.left <= 0)

    def _lassos(self) -> Lassos:
        lassos = Lassos(self.problem, self.horizon, self._capacity, costs=self.best is not None)
        letters = Letters(lassos)
        for conjunct in self.conjuncts:
            Reader(lassos, conjunct, letters)
        for before, after in self.forbidden:
            forbid_transition(lassos, before, after)
        self._forbid(lassos)
        if self.best is not None:
            # If the best is the best of its length, nothing is gained by finding it again.
            settled = self.searched >= len(self.best[0])
            lassos.limit(self.best_cost, better=settled)
            if not settled:
                hint(lassos, self.best)
        return lassos

    def _solver(self) -> cp_model.CpSolver:
        solver = cp_model.CpSolver()
        solver.parameters.max_time_in_seconds = max(0.01, self._left)
        solver.parameters.num_workers = self.workers
        solver.parameters.random_seed = self.seed
        return solver

    def _seconds(self) -> float:
        """How long to wait for something better."""
        share = PATIENCE if self.best is not None else FIRST_PATIENCE
        return self.patience * max(1.0, share * self.standing.time_limit)


class _Callback(cp_model.CpSolverSolutionCallback):
    """Takes each better lasso; stops the solver at one that is refused, or when patience ends."""

    def __init__(self, search: Search, lassos: Lassos, solver: cp_model.CpSolver, seconds: float):
        super().__init__()
        self._search, self._lassos, self._solver, self._seconds = search, lassos, solver, seconds
        self._timer: threading.Timer | None = None
        self.refused = False

    def __enter__(self) -> _Callback:
        self._wait()
        return self

    def __exit__(self, *_: object) -> None:
        if self._timer:
            self._timer.cancel()

    def _wait(self) -> None:
        if self._timer:
            self._timer.cancel()
        self._timer = threading.Timer(self._seconds, self._solver.stop_search)
        self._timer.daemon = True
        self._timer.start()

    def on_solution_callback(self) -> None:
        run = run_of(self._lassos, self.value)
        if self._search.refusals.find(run):
            self.refused = True
            self.stop_search()
            return
        states, loop = run
        if self._search.accept(run, self._search.problem.cost((*states, states[loop]))):
            self._wait()
        if self._search.standing.proven:
            self.stop_search()
