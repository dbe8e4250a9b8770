"""The product of a transition system with an automaton, as a graph in compressed rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array
from scipy.sparse.csgraph import connected_components

from drake_ltl.planning.automaton import Automaton
from drake_ltl.planning.transition_system import TransitionSystem


@dataclass(frozen=True, eq=False)
class Graph:
    """A weighted directed graph; parallel edges are allowed."""

    starts: NDArray[np.int32]
    """(n + 1,): the edges of node i are starts[i] .. starts[i + 1]."""
    targets: NDArray[np.int32]
    """(e,)"""
    weights: NDArray[np.float64]
    """(e,)"""

    @property
    def n_nodes(self) -> int:
        return len(self.starts) - 1

    @property
    def sources(self) -> NDArray[np.int64]:
        """(e,): node in which each edge begins."""
        return np.repeat(np.arange(self.n_nodes), np.diff(self.starts))

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
    initial: NDArray[np.int64]
    """Nodes in which a run begins."""
    n_system: int
    """S."""
    parallel: bool = True
    """Whether there may be several edges between the same nodes."""


def multiply(system: TransitionSystem, letter: NDArray, weights: NDArray, automaton: Automaton, start: int) -> Product:
    """TS x BA.

    Args:
        system: the transition system.
        letter: (S,), the letter of each of its states.
        weights: (E,), weight of each of its transitions.
        automaton: reads letters.
        start: state of the system in which the run begins; the automaton reads its letter first.

    Returns:
        Nodes whose state of the automaton is not entered by their letter have no edges: no run reaches them.
    """
    n_system, n_automaton = system.n_states, automaton.n_states
    shown, read = letter[system.sources], letter[system.targets]
    entered, goes_on = _entered(automaton), (automaton.successors >= 0).any(axis=2)
    successors = automaton.successors.astype(np.int32)
    counts, targets, marks, weight = [], [], [], []
    for q in range(n_automaton):
        edge = np.flatnonzero(entered[q][shown] & goes_on[q][read])
        successor = successors[q][read[edge]].reshape(-1)
        met = automaton.marks[q][read[edge]].reshape(-1)
        if not automaton.deterministic:
            there = np.flatnonzero(successor >= 0)
            edge, successor, met = edge[there // successors.shape[2]], successor[there], met[there]
        counts.append(np.bincount(system.sources[edge], minlength=n_system))
        targets.append(successor * np.int32(n_system) + system.targets[edge])
        marks.append(met)
        weight.append(weights[edge])
    starts = np.concatenate([[0], np.cumsum(np.concatenate(counts))]).astype(np.int32)
    graph = Graph(starts, np.concatenate(targets), np.concatenate(weight))
    first = automaton.successors[automaton.initial, letter[start]]
    initial = np.unique(first[first >= 0]) * n_system + start
    return Product(graph, np.concatenate(marks), initial, n_system, parallel=not automaton.deterministic)


def _entered(automaton: Automaton) -> NDArray[np.bool_]:
    """(Q, L): which letters lead into which states; any may be shown in the initial one, where runs begin."""
    entered = np.zeros(automaton.successors.shape[:2], dtype=bool)
    _, letter, _ = np.indices(automaton.successors.shape)
    there = automaton.successors >= 0
    entered[automaton.successors[there], letter[there]] = True
    entered[automaton.initial] = True
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


def accepting_part(product: Product, component: NDArray) -> Part:
    """What `accepting` found, by itself."""
    graph, sources = product.graph, product.graph.sources
    begins = component[sources]
    kept = np.flatnonzero((begins >= 0) & (begins == component[graph.targets]))
    nodes = np.flatnonzero(component >= 0)
    local = np.full(graph.n_nodes, -1, dtype=np.int32)
    local[nodes] = np.arange(len(nodes))
    counts = np.bincount(local[sources[kept]], minlength=len(nodes))
    starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
    return Part(Graph(starts, local[graph.targets[kept]], graph.weights[kept]), product.marks[kept], nodes)


def accepting(product: Product, reachable: NDArray[np.bool_], full: int) -> NDArray[np.int64]:
    """The nodes that lie on accepting loops, as strongly connected components.

    Args:
        product: n nodes.
        reachable: (n,), which nodes a run can reach.
        full: all marks.

    Returns:
        (n,): number of the component, or -1 for a node outside all components whose edges carry all marks.
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
    return np.where(reachable & (collected == full)[component], component, -1)
