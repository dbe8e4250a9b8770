"""The lasso of least J = alpha cost(prefix) + beta cost(suffix) among all lassos of the transition system.

What counts is the run prefix, suffix, suffix ..: the automaton need not be back in the same state after one round.
A loop that is closed in the product too is found by Dijkstra over sets of marks (`layers`). Its price is the way
to its root: to the root's product node for an upper bound, to its state of TS, whatever the automaton's state, for
a lower bound if the automaton never counts (`never_counts`). Where the two do not meet, the search goes on among
the loops that only later rounds close, over profiles: that is exact for every automaton, and slower.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.automaton import Automaton, never_counts
from drake_ltl.planning.distances import distances, least, way
from drake_ltl.planning.layers import Priced
from drake_ltl.planning.loops import LoopProblem, cheapest_loop
from drake_ltl.planning.marks import Features, Marks
from drake_ltl.planning.product import Graph, Part, Product, accepting_part, multiply
from drake_ltl.planning.profiles import accepted_from, all_profiles, profile_of
from drake_ltl.planning.shares import least_loop
from drake_ltl.planning.transition_system import TransitionSystem
from drake_ltl.planning.weights import COST_UNIT, lexicographic

MOST_PROFILES = 3000
MOST_LAYERS = 1024
MOST_LAYERED_EDGES = 10_000_000
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
    before: NDArray[np.int32]

    @classmethod
    def of(cls, product: Product, letter: NDArray, automaton: Automaton, start: int) -> _Prefixes:
        """A run begins in state `start` of TS, whose letter the automaton has read."""
        first = automaton.successors[automaton.initial, letter[start]]
        offsets = np.full(product.graph.n_nodes, np.inf)
        offsets[first[first >= 0] * product.n_system + start] = 0.0
        return cls(product, *distances(product.graph, offsets))

    def path(self, node: int) -> list[int]:
        """States of TS from the start to a node."""
        return [n % self.product.n_system for n in way(self.before, node)]

    def by_state(self) -> NDArray[np.float64]:
        """(Q, S)"""
        return self.distance.reshape(-1, self.product.n_system)


def cheapest_lasso(
    system: TransitionSystem,
    letter: NDArray,
    automaton: Automaton,
    start: int,
    alpha: float = 1.0,
    beta: float = 1.0,
) -> Lasso | None:
    """The lasso from `start` whose word the automaton accepts, of least J, then fewest steps, then fewest actions.

    Args:
        system: TS.
        letter: (S,), the letter of each state.
        automaton: reads letters.
        start: index of the initial state.
        alpha: weight of the prefix's cost.
        beta: weight of the suffix's cost.

    Returns:
        None if there is no such lasso.

    Raises:
        SearchLimitError: the product is too large.
    """
    _check_size(system, automaton)
    largest = max(alpha, beta) * float(system.costs.max(initial=0.0))

    def product_with(weight: float) -> Product:
        weights = lexicographic(weight * system.costs, system.actions, largest)
        return multiply(_graph(system, weights), letter, automaton)

    product = product_with(beta)
    prefixes = _Prefixes.of(product if alpha == beta else product_with(alpha), letter, automaton, start)
    part = accepting_part(product, np.isfinite(prefixes.distance), automaton.full)
    return _Search(system, letter, automaton, prefixes, Marks(part, automaton.full)).run() if part.n_nodes else None


def has_lasso(system: TransitionSystem, letter: NDArray, automaton: Automaton, start: int) -> bool:
    """Whether any run from `start` is accepted."""
    product = multiply(_graph(system, np.ones(system.n_transitions)), letter, automaton)
    reachable = np.isfinite(_Prefixes.of(product, letter, automaton, start).distance)
    return accepting_part(product, reachable, automaton.full).n_nodes > 0


def _graph(system: TransitionSystem, weights: NDArray) -> Graph:
    return Graph.of(system.n_states, system.sources, system.targets, weights)


def _check_size(system: TransitionSystem, automaton: Automaton) -> None:
    if max(system.n_transitions, system.n_states) * automaton.n_states > MOST_EDGES:
        size = f"{system.n_transitions} transitions x {automaton.n_states} states"
        raise SearchLimitError(f"the product of TS and the automaton is too large: {size}")


@dataclass(frozen=True)
class ClosedLoop:
    """A loop of the product: nodes of the part, of which the first stands at the end too."""

    nodes: list[int]
    weight: float
    """Price + weight."""
    bound: float
    """No loop has less; equal to `weight` if that is proven to be the least."""


def closed_loop(
    marks: Marks,
    prices: NDArray,
    features: Features,
    limit: float = np.inf,
    known: list[int] | None = None,
) -> ClosedLoop:
    """The cheapest loop with all marks, closed in the product.

    Args:
        marks: of a part with n nodes.
        prices: (n,), what it costs to begin a loop at each node; finite for some.
        features: of nodes of the product, for `LoopProblem`.
        limit: no loop of this price + weight or more is looked for; if there is none below, any is returned.
        known: any loop with all marks, as in `ClosedLoop`.
    """
    priced = Priced(marks, prices)
    nodes, weight = priced.begun_best(known) if known else priced.some_loop()
    if marks.full >= MOST_LAYERS:
        return ClosedLoop(nodes, weight, float(priced.bounds.min()))
    # Weights are integers: below the next one, the loop known already is found if there is no better one.
    found = least_loop(priced, features, min(weight + 1.0, limit), MOST_LAYERED_EDGES)
    if found.nodes:
        return ClosedLoop(found.nodes, found.weight, found.bound)
    return ClosedLoop(nodes, weight, min(found.bound, weight))


@dataclass(frozen=True, eq=False)
class _Search:
    system: TransitionSystem
    letter: NDArray
    automaton: Automaton
    prefixes: _Prefixes
    marks: Marks

    def run(self) -> Lasso:
        to_node = self.prefixes.distance[self._nodes]
        to_state = self.prefixes.by_state().min(axis=0)[self._nodes % self.system.n_states]
        bound, nearest = float(to_state.min()), bool((to_state == to_node).all())
        settled, known = never_counts(self.automaton), None
        if settled and not nearest:
            relaxed = self._closed(to_state)
            lasso = self._closed_anyhow(relaxed)
            if lasso is not None:
                return lasso
            bound, known = relaxed.bound, relaxed.nodes
        closed = self._closed(to_node, known)
        if settled and nearest:
            bound = closed.bound
        lasso = self._lasso(int(self._nodes[closed.nodes[0]]), self._states(closed))
        if closed.weight == bound:
            return lasso
        if closed.weight > closed.bound:
            return replace(lasso, optimal=False, gap=gap_between(bound, closed.weight))
        return self._over_profiles(lasso, closed.weight, bound, self._usable(to_state, settled, closed.weight))

    @property
    def _nodes(self) -> NDArray[np.int64]:
        """(n,): nodes of the product on accepting loops."""
        return self.marks.part.nodes

    def _closed(self, prices: NDArray, known: list[int] | None = None) -> ClosedLoop:
        """The cheapest loop of the product."""
        return closed_loop(self.marks, prices, self._features, known=known)

    def _features(self, nodes: NDArray) -> NDArray[np.int64]:
        """Objects first: to bring one back takes a team, so loops that begin elsewhere differ most in cost."""
        states, system = nodes % self.system.n_states, self.system
        return np.column_stack([system.places[states], system.options[states], nodes // self.system.n_states])

    def _states(self, closed: ClosedLoop) -> list[int]:
        """The loop's states of TS, the first one at its end again."""
        return (self._nodes[closed.nodes] % self.system.n_states).tolist()

    def _closed_anyhow(self, loop: ClosedLoop) -> Lasso | None:
        """The lasso of the loop and the shortest way to its first state, if its word is accepted."""
        if loop.weight > loop.bound:
            return None
        states = self._states(loop)
        profile = profile_of(self.automaton, self.letter[states[1:]].tolist())
        accepted = accepted_from(profile, self.automaton.full)
        distances = self.prefixes.by_state()[:, states[0]]
        for q in np.flatnonzero(distances == distances.min()).tolist():
            if q in accepted:
                return self._lasso(q * self.system.n_states + states[0], states)
        return None

    def _lasso(self, root: int, states: list[int]) -> Lasso:
        """The shortest way to product node `root`, then a loop that begins in the same state of TS."""
        return Lasso(tuple(self.prefixes.path(root)[:-1]), tuple(states[:-1]), True, 0.0)

    def _usable(self, to_state: NDArray, settled: bool, weight: float) -> _Usable:
        """What of TS loops below a weight can use: some of their rounds stay on accepting loops of the product, and
        some one is closed there if the automaton never counts."""
        priced = Priced(self.marks, to_state)
        lengths = self.marks.round_about if settled else np.zeros(len(to_state))
        part = priced.within(np.flatnonzero(to_state + lengths < weight), weight)[0].marks.part
        n_states = self.system.n_states
        return _Usable.of(part, n_states, least(n_states, self._nodes % n_states, lengths))

    def _over_profiles(self, lasso: Lasso, weight: float, bound: float, usable: _Usable) -> Lasso:
        """Exact search for a loop that is not closed after one round and better than a lasso; the lasso itself if
        there is none, or too much to search."""
        profiles = all_profiles(self.automaton, self.letter[usable.states], MOST_PROFILES)
        if profiles is None:
            return replace(lasso, optimal=False, gap=gap_between(bound, weight))
        sound = True
        for q, prices in enumerate(self.prefixes.by_state()[:, usable.states]):
            later = profiles.closed_later(q) if (prices + usable.lengths < weight).any() else None
            if later is None:
                continue
            problem = self._profile_problem(*later, prices, weight, usable)
            loop = None if problem is None else cheapest_loop(problem, weight)
            sound &= problem is not None
            if loop is not None:
                weight = loop.weight
                states = usable.states[np.array(loop.nodes) % len(usable.states)].tolist()
                lasso = self._lasso(q * self.system.n_states + states[0], states)
        return lasso if sound else replace(lasso, optimal=False, gap=gap_between(bound, weight))

    def _profile_problem(
        self, reader: Automaton, final: NDArray, prices: NDArray, weight: float, usable: _Usable
    ) -> LoopProblem | None:
        """Loops of TS with words that are read to a final state; None if that is too large."""
        if reader.n_states * max(len(usable.graph.targets), len(usable.states)) > MOST_EDGES:
            return None
        graph = multiply(usable.graph, self.letter[usable.states], reader, roots=True).graph
        n_states, states = len(usable.states), np.flatnonzero(prices + usable.lengths < weight)
        goals = states[:, None] + np.flatnonzero(final) * n_states
        roots = states + reader.initial * n_states
        return LoopProblem(graph, roots, goals, prices[states], self._features(usable.states[states]))


@dataclass(frozen=True, eq=False)
class _Usable:
    """A few states of TS, U of them, with some of its transitions."""

    graph: Graph
    states: NDArray[np.int64]
    """(U,)"""
    lengths: NDArray[np.float64]
    """(U,): no loop that begins in one of the states has less weight."""

    @classmethod
    def of(cls, part: Part, n_system: int, lengths: NDArray) -> _Usable:
        """Those that a part of a product is made of; lengths (S,) for all states."""
        shown, graph = part.nodes % n_system, part.graph
        keys, first = np.unique(shown[graph.sources] * n_system + shown[graph.targets], return_index=True)
        states, number = np.unique(np.divmod(keys, n_system), return_inverse=True)
        sources, targets = number.reshape(2, -1)
        smaller = Graph.of(len(states), sources, targets.astype(np.int32), graph.weights[first])
        return cls(smaller, states, lengths[states])


def gap_between(bound: float, weight: float) -> float:
    """Share of the cost between two weights (`weights.lexicographic`)."""
    cost, least = weight // COST_UNIT, bound // COST_UNIT
    return (cost - least) / cost if cost else 0.0
