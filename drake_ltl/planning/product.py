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
        return self.at_sources(np.arange(self.n_nodes, dtype=np.int32))

    def at_sources(self, values: NDArray) -> NDArray:
        """(e,): of values of the nodes, (n,), the one of the node in which each edge begins."""
        return np.repeat(values, np.diff(self.starts))

    def at_targets(self, values: NDArray) -> NDArray:
        """(e,): of values of the nodes, (n,), the one of the node in which each edge ends."""
        return values[self.targets.astype(np.intp)]  # three times faster than by shorter integers

    def edges_of(self, nodes: NDArray) -> NDArray[np.int64]:
        """The edges of some nodes, one node after the other."""
        lengths = self.starts[nodes + 1] - self.starts[nodes]
        ends = np.cumsum(lengths, dtype=np.int64)
        return np.arange(ends[-1] if len(ends) else 0) + np.repeat(self.starts[nodes] - (ends - lengths), lengths)

    def folded(self, fold: np.ufunc, values: NDArray, nothing: float) -> NDArray:
        """(n,): values of the edges, (e,), folded for the node in which they begin; `nothing` where none does."""
        begun = np.flatnonzero(np.diff(self.starts))
        result = np.full(self.n_nodes, nothing, dtype=values.dtype)
        result[begun] = fold.reduceat(values, self.starts[begun])
        return result

    def part(self, nodes: NDArray, edges: NDArray) -> Graph:
        """Only some nodes, (m,), and some of the edges between them, both increasing."""
        number = np.full(self.n_nodes, -1, dtype=np.int32)
        number[nodes] = np.arange(len(nodes))
        starts = np.append(np.searchsorted(edges, self.starts[nodes]), len(edges)).astype(np.int32)
        return Graph(starts, number[self.targets[edges].astype(np.intp)], self.weights[edges])

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
    marks: NDArray[np.integer]
    """(e,): marks met on each edge, in the shortest numbers that hold them."""
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
    met = automaton.marks.astype(np.min_scalar_type(int(automaton.marks.max(initial=0))))
    lengths, pieces, n_edges = np.diff(system.starts), [], 0
    for q in range(automaton.n_states):
        successors = automaton.successors[q].astype(np.int32)[letter]
        onto = np.where(successors >= 0, successors * np.int32(n_system) + states, np.int32(-1))
        edge, ends = system.edges_of(np.flatnonzero(alive[q])), np.cumsum(np.where(alive[q], lengths, 0))
        after = system.targets[edge].astype(np.intp)  # finds values three times faster than shorter integers
        target = onto[after]
        if (successors < 0).any():
            read = np.flatnonzero(target >= 0)
            edge, after, target, ends = edge[read], after[read], target[read], np.searchsorted(read, ends)
        pieces.append((n_edges + ends, target, system.weights[edge], met[q][letter][after]))
        n_edges += len(edge)
        if n_edges > most_edges:
            raise SearchLimitError(f"a product has more than {most_edges} edges")
    ends, targets, weights, marks = (np.concatenate(column) for column in zip(*pieces, strict=True))
    starts = np.append(0, ends).astype(np.int32)
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
    marks: NDArray[np.integer]
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
    graph = product.graph
    n_components, component = connected_components(graph.matrix(), connection="strong")
    inside = graph.at_sources(component) == graph.at_targets(component)
    collected = np.zeros(n_components, dtype=product.marks.dtype)
    np.bitwise_or.at(collected, component, graph.folded(np.bitwise_or, product.marks * inside, 0))
    good = reachable & (collected == full)[component]
    nodes, kept = np.flatnonzero(good), np.flatnonzero(inside & graph.at_sources(good))
    return Part(graph.part(nodes, kept), product.marks[kept], nodes)
