"""The lasso of least J = cost(prefix) + cost(suffix) among all lassos of the transition system.

What counts is the run prefix, suffix, suffix ..: the automaton need not be back in the same state after one round.
A loop that is closed in the product too is found by Dijkstra over sets of marks (`layers`). Its price is the way
to its root: to the root's product node for an upper bound, to its state of TS, whatever the automaton's state, for
a lower bound if the automaton never counts (`never_counts`). Where the two do not meet, the search is done again
over profiles, which is exact for every automaton and slower.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.automaton import Automaton, never_counts
from drake_ltl.planning.layers import Layers, layered
from drake_ltl.planning.loops import Loop, LoopProblem, cheapest_loop
from drake_ltl.planning.product import Product, accepting, multiply
from drake_ltl.planning.profiles import accepted_from, all_profiles, profile_of
from drake_ltl.planning.transition_system import TransitionSystem
from drake_ltl.planning.weights import COST_UNIT, lexicographic

MOST_PROFILES = 3000
MOST_LAYERS = 1024
MOST_EDGES = 20_000_000
"""Graphs with more edges are not formed: some 40 bytes each while they are searched."""


@dataclass(frozen=True)
class Lasso:
    """Indices of states of TS; the run is prefix, suffix, suffix .."""

    prefix: tuple[int, ...]
    suffix: tuple[int, ...]
    optimal: bool
    """Whether it is proven that no other is cheaper, nor as cheap with fewer steps or actions."""
    gap: float
    """What a cheaper lasso could save at most, as a share of J; 0 if optimal."""


@dataclass(frozen=True, eq=False)
class _Prefixes:
    """Shortest paths from the start to all nodes of the product."""

    product: Product
    distance: NDArray[np.float64]
    parent: NDArray[np.int32]

    def path(self, node: int) -> list[int]:
        """States of TS from the start to a node."""
        nodes = [node]
        while self.parent[nodes[-1]] >= 0 and self.parent[nodes[-1]] < self.product.graph.n_nodes:
            nodes.append(int(self.parent[nodes[-1]]))
        return [n % self.product.n_system for n in reversed(nodes)]

    def by_state(self) -> NDArray[np.float64]:
        """(Q, S)"""
        return self.distance.reshape(-1, self.product.n_system)


def cheapest_lasso(system: TransitionSystem, letter: NDArray, automaton: Automaton, start: int) -> Lasso | None:
    """The lasso from `start` whose word the automaton accepts, of least cost, then fewest steps, then fewest actions.

    Args:
        system: TS.
        letter: (S,), the letter of each state.
        automaton: reads letters.
        start: index of the initial state.

    Returns:
        None if there is no such lasso.

    Raises:
        SearchLimitError: the product is too large.
    """
    if system.n_transitions * automaton.n_states > MOST_EDGES:
        size = f"{system.n_transitions} transitions x {automaton.n_states} states"
        raise SearchLimitError(f"the product of TS and the automaton is too large: {size}")
    weights = lexicographic(system.costs, system.actions)
    prefixes = _prefixes(multiply(system, letter, weights, automaton, start))
    component = accepting(prefixes.product, np.isfinite(prefixes.distance), automaton.full)
    if not (component >= 0).any():
        return None
    return _Search(system, letter, automaton, weights, prefixes, component).run()


def has_lasso(system: TransitionSystem, letter: NDArray, automaton: Automaton, start: int) -> bool:
    """Whether any run from `start` is accepted."""
    product = multiply(system, letter, np.ones(system.n_transitions), automaton, start)
    reachable = np.isfinite(_prefixes(product).distance)
    return bool((accepting(product, reachable, automaton.full) >= 0).any())


def _prefixes(product: Product) -> _Prefixes:
    """Dijkstra from one more node that leads to the initial ones."""
    graph, n = product.graph, product.graph.n_nodes
    starts = np.append(graph.starts, graph.starts[-1] + len(product.initial)).astype(np.int32)
    targets = np.append(graph.targets, product.initial).astype(np.int32)
    weights = np.append(graph.weights, np.ones(len(product.initial)))
    matrix = csr_array((weights, targets, starts), shape=(n + 1, n + 1))
    distance, parent = dijkstra(matrix, indices=n, return_predecessors=True)
    return _Prefixes(product, distance[:n] - 1.0, parent[:n])


@dataclass(frozen=True, eq=False)
class _Search:
    system: TransitionSystem
    letter: NDArray
    automaton: Automaton
    weights: NDArray
    prefixes: _Prefixes
    component: NDArray
    """(n,): accepting component of each product node, or -1."""

    def run(self) -> Lasso:
        layers = self._layers()
        nodes, n_system = layers.nodes, self.system.n_states
        to_node = self.prefixes.distance[nodes]
        to_state = self.prefixes.by_state().min(axis=0)[nodes % n_system]
        bound = float(to_state.min())
        if layers.exact and never_counts(self.automaton):
            relaxed = _found(cheapest_loop(self._problem(layers, to_state)))
            lasso = self._closed_anyhow(relaxed, layers)
            if lasso is not None:
                return lasso
            bound = relaxed.weight
        closed = _found(cheapest_loop(self._problem(layers, to_node)))
        lasso = self._lasso(int(nodes[closed.root]), closed, nodes)
        if closed.weight == bound:
            return lasso
        return self._over_profiles(lasso, closed.weight, bound)

    def _layers(self) -> Layers:
        product = self.prefixes.product
        n_edges = int((self.component[product.graph.targets] >= 0).sum())
        exact = self.automaton.full < MOST_LAYERS and n_edges * (self.automaton.full + 1) <= MOST_EDGES
        layers = layered(product, self.component, self.automaton.full, exact, MOST_EDGES)
        if layers is None:
            raise SearchLimitError(f"the loops have {n_edges} transitions to choose from, which is too many")
        return layers

    def _problem(self, layers: Layers, prices: NDArray) -> LoopProblem:
        n = len(layers.nodes)
        last = layers.graph.n_nodes - n
        roots = np.arange(n)
        return LoopProblem(layers.graph, roots, last + roots[:, None], prices, self._features(layers.nodes))

    def _features(self, nodes: NDArray) -> NDArray[np.int64]:
        states, system = nodes % self.system.n_states, self.system
        return np.column_stack([system.options[states], system.places[states], nodes // system.n_states])

    def _closed_anyhow(self, loop: Loop, layers: Layers) -> Lasso | None:
        """The lasso of the loop and the shortest way to its first state, if its word is accepted."""
        n_system = self.system.n_states
        states = [int(layers.nodes[node % len(layers.nodes)]) % n_system for node in loop.nodes]
        profile = profile_of(self.automaton, self.letter[states[1:]].tolist())
        accepted = accepted_from(profile, self.automaton.full)
        distances = self.prefixes.by_state()[:, states[0]]
        for q in np.flatnonzero(distances == distances.min()).tolist():
            if q in accepted:
                return self._lasso(q * n_system + states[0], loop, layers.nodes)
        return None

    def _lasso(self, root: int, loop: Loop, nodes: NDArray) -> Lasso:
        """The shortest way to product node `root`, then a loop that begins in the same state of TS."""
        prefix = self.prefixes.path(root)[:-1]
        suffix = [int(nodes[node % len(nodes)]) % self.system.n_states for node in loop.nodes[:-1]]
        return Lasso(tuple(prefix), tuple(suffix), True, 0.0)

    def _over_profiles(self, lasso: Lasso, weight: float, bound: float) -> Lasso:
        """Exact search for something better than a lasso; the lasso itself if there is nothing, or too much."""
        system, by_state = self.system, self.prefixes.by_state()
        near = by_state.min(axis=0) < weight
        kept = near[system.sources] & near[system.targets]
        profiles = all_profiles(self.automaton, self.letter[near], MOST_PROFILES)
        if profiles is None or profiles.automaton.n_states * int(kept.sum()) > MOST_EDGES:
            return replace(lasso, optimal=False, gap=_gap(bound, weight))
        graph = multiply(system.keep(kept), self.letter, self.weights[kept], profiles.automaton, 0).graph
        states = np.arange(system.n_states)
        for q, prices in enumerate(by_state):
            accepting_profiles = [g for g, accepted in enumerate(profiles.accepted) if q in accepted]
            if not accepting_profiles:
                continue
            goals = states[:, None] + np.array(accepting_profiles) * system.n_states
            problem = LoopProblem(graph, states, goals, prices, self._features(states))
            loop = cheapest_loop(problem, weight)
            if loop is not None:
                weight = loop.weight
                lasso = self._lasso(q * system.n_states + loop.root, loop, states)
        return lasso


def _found(loop: Loop | None) -> Loop:
    if loop is None:
        raise AssertionError("an accepting component has a loop through each of its nodes")
    return loop


def _gap(bound: float, weight: float) -> float:
    """Share of the cost between two weights (`weights.lexicographic`)."""
    cost, least = weight // COST_UNIT, bound // COST_UNIT
    return (cost - least) / cost if cost else 0.0
