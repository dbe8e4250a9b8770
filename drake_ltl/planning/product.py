"""The product of a transition system with an automaton, as a graph in compressed rows."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array
from scipy.sparse.csgraph import connected_components

from drake_ltl.planning.automaton import Automaton


@dataclass(frozen=True, eq=False)
class Graph:
    """A weighted directed graph; parallel edges are allowed."""

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
    parallel: bool = True
    """Whether there may be several edges between the same nodes."""


def multiply(system: Graph, letter: NDArray, automaton: Automaton, roots: bool = False) -> Product:
    """TS x BA.

    Args:
        system: the transition system, S states.
        letter: (S,), the letter of each of its states.
        automaton: reads letters.
        roots: whether there also are the nodes (initial state, s), in which nothing has been read. Otherwise nodes
            whose state of the automaton is not entered by their letter have no edges: no run reaches them.
    """
    n_system, states = system.n_nodes, np.arange(system.n_nodes, dtype=np.int32)
    entered, goes_on = _entered(automaton), (automaton.successors >= 0).any(axis=2)
    if roots:
        entered[automaton.initial] = True
    pieces = []
    for q in range(automaton.n_states):
        edge = np.flatnonzero(entered[q][letter][system.sources] & goes_on[q][letter][system.targets])
        target = system.targets[edge]
        onto = (automaton.successors[q].astype(np.int32) * np.int32(n_system))[letter] + states[:, None]
        after, met = onto[target].reshape(-1), automaton.marks[q][letter][target].reshape(-1)
        if not automaton.deterministic:
            there = np.flatnonzero(after >= 0)
            edge, after, met = edge[there // onto.shape[1]], after[there], met[there]
        counts = np.bincount(system.sources[edge], minlength=n_system)
        pieces.append((counts, after, system.weights[edge], met))
    counts, targets, weights, marks = (np.concatenate(column) for column in zip(*pieces, strict=True))
    starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
    return Product(Graph(starts, targets, weights), marks, n_system, parallel=not automaton.deterministic)


def _entered(automaton: Automaton) -> NDArray[np.bool_]:
    """(Q, L): which letters lead into which states."""
    entered = np.zeros(automaton.successors.shape[:2], dtype=bool)
    _, letter, _ = np.indices(automaton.successors.shape)
    there = automaton.successors >= 0
    entered[automaton.successors[there], letter[there]] = True
    return entered


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
        product: n nodes.
        reachable: (n,), which nodes a run can reach.
        full: all marks.
    """
    graph, sources = product.graph, product.graph.sources
    matrix = graph.matrix()
    if product.parallel:  # on which SciPy's search for strong components may never end
        matrix = matrix.copy()
        matrix.sum_duplicates()
    n_components, component = connected_components(matrix, connection="strong")
    begins = np.where(reachable, component, -1)[sources]
    inside = np.flatnonzero((begins >= 0) & (begins == component[graph.targets]))
    collected = np.zeros(n_components, dtype=np.int64)
    np.bitwise_or.at(collected, begins[inside], product.marks[inside])
    good = collected == full
    kept, nodes = inside[good[begins[inside]]], np.flatnonzero(reachable & good[component])
    local = np.full(graph.n_nodes, -1, dtype=np.int32)
    local[nodes] = np.arange(len(nodes))
    smaller = Graph.of(len(nodes), local[sources[kept]], local[graph.targets[kept]], graph.weights[kept])
    return Part(smaller, product.marks[kept], nodes)
