"""The product of a transition system with an automaton, as a graph in compressed rows."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array
from scipy.sparse.csgraph import connected_components

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.automaton import Automaton


@dataclass(frozen=True, eq=False)
class Graph:
    """A weighted directed graph."""

    starts: NDArray[np.int32]
    """(n + 1,): the edges of node i are starts[i] .. starts[i + 1]."""
    targets: NDArray[np.int32]
    """(e,)"""
    weights: NDArray[np.float64]
    """(e,)"""

    @classmethod
    def of(cls, n_nodes: int, sources: NDArray, targets: NDArray, weights: NDArray) -> Graph:
        """Edges given one by one, (e,) each, sorted by source."""
        starts = np.zeros(n_nodes + 1, dtype=np.int32)
        np.cumsum(np.bincount(sources, minlength=n_nodes), out=starts[1:])
        return cls(starts, targets, weights)

    @property
    def n_nodes(self) -> int:
        return len(self.starts) - 1

    @cached_property
    def sources(self) -> NDArray[np.int32]:
        """(e,): node in which each edge begins."""
        return np.repeat(np.arange(self.n_nodes, dtype=np.int32), np.diff(self.starts))

    def edges_of(self, nodes: NDArray) -> NDArray[np.int64]:
        """The edges of some nodes, one node after the other."""
        lengths = self.starts[nodes + 1] - self.starts[nodes]
        ends = np.cumsum(lengths, dtype=np.int64)
        return np.arange(ends[-1] if len(ends) else 0) + np.repeat(self.starts[nodes] - (ends - lengths), lengths)

    def reversed(self) -> Graph:
        """The same with all edges turned round."""
        back = csc_array((self.weights, self.targets, self.starts), shape=(self.n_nodes, self.n_nodes)).tocsr()
        return Graph(back.indptr, back.indices, back.data)

    def matrix(self) -> csr_array:
        """The graph for `scipy.sparse.csgraph`; made of the arrays themselves, so that nothing is added up."""
        return csr_array((self.weights, self.targets, self.starts), shape=(self.n_nodes, self.n_nodes))


@dataclass(frozen=True, eq=False)
class Product:
    """Nodes q * S + s: the transition system is in state s, whose letter brought the automaton to state q."""

    graph: Graph
    marks: NDArray[np.int64]
    """(e,): marks met on each edge."""
    n_system: int
    """S."""


def multiply(
    system: Graph,
    letter: NDArray,
    automaton: Automaton,
    alive: NDArray[np.bool_] | None = None,
    most_edges: float = np.inf,
) -> Product:
    """TS x BA.

    Args:
        system: the transition system, S states.
        letter: (S,), the letter of each of its states.
        automaton: reads letters; Q states.
        alive: (Q, S), which nodes may have edges; None takes those whose state of the automaton is entered by their
            letter, for no run reaches others.
        most_edges: not to be exceeded.

    Raises:
        SearchLimitError: there are more edges.
    """
    n_system, states = system.n_nodes, np.arange(system.n_nodes, dtype=np.int32)
    alive = entered(automaton, letter) if alive is None else alive
    lengths, pieces, n_edges = np.diff(system.starts), [], 0
    for q in range(automaton.n_states):
        nodes = np.flatnonzero(alive[q])
        successors = automaton.successors[q].astype(np.int32)[letter]
        onto = np.where(successors >= 0, successors * np.int32(n_system) + states, np.int32(-1))
        edge, counts = system.edges_of(nodes), np.where(alive[q], lengths, 0)
        target = onto[system.targets[edge]]
        if (successors < 0).any():
            read = np.flatnonzero(target >= 0)
            edge, target = edge[read], target[read]
            counts = np.bincount(system.sources[edge], minlength=n_system)
        n_edges += len(edge)
        if n_edges > most_edges:
            raise SearchLimitError(f"a product has more than {most_edges} edges")
        marks = automaton.marks[q][letter]
        pieces.append((counts, target, system.weights[edge], marks[system.targets[edge]]))
    counts, targets, weights, marks = (np.concatenate(column) for column in zip(*pieces, strict=True))
    starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
    return Product(Graph(starts, targets, weights), marks, n_system)


def entered(automaton: Automaton, letter: NDArray) -> NDArray[np.bool_]:
    """(Q, S): which states of the automaton are entered by which letters (S,)."""
    return _entered_by(automaton)[:, letter]


def _entered_by(automaton: Automaton) -> NDArray[np.bool_]:
    """(Q, L)"""
    by_letter = np.zeros(automaton.successors.shape, dtype=bool)
    q, read = np.nonzero(automaton.successors >= 0)
    by_letter[automaton.successors[q, read], read] = True
    return by_letter


def count_edges(system: Graph, letter: NDArray, automaton: Automaton) -> int:
    """At most so many edges has the product of `multiply`, the successors that the automaton does not read included."""
    alive = _entered_by(automaton)
    onwards = np.bincount(letter, weights=np.diff(system.starts), minlength=alive.shape[1])
    return int((alive @ onwards).sum())


@dataclass(frozen=True, eq=False)
class Part:
    """The nodes of a product that lie on accepting loops, and the edges inside their components."""

    graph: Graph
    """n nodes, e edges."""
    marks: NDArray[np.int64]
    """(e,)"""
    nodes: NDArray[np.int64]
    """(n,): nodes of the product."""

    @property
    def n_nodes(self) -> int:
        return len(self.nodes)


def accepting_part(product: Product, reachable: NDArray[np.bool_], full: int) -> Part:
    """The strongly connected components whose edges carry all marks.

    Args:
        product: n nodes, not more than one edge from one to another (SciPy's search may never end on others).
        reachable: (n,), which nodes a run can reach.
        full: all marks.
    """
    graph, sources = product.graph, product.graph.sources
    n_components, component = connected_components(graph.matrix(), connection="strong")
    inside = component[sources] == component[graph.targets]
    begun, collected = np.flatnonzero(np.diff(graph.starts)), np.zeros(n_components, dtype=np.int64)
    if len(begun):
        by_node = np.bitwise_or.reduceat(np.where(inside, product.marks, 0), graph.starts[begun])
        np.bitwise_or.at(collected, component[begun], by_node)
    good = reachable & (collected == full)[component]
    nodes, kept = np.flatnonzero(good), np.flatnonzero(inside & good[sources])
    local = np.full(graph.n_nodes, -1, dtype=np.int32)
    local[nodes] = np.arange(len(nodes))
    smaller = Graph.of(len(nodes), local[sources[kept]], local[graph.targets[kept]], graph.weights[kept])
    return Part(smaller, product.marks[kept], nodes)
