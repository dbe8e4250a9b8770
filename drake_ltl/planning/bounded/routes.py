"""What agents do between their errands: they go the cheapest way."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from drake_ltl.planning.bounded.alone import Alone
from drake_ltl.planning.bounded.errands import Agenda, Errand, Way
from drake_ltl.planning.bounded.problem import Problem
from drake_ltl.planning.bounded.walks import Walk, Walker

BLOCKED, WRONG = 100, 10
"""What cannot be is not excluded but dear, as multiples of the dearest way: to go where no way leads, and a walk that
violates the agent's own formula. So annealing can pass through it, and does not stay."""
MOVE = 10**4
"""Costs are counted in this part of the problem's unit, and each way one more: fewer moves are better."""


class Routes:
    """Cheapest ways of each agent along the ways it may go."""

    def __init__(self, problem: Problem, members: Sequence[Alone | None]):
        """Find them for all agents.

        Args:
            problem: the problem.
            members: from `lone_members`.
        """
        self.costs = [[MOVE * cost + 1 for cost in row] for row in problem.integer_ways()]
        self._dearest = max((cost for row in self.costs for cost in row), default=1)
        self._regions, self._starts = range(problem.n_regions), problem.starts
        every = frozenset((a, b) for a in self._regions for b in self._regions if a != b)
        self._ways = [every if lone is None else frozenset(lone.ways) for lone in members]
        known = {ways: self._cheapest(ways) for ways in set(self._ways[: problem.n_agents])}
        tables = [known[ways] for ways in self._ways[: problem.n_agents]]
        self._distance, self._next = [d for d, _ in tables], [n for _, n in tables]
        self._towards = [[list(column) for column in zip(*d, strict=True)] for d in self._distance]
        walkers = [None if lone is None else Walker(lone) for lone in members]
        self.walkers = [None if walker is None or walker.is_free else walker for walker in walkers]
        """Of the members whose formula asks for more than which ways they may go."""

    def may_go(self, member: int, way: Way) -> bool:
        """Whether its own formula ever lets a member go from a region to another."""
        return way in self._ways[member]

    def trip(self, agent: int, agenda: Agenda) -> tuple[int, int]:
        """What an agent's free ways cost, and what is wrong with its walk; and where it is when the suffix begins."""
        distance, (prefix, suffix) = self._distance[agent], agenda
        at, total = self._starts[agent], 0
        for errand in prefix:
            if agent in errand.team:
                total += distance[at][errand.start]
                at = errand.goal
        first = last = -1
        for errand in suffix:
            if agent in errand.team:
                if first < 0:
                    first = errand.start
                else:
                    total += distance[last][errand.start]
                last = errand.goal
        meeting = at
        if first >= 0:
            ways = zip(distance[at], self._towards[agent][first], distance[last], strict=True)
            sums = [sum(way) for way in ways]
            most = min(sums)
            meeting = sums.index(most)
            total += most
        walker = self.walkers[agent]
        if walker is not None and not walker.accepts(self._walk(agent, agenda, meeting)):
            total += WRONG * self._dearest
        return total, meeting

    def meeting(self, agent: int, agenda: Agenda) -> int:
        """Where an agent is when the suffix begins, so that its ways are cheapest."""
        return self.trip(agent, agenda)[1]

    def walk(self, agent: int, agenda: Agenda) -> Walk:
        """All regions an agent enters, freely or with an object."""
        return self._walk(agent, agenda, self.meeting(agent, agenda))

    def _walk(self, agent: int, agenda: Agenda, meeting: int) -> Walk:
        prefix = self._along(agent, self._starts[agent], agenda[0], meeting)
        return prefix, self._along(agent, meeting, agenda[1], meeting)

    def _along(self, agent: int, at: int, errands: Sequence[Errand], end: int) -> tuple[int, ...]:
        entered: list[int] = []
        for errand in errands:
            if agent in errand.team:
                entered += self.path(agent, at, errand.start)
                if errand.goal != errand.start:
                    entered.append(errand.goal)
                at = errand.goal
        return (*entered, *self.path(agent, at, end))

    def path(self, agent: int, start: int, goal: int) -> list[int]:
        """The regions after the first on the cheapest way."""
        found = []
        while start != goal:
            start = self._next[agent][start][goal]
            found.append(start)
        return found

    def _cheapest(self, ways: frozenset[Way]) -> tuple[list[list[int]], list[list[int]]]:
        """Costs and next regions by Floyd and Warshall, in integers, which must stay exact."""
        regions = self._regions
        blocked = BLOCKED * self._dearest
        cost = [[0 if a == b else self.costs[a][b] if (a, b) in ways else blocked for b in regions] for a in regions]
        following = [list(regions) for _ in regions]
        for k in regions:
            for a in regions:
                for b in regions:
                    if cost[a][k] + cost[k][b] < cost[a][b]:
                        cost[a][b], following[a][b] = cost[a][k] + cost[k][b], following[a][k]
        return cost, following


def errands_cost(routes: Routes, agenda: Agenda) -> int:
    """Of all transports: each body's way."""
    costs = routes.costs
    return sum(
        [costs[e.start][e.goal] * (len(e.team) + 1) for errands in agenda for e in errands if e.object is not None]
    )


def ways_of(start: int, regions: Sequence[int]) -> list[Way]:
    """The ways between regions that are entered one after the other."""
    return list(pairwise((start, *regions)))
