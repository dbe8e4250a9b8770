"""Improves a lasso piece by piece: most of it is fixed, and what is left is solved to the end.

A lasso is stretched first: its states are repeated, so that whoever is not fixed has time for detours, which are
cheaper where costs are squared distances. In the end, what waits in vain is taken out again (`tidying`).
"""

from __future__ import annotations

import random

from drake_ltl.planning.bounded.problem import Problem, Run

SIZE = 2
"""At first so many agents are not fixed, besides one object with its team."""


def stretched(run: Run, length: int) -> Run:
    """A lasso of the given length, some states repeated; the same one if it is longer already."""
    states, loop = run
    if len(states) >= length:
        return run
    extra, n = length - len(states), len(states)
    times = [1 + (extra * (t + 1)) // n - (extra * t) // n for t in range(n)]
    longer = tuple(state for state, count in zip(states, times, strict=True) for _ in range(count))
    return longer, sum(times[:loop])


def neighbourhood(problem: Problem, run: Run, chance: random.Random, size: int) -> tuple[set[int], range]:
    """Who and when is not fixed next: an object or two with their teams and some others, or a window of time."""
    states, _ = run
    n = problem.n_agents
    if chance.random() < 0.25:
        width = 2 + size
        first = chance.randrange(1, max(2, len(states) - width + 2))
        return set(), range(first, first + width)
    objects = chance.sample(range(problem.n_objects), min(problem.n_objects, 1 if size <= SIZE else 2))
    names = {problem.scenario.object_names[j] for j in objects}
    team = {i for state in states for i, grasp in enumerate(state.grasps) if grasp in names}
    others = chance.sample(range(n), min(n, size))
    return {n + j for j in objects} | team | set(others), range(0)
