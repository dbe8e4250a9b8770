"""Simulated annealing of agendas.

What constraint models find hard in large teams is who does what and in which order; where to be at each step follows.
So chance changes orders, teams and walks (`moves`), and each agenda that costs less than the best lasso is made a
lasso (`timetable`) and offered as such. Formulas that speak of several members, and what fits, are judged then.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable, Sequence
from statistics import median

from drake_ltl.planning.bounded.alone import Alone
from drake_ltl.planning.bounded.crowding import Crowding
from drake_ltl.planning.bounded.errands import Agenda, agenda_of
from drake_ltl.planning.bounded.moves import Moves
from drake_ltl.planning.bounded.problem import Problem, Run
from drake_ltl.planning.bounded.routes import MOVE, Routes, errands_cost
from drake_ltl.planning.bounded.timetable import timetable
from drake_ltl.planning.bounded.walks import Walker
from drake_ltl.scenario.model import PublishedFits

FIRST_MOVES, LEAST_MOVES = 500, 5000
"""Moves of the first round, for each errand, and at least;"""
GROWTH = 1.6
"""each round has so many times more."""
HOTTEST, WARM, COLDEST = 2.0, 0.5, 0.05
"""Temperatures at the beginning of a round from chance or from the best agenda, and at the end, as multiples of what
going to the next region costs."""
CROWD = 1.0
"""What one agent too many costs where an object leaves or arrives, in the same measure."""
MOST_REFUSED = 100
"""A round ends when so many agendas were refused."""

Offer = Callable[[Run], bool]
"""Takes a lasso if it is one and better than the best."""


class Annealing:
    """Rounds of annealing, each longer than the one before."""

    def __init__(
        self, problem: Problem, members: Sequence[Alone | None], rule: PublishedFits | None, chance: random.Random
    ):
        """Find routes and walks.

        Args:
            problem: the problem.
            members: from `lone_members`.
            rule: what fits, if that is a matter of counting.
            chance: decides everything.
        """
        self._problem, self._routes, self._chance = problem, Routes(problem, members), chance
        walkers = [None if lone is None else Walker(lone) for lone in members]
        self._moves = Moves(problem, self._routes, walkers, chance)
        self._crowding = None if rule is None else Crowding(problem, rule)
        self._n_rounds = 0
        nearest = [min((c for b, c in enumerate(row) if b != a), default=0) for a, row in enumerate(self._routes.costs)]
        self._degree = median(nearest)

    def round(self, best: Run | None, best_cost: int, offer: Offer, is_over: Callable[[], bool]) -> bool:
        """One round, from chance and from the best lasso in turn; False if there is nothing to change.

        Args:
            best: the best lasso so far, if any.
            best_cost: what it costs, in the problem's units.
            offer: called with lassos that cost less.
            is_over: whether to stop.
        """
        self._n_rounds += 1
        agenda = self._moves.first() if best is None or self._n_rounds % 2 else None
        heat = HOTTEST if agenda is not None else WARM
        if agenda is None and best is not None:
            agenda = agenda_of(self._problem, best)
        n_errands = 0 if agenda is None else len(agenda[0]) + len(agenda[1])
        if agenda is None or not self._degree:
            return False
        bar = math.inf if best is None else best_cost * MOVE
        trips = [self._routes.trip(i, agenda) for i in range(self._problem.n_agents)]
        state = _State(self._routes, agenda, trips)
        if state.cost < bar and self._offered(agenda, offer):
            bar = state.cost - state.cost % MOVE
        if n_errands:
            n_moves = int(max(LEAST_MOVES, FIRST_MOVES * n_errands) * GROWTH ** (self._n_rounds // 2))
            self._cool(state, n_moves, heat, bar, offer, is_over)
        return n_errands > 0

    def _cool(
        self, state: _State, n_moves: int, heat: float, bar: float, offer: Offer, is_over: Callable[[], bool]
    ) -> None:
        """Accept what is worse ever less often (Metropolis).

        An agenda below the bar that is refused is not gone on with, unless nothing at all has been taken so far.
        """
        refused, pause, crowd = 0, 0, self._crowd(state)
        for n in range(n_moves):
            if n % 64 == 0:
                temperature = self._degree * heat * (COLDEST / heat) ** (n / n_moves)
                if is_over() or refused > MOST_REFUSED:
                    return
            changed = self._moves.any(state.agenda)
            if changed is None:
                continue
            new = state.changed(*changed)
            most = state.cost + crowd - temperature * math.log(1.0 - self._chance.random())
            if new.cost > most:
                continue
            new_crowd = self._crowd(new)
            if new.cost + new_crowd > most:
                continue
            if new.cost < bar and not new_crowd and n >= pause:
                if self._offered(new.agenda, offer):
                    bar = new.cost - new.cost % MOVE  # with fewer moves it is not offered again
                else:
                    refused += 1
                    if bar < math.inf:
                        continue
                    pause = n + n_moves // MOST_REFUSED
            state, crowd = new, new_crowd

    def _crowd(self, state: _State) -> float:
        """What it costs that regions are too full."""
        if self._crowding is None:
            return 0.0
        return self._degree * CROWD * self._crowding.excess(state.agenda, state.meetings)

    def _offered(self, agenda: Agenda, offer: Offer) -> bool:
        return any(offer(timetable(self._problem, self._routes, agenda, together=t)) for t in (True, False))


class _State:
    """An agenda with what it costs."""

    def __init__(self, routes: Routes, agenda: Agenda, trips: Sequence[tuple[int, int]]):
        self._routes, self.agenda, self._trips = routes, agenda, trips
        self.cost = sum([cost for cost, _ in trips]) + errands_cost(routes, agenda)

    @property
    def meetings(self) -> list[int]:
        """Where each agent is when the suffix begins."""
        return [meeting for _, meeting in self._trips]

    def changed(self, agenda: Agenda, affected: Iterable[int]) -> _State:
        """With another agenda, in which only some agents' errands differ."""
        trips = list(self._trips)
        for i in affected:
            trips[i] = self._routes.trip(i, agenda)
        return _State(self._routes, agenda, trips)
