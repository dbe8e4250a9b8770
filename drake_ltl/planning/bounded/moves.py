"""Small random changes of an agenda: the moves of simulated annealing."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache

from drake_ltl.planning.bounded.errands import Agenda, Errand, Way, visit
from drake_ltl.planning.bounded.problem import Problem
from drake_ltl.planning.bounded.routes import Routes, ways_of
from drake_ltl.planning.bounded.walks import Walk, Walker

Team = frozenset[int]
Errands = tuple[Errand, ...]

_NOISE = 0.05
"""Ways of equal cost are told apart by factors that are off by about this share."""
_WALKS = 12
"""So many walks of each object are kept to choose from."""


class Moves:
    """All that chance may do to an agenda; each move keeps the order of an object's own transports."""

    def __init__(self, problem: Problem, routes: Routes, walkers: Sequence[Walker | None], chance: random.Random):
        self._problem, self._routes, self._walkers, self._chance = problem, routes, walkers, chance
        self._carries = lru_cache(maxsize=None)(problem.carries)
        self._walks: dict[int, list[Walk]] = {}

    def first(self) -> Agenda | None:
        """Objects go their own cheapest walks in any order, agents visit what their own formulas ask for.

        None if no team is found for some way.
        """
        agenda: Agenda = (), ()
        for j in range(self._problem.n_objects):
            transports = self._transports(j, self._walk(j), ())
            if transports is None:
                return None
            agenda = self._merged(agenda, transports)
        for visits in self._visits:
            agenda = self._merged(agenda, visits)
        return agenda

    def any(self, agenda: Agenda) -> tuple[Agenda, Iterable[int]] | None:
        """Another agenda, and the agents whose errands differ; None if the move makes no sense."""
        phase = int(self._chance.random() * (len(agenda[0]) + len(agenda[1])) >= len(agenda[0]))
        errands = agenda[phase]
        if not errands:
            return None
        at, kind = self._chance.randrange(len(errands)), self._chance.random()
        errand = errands[at]
        if kind > 0.96:
            return self._sent(agenda, phase)
        if errand.object is None and kind < 0.15:
            return self._moved(agenda, phase, at), errand.team
        if kind < 0.45:
            return self._with(agenda, phase, self._shifted(errands, at)), errand.team
        if errand.object is None:
            return self._with(agenda, phase, errands[:at] + errands[at + 1 :]), errand.team
        if kind < 0.93:
            changed = self._changed(errands, at)
            if changed is None:
                return None
            new, affected = changed
            return self._with(agenda, phase, new), affected
        return self._rewalked(agenda, errand)

    def _with(self, agenda: Agenda, phase: int, errands: Errands) -> Agenda:
        return (agenda[0], errands) if phase else (errands, agenda[1])

    # ---- order

    def _shifted(self, errands: Errands, at: int) -> Errands:
        """One errand earlier or later, but not past another transport of its object."""
        errand = errands[at]
        rest = errands[:at] + errands[at + 1 :]
        low = high = at
        while low > 0 and (errand.object is None or rest[low - 1].object != errand.object):
            low -= 1
        while high < len(rest) and (errand.object is None or rest[high].object != errand.object):
            high += 1
        to = self._chance.randint(low, high)
        return (*rest[:to], errand, *rest[to:])

    def _sent(self, agenda: Agenda, phase: int) -> tuple[Agenda, Iterable[int]]:
        """Somebody goes somewhere, perhaps out of the way."""
        agent, region = self._chance.randrange(self._problem.n_agents), self._chance.randrange(self._problem.n_regions)
        errands, at = agenda[phase], self._chance.randint(0, len(agenda[phase]))
        return self._with(agenda, phase, (*errands[:at], visit(agent, region), *errands[at:])), (agent,)

    def _moved(self, agenda: Agenda, phase: int, at: int) -> Agenda:
        """A visit of the prefix in the suffix, or the other way round."""
        errands, other = agenda[phase], list(agenda[1 - phase])
        other.insert(self._chance.randint(0, len(other)), errands[at])
        less = errands[:at] + errands[at + 1 :]
        return (tuple(other), less) if phase else (less, tuple(other))

    def _merged(self, agenda: Agenda, more: Agenda) -> Agenda:
        phases = []
        for old, new in zip(agenda, more, strict=True):
            errands = list(old)
            places = sorted(self._chance.randint(0, len(old)) for _ in new)
            for extra, (place, errand) in enumerate(zip(places, new, strict=True)):
                errands.insert(place + extra, errand)
            phases.append(tuple(errands))
        return phases[0], phases[1]

    # ---- teams

    def _changed(self, errands: Errands, at: int) -> tuple[Errands, Team] | None:
        """Other teams for a transport and some that follow it, or for all of its object's."""
        errand, chance = errands[at], self._chance
        mine = [n for n in range(len(errands)) if errands[n].object == errand.object]
        run = mine
        if chance.random() >= 0.3:
            first = mine.index(at)
            run = mine[first : first + chance.randint(1, len(mine))]
        kind = chance.random()
        change = self._exchange(errand) if kind < 0.75 else self._same(errand, anew=kind >= 0.9)
        affected: Team = frozenset()
        changed = list(errands)
        for n in run:
            team = change(errands[n])
            if team is not None and team != errands[n].team:
                changed[n] = replace(errands[n], team=team)
                affected |= team ^ errands[n].team
        return (tuple(changed), affected) if affected else None

    def _exchange(self, errand: Errand) -> Callable[[Errand], Team | None]:
        """Somebody for somebody else."""
        leaves = self._chance.choice(sorted(errand.team))
        joins = self._chance.randrange(self._problem.n_agents)
        completes = self._chance.random() < 0.3

        def change(other: Errand) -> Team | None:
            if leaves not in other.team or joins in other.team or not self._routes.may_go(joins, other.way):
                return None
            team = (other.team - {leaves}) | {joins}
            if not self._carries(other.object, team):
                return self._team(other.object, other.way, team) if completes else None
            return self._pruned(other.object, team)

        return change

    def _same(self, errand: Errand, *, anew: bool) -> Callable[[Errand], Team | None]:
        """The same team for all, that of the first or any."""
        team = self._team(errand.object, errand.way) if anew else errand.team

        def change(other: Errand) -> Team | None:
            return team if team and all(self._routes.may_go(i, other.way) for i in team) else None

        return change

    def _team(self, obj: int, way: Way, some: Team = frozenset()) -> Team | None:
        """Any team that can carry an object along a way, with nobody in vain except perhaps those given."""
        able = [i for i in range(self._problem.n_agents) if i not in some and self._routes.may_go(i, way)]
        if not some and self._problem.strong_teams is not None:
            strong = [team for team in self._problem.strong_teams[obj] if team <= set(able)]
            return self._pruned(obj, self._chance.choice(strong)) if strong else None
        team = some
        for i in self._chance.sample(able, len(able)):
            if self._carries(obj, team):
                break
            team |= {i}
        return self._pruned(obj, team) if self._carries(obj, team) else None

    def _pruned(self, obj: int, team: Team) -> Team:
        for i in self._chance.sample(sorted(team), len(team)):
            if len(team) > 1 and self._carries(obj, team - {i}):
                team -= {i}
        return team

    # ---- walks

    def _walk(self, obj: int) -> Walk:
        """One of an object's own walks of about least cost."""
        walker, known = self._walkers[self._problem.n_agents + obj], self._walks.setdefault(obj, [])
        if walker is None:
            return (), ()
        if len(known) < _WALKS and (not known or self._chance.random() < 0.5):
            known.append(walker.cheapest(self._noisy()))
        return self._chance.choice(known)

    def _noisy(self) -> Callable[[int, int], float]:
        regions = range(self._problem.n_regions)
        factor = [[math.exp(self._chance.gauss(0.0, _NOISE)) for _ in regions] for _ in regions]
        return lambda a, b: factor[a][b] * self._routes.costs[a][b]

    def _transports(self, obj: int, walk: Walk, known: Iterable[Errand]) -> Agenda | None:
        """A walk with teams: that of a known transport the same way, or else the last one if it may go there."""
        teams = {errand.way: errand.team for errand in known}
        phases, at, team = [], self._problem.starts[self._problem.n_agents + obj], frozenset[int]()
        for regions in walk:
            errands = []
            for way in ways_of(at, regions):
                team = teams.get(way, team)
                if not team or not all(self._routes.may_go(i, way) for i in team):
                    found = self._team(obj, way)
                    if found is None:
                        return None
                    team = found
                errands.append(Errand(*way, team, obj))
                at = way[1]
            phases.append(tuple(errands))
        return phases[0], phases[1]

    def _rewalked(self, agenda: Agenda, errand: Errand) -> tuple[Agenda, Iterable[int]] | None:
        """The errand's object on another walk."""
        known = [other for errands in agenda for other in errands if other.object == errand.object]
        transports = self._transports(errand.object, self._walk(errand.object), known)
        if transports is None:
            return None
        rest = tuple(tuple(e for e in errands if e.object != errand.object) for errands in agenda)
        affected = {i for other in (*known, *transports[0], *transports[1]) for i in other.team}
        return self._merged((rest[0], rest[1]), transports), affected

    @cached_property
    def _visits(self) -> list[Agenda]:
        """Of each agent with a formula of its own, as few as its cheapest walk alone needs, all in the suffix."""
        return [
            self._needed(i, walker.cheapest(lambda a, b: self._routes.costs[a][b]))
            for i, walker in enumerate(self._routes.walkers[: self._problem.n_agents])
            if walker is not None
        ]

    def _needed(self, agent: int, walk: Walk) -> Agenda:
        agenda: Agenda = (), tuple(visit(agent, k) for regions in walk for k in regions)
        cost = self._routes.trip(agent, agenda)[0]
        for at in reversed(range(len(agenda[1]))):
            less: Agenda = (), agenda[1][:at] + agenda[1][at + 1 :]
            if self._routes.trip(agent, less)[0] <= cost:
                agenda, cost = less, self._routes.trip(agent, less)[0]
        return agenda
