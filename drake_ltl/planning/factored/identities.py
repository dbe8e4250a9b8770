"""Who is who: from merged states back to states of TS."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.factored.crowds import Crowd
from drake_ltl.planning.factored.moves import Moves
from drake_ltl.planning.factored.states import MergedStates

Row = list[int]
"""The option of each agent."""


def follow(all_moves: Sequence[Moves], numbers: Sequence[int], first: Row, closed: bool = False) -> list[Row] | None:
    """The options of all agents along a shortest way between merged states.

    Args:
        all_moves: the transitions.
        numbers: merged states, each a step from the one before.
        first: options in the first state.
        closed: whether everybody must have the same option at the end as at the beginning.

    Returns:
        None if there is no such way that costs no more than the merged one.
    """
    states = all_moves[0].states
    rows = np.tile(np.array(first), (len(numbers), 1))
    places = [number // states.n_formations for number in numbers]
    steps = [_moves_between(all_moves, *ends) for ends in pairwise(places)]
    formations = np.unravel_index(np.array(numbers) % states.n_formations, states.shape) if states.shape else ()
    for c, crowd in enumerate(states.crowds):
        if len(crowd.agents) == 1:
            rows[:, crowd.agents[0]] = crowd.formations[formations[c], 0]
            continue
        tables = [(moves.single[p], moves.ahead[c][p]) for moves, p in zip(steps, places[:-1], strict=True)]
        arranged = _arrange(crowd, formations[c].tolist(), tables, [first[i] for i in crowd.agents], closed)
        if arranged is None:
            return None
        rows[:, crowd.agents] = arranged
    return rows.tolist()


def sorted_row(states: MergedStates, number: int) -> Row:
    """The state of TS in which the agents of each crowd are sorted by their options."""
    return states.options[number % states.n_formations].tolist()


def exchanged(states: MergedStates, rows: list[Row], first: Row) -> list[Row]:
    """The same with agents of a crowd exchanged so that the rows, whose first is sorted, begin with another one."""
    result = np.array(rows)
    for crowd in states.crowds:
        agents = np.array(crowd.agents)
        by_rank = agents[np.argsort(np.array(first)[agents], kind="stable")]
        result[:, by_rank] = np.array(rows)[:, agents]
    return result.tolist()


def _moves_between(all_moves: Sequence[Moves], before: int, after: int) -> Moves:
    places = all_moves[0].states.places
    moved = tuple(np.flatnonzero(places[before] != places[after]).tolist())
    return next(moves for moves in all_moves if moves.moved == moved)


def _arrange(
    crowd: Crowd, formations: list[int], tables: list[tuple[NDArray, NDArray]], first: Row, closed: bool
) -> NDArray[np.int64] | None:
    """(steps + 1, r): the option of each agent of a crowd."""
    arrangements = [crowd.arrangements(formation) for formation in formations]
    start = int(np.flatnonzero((arrangements[0] == first).all(axis=1))[0])
    before, reached = [], np.arange(len(arrangements[0])) == start
    for i, (single, ways) in enumerate(tables):
        old, new = arrangements[i], arrangements[i + 1]
        weights = single[old[:, None], new[None]].sum(axis=2)
        possible = reached[:, None] & (weights == ways[formations[i], formations[i + 1]])
        before.append(possible.argmax(axis=0))
        reached = possible.any(axis=0)
    last = start if closed else int(reached.argmax())
    if not reached[last]:
        return None
    chosen = [last]
    for origins in reversed(before):
        chosen.append(int(origins[chosen[-1]]))
    return np.array([a[i] for a, i in zip(arrangements, reversed(chosen), strict=True)])
