"""The lasso of least J = alpha cost(prefix) + beta cost(suffix) among all lassos of the transition system.

What counts is the run prefix, suffix, suffix ..: the automaton need not be back in the same state after one round.
A loop that is closed in the product too is found by Dijkstra over sets of marks (`layers`). Its price is the way
to its root: to the root's product node for an upper bound, to its state of TS, whatever the automaton's state, for
a lower bound if the automaton never counts (`never_counts`). Where the two do not meet, the search goes on among
the loops that only later rounds close (`rounds`), or, for automata that may count, over profiles, which is slower.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.automaton import Automaton
from drake_ltl.planning.distances import distances, way
from drake_ltl.planning.layers import MOST_LAYERED_EDGES, Priced
from drake_ltl.planning.loops import LoopProblem, cheapest_loop
from drake_ltl.planning.marks import Features, Marks
from drake_ltl.planning.orbits import nearest_accepted
from drake_ltl.planning.product import Graph, Part, Product, accepting_part, count_edges, entered, multiply
from drake_ltl.planning.profiles import all_profiles
from drake_ltl.planning.rounds import ReadLoop, Rounds, are_few
from drake_ltl.planning.shares import least_loop
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
    before: NDArray[np.int32]

    @classmethod
    def of(cls, product: Product, letter: NDArray, automaton: Automaton, start: int) -> _Prefixes:
        """A run begins in state `start` of TS, whose letter the automaton has read."""
        first = automaton.successors[automaton.initial, letter[start]]
        offsets = np.full(product.graph.n_nodes, np.inf)
        if first >= 0:
            offsets[first * product.n_system + start] = 0.0
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
    graph = _graph(system)
    _check_size(graph, letter, automaton)
    largest = max(alpha, beta) * float(system.costs.max(initial=0.0))

    def product_with(reader: Automaton, weight: float) -> Product:
        weights = lexicographic(weight * system.costs, system.actions, largest)
        return multiply(replace(graph, weights=weights), letter, reader)

    product = product_with(automaton, beta)
    prefixes = _Prefixes.of(product if alpha == beta else product_with(automaton, alpha), letter, automaton, start)
    reachable, parts = np.isfinite(prefixes.distance), []
    for rules in automaton.for_loops():
        loops = product if rules is automaton else product_with(rules, beta)
        part = accepting_part(loops, reachable, rules.full)
        parts += [Marks.of(part, rules.full)] if part.n_nodes else []
    return _Search(system, letter, automaton, prefixes).among(parts) if parts else None


def has_lasso(system: TransitionSystem, letter: NDArray, automaton: Automaton, start: int) -> bool:
    """Whether any run from `start` is accepted."""
    graph = replace(_graph(system), weights=np.ones(system.n_transitions))
    reachable = np.isfinite(_Prefixes.of(multiply(graph, letter, automaton), letter, automaton, start).distance)
    return any(
        accepting_part(multiply(graph, letter, rules), reachable, rules.full).n_nodes > 0
        for rules in automaton.for_loops()
    )


def _graph(system: TransitionSystem) -> Graph:
    return Graph.of(system.n_states, system.sources, system.targets, system.costs)


def _check_size(system: Graph, letter: NDArray, automaton: Automaton) -> None:
    n_nodes, edges = system.n_nodes * automaton.n_states, count_edges(system, letter, automaton)
    if max(edges, n_nodes) > MOST_EDGES:
        raise SearchLimitError(f"the product of TS and the automaton is too large: {n_nodes} nodes, {edges} edges")


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


@dataclass(frozen=True)
class _Best:
    """The least lasso that is known, and what is known of better ones whose loops keep to one part of a product."""

    lasso: Lasso
    weight: float
    closed: float
    """None whose loop is closed in the product has less; may be above `weight`."""
    later: float
    """None whose loop is closed only by later rounds has less."""

    @property
    def bound(self) -> float:
        """No such lasso has less."""
        return min(self.closed, self.later)


@dataclass(frozen=True, eq=False)
class _Search:
    system: TransitionSystem
    letter: NDArray
    automaton: Automaton
    prefixes: _Prefixes

    def among(self, parts: list[Marks]) -> Lasso:
        """The least lasso whose loop keeps for ever to any of some accepting parts of products."""
        settled = self.automaton.never_counts
        firsts = [
            self._in_all_rounds(part) if settled and are_few(part) else self._closed_in(part, settled) for part in parts
        ]
        best, bound = min(firsts, key=lambda first: first.weight), np.inf
        for part, first in zip(parts, firsts, strict=True):
            if first.later < best.weight:
                read_later = self._in_rounds if settled else self._over_profiles
                best = first = read_later(part, replace(first, lasso=best.lasso, weight=best.weight))
            bound = min(bound, first.bound)
        gap = max(0.0, gap_between(bound, best.weight))
        return replace(best.lasso, optimal=bound >= best.weight, gap=gap)

    def _closed_in(self, marks: Marks, settled: bool) -> _Best:
        """The least lasso whose loop is closed in the product."""
        nodes = marks.part.nodes
        to_node, to_state = self.prefixes.distance[nodes], self._to_state(marks)
        nearest, bound, known = bool((to_state == to_node).all()), float(to_state.min()), None
        if settled and not nearest:
            relaxed = closed_loop(marks, to_state, self._features)
            lasso = self._accepted_anyhow(marks, relaxed)
            if lasso is not None:
                return _Best(lasso, relaxed.weight, relaxed.weight, relaxed.weight)
            bound, known = relaxed.bound, relaxed.nodes
        closed = closed_loop(marks, to_node, self._features, known=known)
        lasso = self._lasso(int(nodes[closed.nodes[0]]), self._states(marks, closed.nodes))
        return _Best(lasso, closed.weight, closed.bound, np.inf if settled and nearest else bound)

    def _in_all_rounds(self, marks: Marks) -> _Best:
        """The least lasso, whether its loop is closed at once or by later rounds."""
        to_node = self.prefixes.distance[marks.part.nodes]
        nodes, weight = Priced(marks, to_node).some_loop()
        loop, bound = self._rounds.cheapest(marks, weight + 1.0, 0)  # finds the known one if there is no better one
        if loop is not None:
            return _Best(self._read(loop), loop.weight, bound, bound)
        lasso = self._lasso(int(marks.part.nodes[nodes[0]]), self._states(marks, nodes))
        return _Best(lasso, weight, bound, bound)

    def _to_state(self, marks: Marks) -> NDArray[np.float64]:
        """(n,): the least way to the state of TS of each node, whatever the automaton's state."""
        return self.prefixes.by_state().min(axis=0)[marks.part.nodes % self.system.n_states]

    def _features(self, nodes: NDArray) -> NDArray[np.int64]:
        """Objects first: to bring one back takes a team, so loops that begin elsewhere differ most in cost."""
        states, system = nodes % self.system.n_states, self.system
        return np.column_stack([system.places[states], system.options[states], nodes // self.system.n_states])

    def _states(self, marks: Marks, loop: list[int]) -> list[int]:
        """A loop's states of TS, from its nodes; the first one stands at its end again."""
        return (marks.part.nodes[loop] % self.system.n_states).tolist()

    def _accepted_anyhow(self, marks: Marks, loop: ClosedLoop) -> Lasso | None:
        """The lasso of the loop and the shortest way to its first state, if its word is accepted."""
        if loop.weight > loop.bound:
            return None
        states = self._states(marks, loop.nodes)
        q = nearest_accepted(self.automaton, self.letter[states[1:]].tolist(), self.prefixes.by_state()[:, states[0]])
        return None if q is None else self._lasso(q * self.system.n_states + states[0], states)

    def _lasso(self, root: int, states: list[int]) -> Lasso:
        """The shortest way to product node `root`, then a loop that begins in the same state of TS."""
        return Lasso(tuple(self.prefixes.path(root)[:-1]), tuple(states[:-1]), True, 0.0)

    @property
    def _rounds(self) -> Rounds:
        by_state = self.prefixes.by_state()
        return Rounds(self.automaton, self.letter, by_state, by_state.min(axis=0), self._features)

    def _read(self, loop: ReadLoop) -> Lasso:
        return self._lasso(loop.first * self.system.n_states + loop.states[0], loop.states)

    def _in_rounds(self, marks: Marks, best: _Best) -> _Best:
        """Exact search for a loop that is better than the best known and not closed after one round (`rounds`);
        `later` says how far it came if that is too much to search."""
        loop, bound = self._rounds.cheapest(marks, best.weight)
        best = replace(best, later=max(best.later, bound))
        return best if loop is None else replace(best, lasso=self._read(loop), weight=loop.weight)

    def _over_profiles(self, marks: Marks, best: _Best) -> _Best:
        """As `_in_rounds`, by the profiles of words (`profiles`), for automata that may count."""
        priced = Priced(marks, self._to_state(marks))
        part = priced.within(np.flatnonzero(priced.prices < best.weight), best.weight)[0].marks.part
        usable = _Usable.of(part, self.system.n_states)
        try:
            profiles = all_profiles(self.automaton, self.letter[usable.states], MOST_PROFILES)
            for q, prices in enumerate(self.prefixes.by_state()[:, usable.states]):
                later = profiles.closed_later(q) if (prices < best.weight).any() else None
                if later is None:
                    continue
                begins = np.flatnonzero(prices < best.weight)
                problem = self._profile_problem(*later, begins, usable)
                loop = cheapest_loop(problem, prices[begins], best.weight)
                if loop is not None:
                    states = usable.states[np.array(loop.nodes) % len(usable.states)].tolist()
                    lasso = self._lasso(q * self.system.n_states + states[0], states)
                    best = replace(best, lasso=lasso, weight=loop.weight)
        except SearchLimitError:
            return best
        return replace(best, later=best.weight)

    def _profile_problem(self, reader: Automaton, final: NDArray, states: NDArray, usable: _Usable) -> LoopProblem:
        """Loops of TS that begin in some states and whose words are read to a final state."""
        if reader.n_states * max(len(usable.graph.targets), len(usable.states)) > MOST_EDGES:
            raise SearchLimitError(f"a product with {reader.n_states} profiles is too large")
        letter = self.letter[usable.states]
        alive = entered(reader, letter)
        alive[reader.initial] = True  # nothing has been read
        graph = multiply(usable.graph, letter, reader, alive).graph
        n_states = len(usable.states)
        goals = states[:, None] + np.flatnonzero(final) * n_states
        roots = states + reader.initial * n_states
        return LoopProblem(graph, roots, goals, self._features(usable.states[states]))


@dataclass(frozen=True, eq=False)
class _Usable:
    """A few states of TS, U of them, with some of its transitions."""

    graph: Graph
    states: NDArray[np.int64]
    """(U,)"""

    @classmethod
    def of(cls, part: Part, n_system: int) -> _Usable:
        """Those that a part of a product is made of."""
        shown, graph = part.nodes % n_system, part.graph
        keys, first = np.unique(shown[graph.sources] * n_system + shown[graph.targets], return_index=True)
        states, number = np.unique(np.divmod(keys, n_system), return_inverse=True)
        sources, targets = number.reshape(2, -1)
        return cls(Graph.of(len(states), sources, targets.astype(np.int32), graph.weights[first]), states)


def gap_between(bound: float, weight: float) -> float:
    """Share of the cost between two weights (`weights.lexicographic`)."""
    cost, least = weight // COST_UNIT, bound // COST_UNIT
    return (cost - least) / cost if cost else 0.0
