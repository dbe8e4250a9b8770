"""How far the marks of a product are, whatever it costs to get to where a loop begins."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.acceptance import renumbered
from drake_ltl.planning.distances import distances, least, single, way
from drake_ltl.planning.product import Graph, Part

MOST_MASKS = 1 << 16
"""So many sets of marks are counted rather than sorted."""

Features = Callable[[NDArray], NDArray]
"""Of nodes of a product, (n,) -> (n, F): see `LoopProblem`."""


@dataclass(frozen=True, eq=False)
class Marks:
    """Ways to marks and from them.

    Attributes:
        part: n nodes, e edges.
        full: all marks, M of them.
    """

    part: Part
    full: int

    @classmethod
    def of(cls, part: Part, full: int) -> Marks:
        """Without marks that a loop which stays in the part meets anyhow, together with some other one."""
        met = np.flatnonzero(np.bincount(part.marks, minlength=1)) if full < MOST_MASKS else np.unique(part.marks)
        where = {mark: frozenset(np.flatnonzero(met >> mark & 1).tolist()) for mark in range(full.bit_length())}
        kept: list[int] = []
        for mark in sorted(where, key=lambda mark: len(where[mark])):  # the rare ones bring others with them
            if not any(where[other] <= where[mark] for other in kept):
                kept.append(mark)
        if len(kept) == full.bit_length():
            return cls(part, full)
        return cls(replace(part, marks=renumbered(part.marks, kept)), (1 << len(kept)) - 1)

    @property
    def each(self) -> range:
        """The marks by their numbers."""
        return range(self.full.bit_length())

    @cached_property
    def ahead(self) -> NDArray[np.float64]:
        """(M, n): the least way that ends with an edge with each mark."""
        return self._trees[0]

    @cached_property
    def since(self) -> NDArray[np.float64]:
        """(M, n): the least way from the end of an edge with each mark."""
        graph, offsets = self.part.graph, np.full((len(self.each), self.part.n_nodes), np.inf)
        for mark, edges in enumerate(self._edges):
            offsets[mark, graph.targets[edges]] = 0.0
        return distances(graph, offsets)[0]

    @cached_property
    def round_about(self) -> NDArray[np.float64]:
        """(n,): no loop that begins in a node has less weight: it leads to each mark, and from there back."""
        return (self.ahead + self.since).max(axis=0)

    @cached_property
    def back(self) -> Graph:
        """The graph with all edges turned round."""
        return self.part.graph.reversed()

    def least_entering(self, values: NDArray) -> NDArray[np.float64]:
        """(M, n): the least of the values (e,) of the edges with each mark that lead to each node."""
        n, targets = self.part.n_nodes, self.part.graph.targets
        return np.array([least(n, targets[rows], values[rows]) for rows in self._edges])

    def least_leaving(self, values: NDArray) -> NDArray[np.float64]:
        """(M, n): the least of the values (e,) of the edges with each mark that begin in each node."""
        marks, graph = self.part.marks, self.part.graph
        marked = (np.where(marks & (1 << mark), values, np.inf) for mark in self.each)
        return np.array([graph.folded(np.minimum, of_mark, np.inf) for of_mark in marked])

    @cached_property
    def _edges(self) -> list[NDArray[np.int64]]:
        """The edges with each mark."""
        return [np.flatnonzero(self.part.marks & (1 << mark)) for mark in self.each]

    def collect(self, node: int) -> list[int]:
        """A walk from a node that meets all marks, always on to the nearest."""
        graph, (distance, onwards) = self.part.graph, self._trees
        walk, missing = [node], self.full
        while missing:
            mark = min((m for m in self.each if missing >> m & 1), key=lambda m: distance[m, walk[-1]])
            walk += way(onwards[mark], walk[-1])[-2::-1]
            edges = np.arange(graph.starts[walk[-1]], graph.starts[walk[-1] + 1])
            edges = edges[self.part.marks[edges] >> mark & 1 > 0]
            edge = edges[np.argmin(graph.weights[edges])]
            walk.append(int(graph.targets[edge]))
            missing &= ~int(self.part.marks[edge])
        return walk

    def closed(self, walk: list[int]) -> list[int]:
        """A walk and the shortest way back to its first node, which stands at the end again."""
        graph = self.part.graph
        return walk[:-1] + way(distances(graph, single(graph.n_nodes, walk[-1]))[1], walk[0])

    @cached_property
    def _trees(self) -> tuple[NDArray, NDArray]:
        """The least way to each mark from every node, (M, n), and the next node on it, (M, n)."""
        return distances(self.back, self.least_leaving(self.part.graph.weights))
