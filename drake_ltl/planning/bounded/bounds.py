"""Lower bounds on the cost of all lassos, the cheap ones first.

1. Each object's own minimum, as often as bodies go its way (itself and the smallest team that may), summed over
   objects. It counts no agent's free ways, and nobody carries two objects at once.
2. The own minima of all members, objects' ways counted without their teams: members' ways are different terms of J.
3. The program of all members together (`counting`), as far as the solver gets with it.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence

from drake_ltl.errors import InfeasibleError
from drake_ltl.planning.bounded.alone import Alone, alone
from drake_ltl.planning.bounded.conjuncts import automaton, automaton_of_each_member
from drake_ltl.planning.bounded.counting import Counting
from drake_ltl.planning.bounded.detours import needed_ways
from drake_ltl.planning.bounded.problem import Problem
from drake_ltl.planning.bounded.standing import Standing
from drake_ltl.planning.bounded.teams import can_go

_NAP = 0.02
"""How long to wait at a time until there is a plan [s]."""
_FIRST_SLICE, _MORE = 2.0, 4.0
"""Time for the solver at first [s], and so many times more in each further attempt."""
_MOST_CARRIES = 10_000
"""The program of all members is not formed if there are more numbers that say how often somebody carries something:
its first relaxation would take longer than anybody waits."""

_FORMING = 1e-3
"""Time it may take to form that program, for each such number [s]: it is left alone if there is less."""


def raise_bound(problem: Problem, members: Sequence[Alone | None], standing: Standing) -> None:
    """Raise the lower bound until nothing better can be proven, or nobody needs it."""
    n, ways = problem.n_agents, needed_ways(problem, members)

    def least(program: Counting) -> int:
        return max(_bounds(program, standing), default=0)

    objects = range(n, n + problem.n_objects)
    with_teams = sum(least(Counting.of_one(problem, members, ways, m, with_team=True)) for m in objects)
    standing.raise_bound(float(with_teams * problem.unit))
    own = sum(least(Counting.of_one(problem, members, ways, m)) for m in range(len(problem.members)))
    standing.raise_bound(float(own * problem.unit))
    while standing.cost is None and not standing.stopped and standing.left > 0.0:
        time.sleep(_NAP)  # the first plan comes first
    n_carries = 2 * n * sum(map(len, ways[n:]))  # agents times objects' ways, in prefix and suffix
    if n_carries > _MOST_CARRIES or standing.left < n_carries * _FORMING:
        return
    for bound in _bounds(Counting(problem, members, ways), standing):
        standing.raise_bound(float(bound * problem.unit))


def _bounds(program: Counting, standing: Standing) -> Iterator[int]:
    """What the solver proves in ever more time, as it cannot go on where it was stopped."""
    seconds, done = _FIRST_SLICE, False
    while not done and not standing.stopped and not standing.proven and standing.left > _NAP:
        # A last slice that has no longer than the one before finds nothing new.
        left = standing.left
        bound, done = program.bound(left if left < 2.0 * seconds else seconds)
        yield bound
        seconds *= _MORE


def lone_members(problem: Problem) -> list[Alone | None]:
    """What each member can do alone; None where no formula speaks of it alone.

    Raises:
        InfeasibleError: nothing at all, for one of them.
    """
    automata = automaton_of_each_member(problem.scenario)
    every = {(a, b) for a in range(problem.n_regions) for b in range(problem.n_regions) if a != b}
    found: list[Alone | None] = []
    for member, name in enumerate(problem.members):
        ways = every
        if member >= problem.n_agents:
            ways = {way for way in every if can_go(problem, found, member - problem.n_agents, way)}
        own = automata.get(name)
        if own is None and ways == every:
            found.append(None)
            continue
        own = own or automaton("1")
        lone = alone(problem, member, own, ways)
        if lone is None:
            raise InfeasibleError(f"no run from the initial state satisfies {own.formula}, even without the others")
        found.append(lone)
    return found
