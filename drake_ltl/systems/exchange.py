"""Travellers that take each other's places, where one place is as good as the other for all that follows.

Of who has stalled on the way to such places, each goes to the one that makes the sum of squared distances least from
where all of them are: who bars the way of another moves on to the place behind, and the other takes its place.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from math import factorial

import numpy as np
from scipy.optimize import linear_sum_assignment

from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.systems.program import MissionProgram, StepProgram

LEAST_GAIN = 0.1
"""Less is no reason to exchange places [m^2]."""
MOST_TRAVELLERS = 18
"""Ranks of their permutations are numbers that a float holds exactly."""


def exchanged(step: StepProgram, rank: int, models: MeasuredModels) -> StepProgram:
    """With traveller i on its way to the place of traveller order[i], by the permutation of that rank (`order_of`)."""
    if rank == 0:
        return step
    centres = _places(step, models)
    travels = []
    for task, here, there in zip(step.travels, centres, centres[order_of(rank, len(centres))], strict=True):
        q_goal = task.q_goal.copy()
        q_goal[:NUM_BASE_JOINTS] += (there - here)[:2]
        travels.append(replace(task, q_goal=q_goal))
    return replace(step, travels=tuple(travels))


def better_rank(
    program: MissionProgram, number: int, rank: int, models: MeasuredModels, here: Sequence[np.ndarray]
) -> int | None:
    """Rank of an exchange of places that leaves shorter ways than that of `rank`; None if there is none.

    Args:
        number: of the step in the program.
        here: centre of each traveller's sphere (3,) [m], in the order of the step's travels.
    """
    step = program.steps[number]
    if not 1 < len(step.travels) <= MOST_TRAVELLERS:
        return None
    squared = ((np.array(here)[:, None, :2] - _places(step, models)[None, :, :2]) ** 2).sum(axis=-1)
    order = order_of(rank, len(here))
    gained = 0.0
    for group in alike_travels(program, number, models):
        rows = np.array(group)
        best = rows[linear_sum_assignment(squared[np.ix_(rows, rows)])[1]]
        gained += squared[rows, order[rows]].sum() - squared[rows, best].sum()
        order[rows] = best
    return rank_of(order) if gained > LEAST_GAIN else None


def alike_travels(program: MissionProgram, number: int, models: MeasuredModels) -> list[tuple[int, ...]]:
    """Indices of travels of a step whose places can be exchanged, in groups of two or more.

    Their spheres are equal and stand in the same region until the same later step, in which each drives away: so
    whatever comes between finds the same spheres in the same places. Who grasps from where it stands needs its own.
    """
    groups = defaultdict(list)
    step = program.steps[number]
    for index, (task, place) in enumerate(zip(step.travels, _places(step, models), strict=True)):
        leaves, drives = _exit(program, number, task.agent)
        if drives:
            radius = models.geometry.agent_radius[task.agent]
            groups[task.goal, leaves, round(radius, 9), round(float(place[2]), 9)].append(index)
    return [tuple(group) for group in groups.values() if len(group) > 1]


def order_of(rank: int, n: int) -> np.ndarray:
    """The permutation (n,) of 0 .. n - 1 of that rank in lexicographic order."""
    left, order = list(range(n)), []
    for size in range(n, 0, -1):
        digit, rank = divmod(rank, factorial(size - 1))
        order.append(left.pop(digit))
    return np.array(order, dtype=int)


def rank_of(order: Sequence[int]) -> int:
    """Of a permutation among all in lexicographic order; 0 if everybody keeps its place."""
    left, rank = sorted(order), 0
    for item in order:
        rank += left.index(item) * factorial(len(left) - 1)
        left.remove(item)
    return rank


def _exit(program: MissionProgram, number: int, agent: str) -> tuple[int | None, bool]:
    """The step in which an agent next does something, None if it never does; and whether it drives away then, which
    one that is on its way to a stand-off in this very step does not."""
    if any(task.weld.agent == agent for task in program.steps[number].late_grasps):
        return None, False
    for count in range(number + 1, number + 1 + len(program.steps)):
        later = program.index(count)
        if any(agent in action.agents for action in program.steps[later].actions):
            return later, any(task.agent == agent for task in program.steps[later].travels)
    return None, True


def _places(step: StepProgram, models: MeasuredModels) -> np.ndarray:
    """Centre of each traveller's sphere at its goal (n, 3) [m]."""
    return np.array([models.agents[task.agent].centre(task.q_goal) for task in step.travels]).reshape(-1, 3)
