"""Shortest ways in the product of merged states with an automaton, from and to many nodes at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.automaton import Automaton
from drake_ltl.planning.factored.moves import Moves

Step = Callable[[NDArray, NDArray, NDArray], tuple[NDArray, NDArray]]


@dataclass(frozen=True, eq=False)
class WaveProduct:
    """Nodes (q P + p) F + f: the system is in merged state p F + f, whose letter brought the automaton to state q.

    Values of nodes are kept for several problems at once, T of them, in one array (T n_nodes,).
    """

    moves: list[Moves]
    """Not empty."""
    letter: NDArray[np.int64]
    """(P, F)"""
    automaton: Automaton

    @property
    def n_system(self) -> int:
        """P F."""
        return self.letter.size

    @property
    def n_nodes(self) -> int:
        return self.automaton.n_states * self.n_system

    def initial(self, state: int) -> NDArray[np.int64]:
        """Nodes in which runs begin that begin in a merged state."""
        first = self.automaton.successors[self.automaton.initial, self.letter.reshape(-1)[[state]]]
        return first[first >= 0] * self.n_system + state

    def marked(self, mark: int) -> NDArray[np.bool_]:
        """(n_nodes,): whether the automaton can meet a mark on the way into a node's state, by its letter."""
        entered = np.zeros(self.automaton.successors.shape, dtype=bool)
        q, letter = np.nonzero((self.automaton.successors >= 0) & (self.automaton.marks >> mark & 1 > 0))
        entered[self.automaton.successors[q, letter], letter] = True
        return entered[:, self.letter.reshape(-1)].reshape(-1)

    def only(self, mark: int) -> WaveProduct:
        """The same with only the edges that carry a mark."""
        kept = self.automaton.marks >> mark & 1 > 0
        successors = np.where(kept, self.automaton.successors, -1)
        return WaveProduct(self.moves, self.letter, replace(self.automaton, successors=successors))

    def onwards(self, nodes: NDArray, values: NDArray, below: NDArray) -> tuple[NDArray, NDArray]:
        """One step from nodes at given values.

        Args:
            nodes: (e,), increasing.
            values: (e,)
            below: (T n_nodes,), what is of use; other values are left out.

        Returns:
            Nodes, some of them more than once, and value + weight for each.
        """
        n_places, n_formations = self.letter.shape
        blocks, formations = np.divmod(nodes, n_formations)
        found = [(np.zeros(0, dtype=np.int64), np.zeros(0))]
        for moves in self.moves:
            row = np.flatnonzero(moves.allowed[blocks % n_places, formations])
            if len(row):
                there, group = np.unique(blocks[row], return_inverse=True)
                reached = moves.spread(group, formations[row], values[row], there % n_places, back=False)
                found += self._landed(moves, there, reached, below)
        return _joined(found)

    def backwards(self, nodes: NDArray, values: NDArray, below: NDArray) -> tuple[NDArray, NDArray]:
        """One step to nodes at given values; like `onwards`."""
        (n_places, n_formations), n_states = self.letter.shape, self.automaton.n_states
        blocks, formations = np.divmod(nodes, n_formations)
        layer, places = blocks // n_places // n_states, blocks % n_places
        before = self._before[blocks // n_places % n_states, self.letter[places, formations]]
        row, choice = np.nonzero(before >= 0)
        base = (layer[row] * n_states + before[row, choice]) * n_places
        places, formations, values = places[row], formations[row], values[row]
        found = [(np.zeros(0, dtype=np.int64), np.zeros(0))]
        for moves in self.moves:
            row = np.flatnonzero(moves.allowed[places, formations])
            if not len(row):
                continue
            ends = formations[row]
            origins = moves.origins[places[row]]
            ways = range(origins.shape[1])
            lasting = [values[row] + moves.weigh(origins[:, way], way, ends) for way in ways]
            keys = (base[row, None] + origins).T * n_formations + ends
            order = np.argsort(keys, axis=None, kind="stable")
            keys, lasting = keys.reshape(-1)[order], np.concatenate(lasting)[order]
            there, group = np.unique(keys // n_formations, return_inverse=True)
            reached = moves.spread(group, keys % n_formations, lasting, there % n_places, back=True)
            kept = moves.allowed[there % n_places] & (reached < below.reshape(-1, n_formations)[there])
            group, formation = np.nonzero(kept)
            found.append((there[group] * n_formations + formation, reached[group, formation]))
        return _joined(found)

    @cached_property
    def _before(self) -> NDArray[np.int64]:
        """(Q, L, B): from which states a letter leads into a state; -1 fills up."""
        n_states, n_letters = self.automaton.successors.shape
        q, letter = np.nonzero(self.automaton.successors >= 0)
        edges = np.unique(np.stack([self.automaton.successors[q, letter], letter, q]), axis=1)
        key = edges[0] * n_letters + edges[1]
        place = np.arange(len(key)) - np.searchsorted(key, key)
        before = np.full((n_states * n_letters, max(1, place.max(initial=-1) + 1)), -1)
        before[key, place] = edges[2]
        return before.reshape(n_states, n_letters, -1)

    def _landed(self, moves: Moves, blocks: NDArray, reached: NDArray, below: NDArray) -> list[tuple[NDArray, NDArray]]:
        """Nodes and values, from what the crowds reach (b, F) before the objects and the automaton have moved."""
        (n_places, n_formations), n_states = self.letter.shape, self.automaton.n_states
        row, formations = np.nonzero(np.isfinite(reached))
        values, places = reached[row, formations], (blocks % n_places)[row]
        states, layer = (blocks // n_places % n_states)[row], (blocks // n_places // n_states)[row]
        found = []
        for way in range(moves.goals.shape[1]):
            goals = moves.goals[places, way]
            sound = np.flatnonzero(moves.allowed[goals, formations])
            goal, formation = goals[sound], formations[sound]
            ends = values[sound] + moves.weigh(places[sound], way, formation)
            after = self.automaton.successors[states[sound], self.letter[goal, formation]]
            nodes = ((layer[sound] * n_states + after) * n_places + goal) * n_formations + formation
            kept = np.flatnonzero((after >= 0) & (ends < below[nodes]))
            found.append((nodes[kept], ends[kept]))
        return found


def _joined(found: list[tuple[NDArray, NDArray]]) -> tuple[NDArray, NDArray]:
    nodes, values = zip(*found, strict=True)
    return np.concatenate(nodes), np.concatenate(values)


def spread(step: Step, offsets: NDArray, below: NDArray, width: float) -> NDArray[np.float64]:
    """Least offset + weight of a way for all nodes.

    Nodes are looked at in waves, those of the next values together, and again if their value falls. So the result
    is that of Dijkstra's method.

    Args:
        step: `onwards` or `backwards` of a product; weights are positive.
        offsets: (T n_nodes,), inf where no way begins.
        below: (T n_nodes,), values from which on nodes are of no use and left at inf.
        width: range of values of a wave; only a matter of speed.
    """
    values = np.where(offsets < below, offsets, np.inf)
    below = np.minimum(below, values)
    waiting = np.isfinite(values)
    while len(nodes := np.flatnonzero(waiting)):
        at = values[nodes]
        nodes = nodes[at < at.min() + width]
        waiting[nodes] = False
        reached, ends = step(nodes, values[nodes], below)
        np.minimum.at(values, reached, ends)
        below[reached] = values[reached]
        waiting[reached] = True
    return values


def least(n: int, found: tuple[NDArray, NDArray]) -> NDArray[np.float64]:
    """(n,): the least of the values found for each node, inf for others."""
    values = np.full(n, np.inf)
    np.minimum.at(values, *found)
    return values
