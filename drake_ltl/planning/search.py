"""The lasso of least J = alpha cost(prefix) + beta cost(suffix) among all lassos of the transition system.

What counts is the run prefix, suffix, suffix ..: the automaton need not be back in the same state after one round.
A loop that is closed in the product too is found by Dijkstra over sets of marks (`layers`). Its price is the way
to its root: to the root's product node for an upper bound, to its state of TS, whatever the automaton's state, for
a lower bound if the automaton never counts (`never_counts`). Where the two do not meet, the search goes on among
the loops that only later rounds close, over profiles: that is exact for every automaton, and slower.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.automaton import Automaton, never_counts
from drake_ltl.planning.distances import distances, way
from drake_ltl.planning.layers import Marks
from drake_ltl.planning.loops import LoopProblem, cheapest_loop
from drake_ltl.planning.product import Graph, Part, Product, accepting, accepting_part, multiply
from drake_ltl.planning.profiles import accepted_from, all_profiles, profile_of
from drake_ltl.planning.shares import LeastLoop, layered_loop, shared_out
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
    def of(cls, product: Product) -> _Prefixes:
        offsets = np.full(product.graph.n_nodes, np.inf)
        offsets[product.initial] = 0.0
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
    system = _readable(system, letter, automaton)
    _check_size(system, automaton)
    largest = max(alpha, beta) * float(system.costs.max(initial=0.0))
    weights = lexicographic(beta * system.costs, system.actions, largest)
    product = multiply(system, letter, weights, automaton, start)
    if alpha == beta:
        prefixes = _Prefixes.of(product)
    else:
        other = lexicographic(alpha * system.costs, system.actions, largest)
        prefixes = _Prefixes.of(multiply(system, letter, other, automaton, start))
    component = accepting(product, np.isfinite(prefixes.distance), automaton.full)
    if not (component >= 0).any():
        return None
    part = accepting_part(product, component)
    return _Search(system, letter, automaton, weights, prefixes, part).run()


def has_lasso(system: TransitionSystem, letter: NDArray, automaton: Automaton, start: int) -> bool:
    """Whether any run from `start` is accepted."""
    system = _readable(system, letter, automaton)
    product = multiply(system, letter, np.ones(system.n_transitions), automaton, start)
    reachable = np.isfinite(_Prefixes.of(product).distance)
    return bool((accepting(product, reachable, automaton.full) >= 0).any())


def _readable(system: TransitionSystem, letter: NDArray, automaton: Automaton) -> TransitionSystem:
    """TS without transitions between states whose letters no state of the automaton reads."""
    readable = (automaton.successors >= 0).any(axis=(0, 2))[letter]
    return system if readable.all() else system.keep(readable[system.sources] & readable[system.targets])


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
    part: Part,
    full: int,
    prices: NDArray,
    features: Callable[[NDArray], NDArray],
    limit: float = np.inf,
) -> ClosedLoop:
    """The cheapest loop with all marks, closed in the product.

    Args:
        part: n nodes.
        full: all marks.
        prices: (n,), what it costs to begin a loop at each node; finite for some.
        features: of nodes of the product, for `LoopProblem`.
        limit: no loop of this price + weight or more is looked for; if there is none below, any is returned.
    """
    marks = Marks(part, full, prices)
    nodes, weight = marks.some_loop()
    if full >= MOST_LAYERS:
        return ClosedLoop(nodes, weight, marks.bound)
    below = min(weight + 1.0, limit)  # weights are integers: the loop known already stays
    found = layered_loop(marks, features, below, MOST_LAYERED_EDGES)
    least = shared_out(marks, features, below, MOST_LAYERED_EDGES) if found is None else LeastLoop(*found, found[1])
    if least.nodes:
        return ClosedLoop(least.nodes, least.weight, least.bound)
    return ClosedLoop(nodes, weight, min(least.bound, weight))


@dataclass(frozen=True, eq=False)
class _Search:
    system: TransitionSystem
    letter: NDArray
    automaton: Automaton
    weights: NDArray
    prefixes: _Prefixes
    part: Part

    def run(self) -> Lasso:
        to_node = self.prefixes.distance[self.part.nodes]
        to_state = self.prefixes.by_state().min(axis=0)[self.part.nodes % self.system.n_states]
        bound, nearest = float(to_state.min()), bool((to_state == to_node).all())
        settled = never_counts(self.automaton)
        if settled and not nearest:
            relaxed = self._closed(to_state)
            lasso = self._closed_anyhow(relaxed)
            if lasso is not None:
                return lasso
            bound = relaxed.bound
        closed = self._closed(to_node)
        if settled and nearest:
            bound = closed.bound
        lasso = self._lasso(int(self.part.nodes[closed.nodes[0]]), self._states(closed))
        if closed.weight == bound:
            return lasso
        if closed.weight > closed.bound:
            return replace(lasso, optimal=False, gap=gap_between(bound, closed.weight))
        return self._over_profiles(lasso, closed.weight, bound)

    def _closed(self, prices: NDArray) -> ClosedLoop:
        """The cheapest loop of the product."""
        return closed_loop(self.part, self.automaton.full, prices, self._features)

    def _features(self, nodes: NDArray) -> NDArray[np.int64]:
        """Objects first: to bring one back takes a team, so loops that begin elsewhere differ most in cost."""
        states, system = nodes % self.system.n_states, self.system
        return np.column_stack([system.places[states], system.options[states], nodes // system.n_states])

    def _states(self, closed: ClosedLoop) -> list[int]:
        """The loop's states of TS, the first one at its end again."""
        return (self.part.nodes[closed.nodes] % self.system.n_states).tolist()

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

    def _over_profiles(self, lasso: Lasso, weight: float, bound: float) -> Lasso:
        """Exact search for a loop that is not closed after one round and better than a lasso; the lasso itself if
        there is none, or too much to search."""
        by_state = self.prefixes.by_state()
        profiles = all_profiles(self.automaton, self.letter[by_state.min(axis=0) < weight], MOST_PROFILES)
        if profiles is None:
            return replace(lasso, optimal=False, gap=gap_between(bound, weight))
        sound = True
        for q, prices in enumerate(by_state):
            later = profiles.closed_later(q) if (prices < weight).any() else None
            if later is None:
                continue
            problem = self._profile_problem(*later, prices, weight)
            loop = None if problem is None else cheapest_loop(problem, weight)
            sound &= problem is not None
            if loop is not None:
                weight = loop.weight
                states = [node % self.system.n_states for node in loop.nodes]
                lasso = self._lasso(q * self.system.n_states + states[0], states)
        return lasso if sound else replace(lasso, optimal=False, gap=gap_between(bound, weight))

    def _profile_problem(self, reader: Automaton, final: NDArray, prices: NDArray, weight: float) -> LoopProblem | None:
        """Loops of TS with words that are read to a final state; None if that is too large."""
        system = self.system
        starts = np.searchsorted(system.sources, np.arange(system.n_states + 1)).astype(np.int32)
        begun = distances(Graph(starts, system.targets, self.weights), prices, weight)[0]
        kept = begun[system.sources] + self.weights < weight
        if reader.n_states * max(int(kept.sum()), system.n_states) > MOST_EDGES:
            return None
        graph = multiply(system.keep(kept), self.letter, self.weights[kept], reader, 0).graph
        states = np.flatnonzero(prices < weight)
        goals = states[:, None] + np.flatnonzero(final) * system.n_states
        roots = states + reader.initial * system.n_states
        return LoopProblem(graph, roots, goals, prices[states], self._features(states))


def gap_between(bound: float, weight: float) -> float:
    """Share of the cost between two weights (`weights.lexicographic`)."""
    cost, least = weight // COST_UNIT, bound // COST_UNIT
    return (cost - least) / cost if cost else 0.0
