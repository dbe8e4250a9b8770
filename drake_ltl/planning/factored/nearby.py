"""What loops below a limit can use, as an ordinary graph: few nodes, so their edges are found by trying all pairs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product as combinations_of

import numpy as np
from numpy.typing import NDArray

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.factored.moves import Moves
from drake_ltl.planning.factored.states import MergedStates
from drake_ltl.planning.factored.waves import WaveProduct
from drake_ltl.planning.product import Graph, Product, multiply
from drake_ltl.planning.transition_system import TransitionSystem

CHUNK = 1 << 20
"""Pairs looked at together."""
MOST_PAIRS = 400_000_000
MOST_EDGES = 3_000_000
"""Of the states and of the edges between them; beyond these the search is given up."""


@dataclass(frozen=True, eq=False)
class Nearby:
    """Nodes of a product (n of them, increasing) that a loop of price + weight below a limit may pass by."""

    product: WaveProduct
    nodes: NDArray[np.int64]
    prices: NDArray[np.float64]
    """(n,): what it costs to begin a loop there; inf if none begins there."""
    begun: NDArray[np.float64]
    """(n,): the least price + way to there."""
    home: NDArray[np.float64]
    """(n,): the least way from there to where a loop may end."""
    limit: float

    def merged(self) -> Local:
        """The graph of merged states: a loop in it is one of the system up to who is who."""
        states = self._states
        numbers, system = np.unique(self.nodes % self.product.n_system), states.n_formations
        listed = states.listed(numbers)
        columns = np.unravel_index(numbers % system, states.shape) if states.shape else ()
        tables = [moves.ahead for moves in self.product.moves]
        return self._local(numbers, listed.options, columns, tables, np.ones(len(numbers), dtype=bool))

    def labelled(self) -> Local:
        """The graph of the states of TS that they stand for. Loops begin where the agents of each crowd are sorted:
        any other loop is one of these with agents exchanged."""
        states = self._states
        numbers, rows, first = [], [], []
        for number in np.unique(self.nodes % self.product.n_system).tolist():
            formations = np.unravel_index(number % states.n_formations, states.shape)
            ways = [c.arrangements(int(f)) for c, f in zip(states.crowds, formations, strict=True)]
            for i, choice in enumerate(combinations_of(*ways)):
                row = np.zeros(len(states.scenario.agents), dtype=np.int64)
                for crowd, part in zip(states.crowds, choice, strict=True):
                    row[list(crowd.agents)] = part
                numbers.append(number)
                rows.append(row)
                first.append(i == 0)
        options = np.array(rows)
        tables = [(moves.single,) * options.shape[1] for moves in self.product.moves]
        return self._local(np.array(numbers), options, tuple(options.T), tables, np.array(first))

    @property
    def _states(self) -> MergedStates:
        return self.product.moves[0].states

    def _local(
        self, numbers: NDArray, options: NDArray, columns: Sequence, tables: Sequence, first: NDArray[np.bool_]
    ) -> Local:
        prices, begun, home = (self._by_state(values, numbers) for values in (self.prices, self.begun, self.home))
        slack = self.limit - begun.min(axis=0), home.min(axis=0)
        steps = _steps_among(self.product.moves, numbers, columns, tables, slack)
        scenario, letter = self._states.scenario, self.product.letter.reshape(-1)[numbers]
        places, nothing = self._states.places[numbers // self._states.n_formations], np.zeros(0, dtype=np.int64)
        acts = np.zeros(len(steps[0]), dtype=np.int16)
        system = TransitionSystem(scenario, options, places, *steps, acts, nothing, 0)
        alive = begun + home < self.limit
        whole = multiply(Graph.of(len(numbers), *steps), letter, self.product.automaton, alive)
        begun, home, alive = (values.reshape(-1) for values in (begun, home, alive))
        kept = whole.graph.at_sources(begun) + whole.graph.weights + whole.graph.at_targets(home) < self.limit
        return Local(system, numbers, _only(whole, kept), alive, np.where(first, prices, np.inf).reshape(-1))

    def _by_state(self, values: NDArray, numbers: NDArray) -> NDArray[np.float64]:
        """(Q, S) values of nodes for some merged states, inf for nodes that are not nearby."""
        of_all = np.arange(self.product.automaton.n_states)[:, None] * self.product.n_system + numbers
        place = np.minimum(np.searchsorted(self.nodes, of_all), len(self.nodes) - 1)
        return np.where(self.nodes[place] == of_all, values[place], np.inf)


@dataclass(frozen=True, eq=False)
class Local:
    """S states that are listed, with the steps between them, and their product with the automaton."""

    system: TransitionSystem
    numbers: NDArray[np.int64]
    """(S,): merged state of each."""
    product: Product
    alive: NDArray[np.bool_]
    """(Q S,): which nodes are nearby."""
    prices: NDArray[np.float64]
    """(Q S,)"""

    def features(self, nodes: NDArray) -> NDArray[np.int64]:
        """Objects first: to bring one back takes a team, so loops that begin elsewhere differ most in cost."""
        states = nodes % self.system.n_states
        return np.column_stack([self.system.places[states], self.system.options[states], nodes // self.system.n_states])


def _only(product: Product, kept: NDArray[np.bool_]) -> Product:
    """The product with only some of its edges."""
    edges = np.flatnonzero(kept)
    smaller = product.graph.part(np.arange(product.graph.n_nodes), edges)
    return Product(smaller, product.marks[edges], product.n_system)


def _steps_among(
    all_moves: Sequence[Moves], numbers: NDArray, columns: Sequence, tables: Sequence, slack: tuple[NDArray, NDArray]
) -> tuple[NDArray, NDArray, NDArray]:
    """Steps between S listed states, sorted by source: sources, targets and weights.

    Args:
        all_moves: the transitions.
        numbers: (S,), merged state of each.
        columns: for each axis (S,), a position in its tables.
        tables: for each of the moves, for each axis (P, n, n).
        slack: (S,) before and (S,) after; of use is a step of weight < before - after.
    """
    places, formations = np.divmod(numbers, all_moves[0].states.n_formations)
    order = np.argsort(places, kind="stable")
    bounds = np.searchsorted(places[order], np.arange(len(all_moves[0].goals) + 1))
    at = [order[bounds[p] : bounds[p + 1]] for p in range(len(bounds) - 1)]
    if (
        sum(len(here) * len(at[goal]) for m in all_moves for p, here in enumerate(at) for goal in m.goals[p])
        > MOST_PAIRS
    ):
        raise SearchLimitError(
            f"{len(numbers)} states are left near the best loops, too many to list the steps between"
        )
    found, n_found = [(np.zeros(0, int), np.zeros(0, int), np.zeros(0))], 0
    for moves, axes in zip(all_moves, tables, strict=True):
        begin = [here[moves.allowed[p, formations[here]]] for p, here in enumerate(at)]
        for p, before in enumerate(begin):
            for way, goal in enumerate(moves.goals[p].tolist() if len(before) else ()):
                after = begin[goal]
                each = max(1, CHUNK // max(1, len(after)))
                for rows in (before[i : i + each] for i in range(0, len(before) if len(after) else 0, each)):
                    weights = np.tile(moves.weigh(np.full(len(after), p), way, formations[after]), (len(rows), 1))
                    for column, table in zip(columns, axes, strict=True):
                        weights += table[p][column[rows][:, None], column[after]]
                    row, end = np.nonzero(weights < slack[0][rows][:, None] - slack[1][after])
                    found.append((rows[row], after[end], weights[row, end]))
                    n_found += len(row)
                    if n_found > MOST_EDGES:
                        raise SearchLimitError(f"more than {n_found} steps are left near the best loops")
    sources, targets, weights = (np.concatenate(column) for column in zip(*found, strict=True))
    order = np.argsort(sources, kind="stable")
    return sources[order].astype(np.int32), targets[order].astype(np.int32), weights[order]
