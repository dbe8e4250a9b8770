"""The accepting part of a product, once for each set of marks that a loop has collected so far.

Of these layers only what a loop cheaper than a known one can use is formed. What is known of single marks decides:
a loop that is at node v with the marks c has passed by each mark of c, and has the others before it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.distances import distances, least, single, way
from drake_ltl.planning.product import Graph, Part


@dataclass(frozen=True, eq=False)
class Layers:
    """Nodes of the graph stand for a product node together with a set of marks.

    A loop begins with no marks and has collected all of them when it is closed.
    """

    graph: Graph
    nodes: NDArray[np.int64]
    """(n,): node of the part."""
    roots: NDArray[np.int64]
    """(R,): nodes of the graph in which a loop may begin ..."""
    goals: NDArray[np.int64]
    """(R,): .. and the ones with all marks in which it is then closed."""


@dataclass(frozen=True, eq=False)
class Marks:
    """How far the marks are, each by itself.

    Attributes:
        part: n nodes, e edges.
        full: all marks, M of them.
        prices: (n,), what it costs to begin a loop at each node; inf if none may begin there.
    """

    part: Part
    full: int
    prices: NDArray[np.float64]

    @cached_property
    def begun(self) -> NDArray[np.float64]:
        """(n,): the least price + way from any root."""
        return distances(self.part.graph, self.prices)[0]

    @cached_property
    def passed(self) -> NDArray[np.float64]:
        """(M, n): the least price + way from any root by way of each mark."""
        part, sources = self.part, self.part.graph.sources
        by_edge = self.begun[sources] + part.graph.weights
        return np.array([distances(part.graph, self._least(part.graph.targets, by_edge, m))[0] for m in self._each])

    @cached_property
    def ahead(self) -> NDArray[np.float64]:
        """(M, n): the least way that ends with an edge with each mark."""
        return np.array([tree[0] for tree in self._trees])

    @cached_property
    def since(self) -> NDArray[np.float64]:
        """(M, n): the least way from the end of an edge with each mark."""
        part = self.part
        ends = (
            np.where(self._least(part.graph.targets, part.graph.weights, m) < np.inf, 0.0, np.inf) for m in self._each
        )
        return np.array([distances(part.graph, offsets)[0] for offsets in ends])

    @cached_property
    def home(self) -> NDArray[np.float64]:
        """(n,): the least way to any root."""
        if np.isfinite(self.prices).all():
            return np.zeros(self.part.n_nodes)
        return distances(self._back, np.where(np.isfinite(self.prices), 0.0, np.inf))[0]

    @cached_property
    def homeward(self) -> NDArray[np.float64]:
        """(M, n): the least way by way of each mark to any root."""
        if np.isfinite(self.prices).all():
            return self.ahead
        graph, sources = self.part.graph, self.part.graph.sources
        by_edge = graph.weights + self.home[graph.targets]
        return np.array([distances(self._back, self._least(sources, by_edge, m))[0] for m in self._each])

    @property
    def bound(self) -> float:
        """No loop costs less: it passes by every mark."""
        return float(self.passed.max(axis=0).min())

    def some_loop(self) -> tuple[list[int], float]:
        """A loop (its first node stands at its end too) and price + weight: the nearest mark first, all of them
        from the cheapest node to see where this leads, and again from there."""
        first = self._collect(int(np.argmin(self.prices)))
        return min((self._closed(self._collect(at)) for at in (first[0], first[-1])), key=lambda loop: loop[1])

    @property
    def _each(self) -> range:
        return range(self.full.bit_length())

    @cached_property
    def _trees(self) -> list[tuple[NDArray, NDArray]]:
        sources, weights = self.part.graph.sources, self.part.graph.weights
        return [distances(self._back, self._least(sources, weights, m)) for m in self._each]

    @cached_property
    def _back(self) -> Graph:
        return self.part.graph.reversed()

    def _least(self, nodes: NDArray, values: NDArray, mark: int) -> NDArray[np.float64]:
        edges = np.flatnonzero((self.part.marks & (1 << mark)) != 0)
        return least(self.part.n_nodes, nodes[edges], values[edges])

    def _collect(self, node: int) -> list[int]:
        """A walk from a node that meets all marks, always on to the nearest."""
        graph, walk, missing = self.part.graph, [node], self.full
        while missing:
            mark = min((m for m in self._each if missing >> m & 1), key=lambda m: self.ahead[m, walk[-1]])
            walk += way(self._trees[mark][1], walk[-1])[-2::-1]
            edges = np.arange(graph.starts[walk[-1]], graph.starts[walk[-1] + 1])
            edges = edges[self.part.marks[edges] >> mark & 1 > 0]
            edge = edges[np.argmin(graph.weights[edges])]
            walk.append(int(graph.targets[edge]))
            missing &= ~int(self.part.marks[edge])
        return walk

    def _closed(self, walk: list[int]) -> tuple[list[int], float]:
        """A walk that meets all marks, closed to a loop that begins where that is cheapest."""
        graph = self.part.graph
        loop = walk[:-1] + way(distances(graph, single(graph.n_nodes, walk[-1]))[1], walk[0])
        root = min(range(len(loop)), key=lambda i: self.prices[loop[i]])
        loop = loop[root:-1] + loop[: root + 1]
        return loop, float(self.prices[loop[0]] + sum(map(self._lightest, loop[:-1], loop[1:])))

    def _lightest(self, node: int, after: int) -> float:
        """The weight that may be added for a step: that of the heaviest of parallel edges, whose marks count."""
        graph = self.part.graph
        edges = slice(graph.starts[node], graph.starts[node + 1])
        return float(graph.weights[edges][graph.targets[edges] == after].max())

    def layers(self, limit: float, most_edges: int) -> Layers | None:
        """The layers without what only loops of price + weight `limit` or more can use.

        Returns:
            None if there are more than `most_edges` edges.
        """
        part, graph, n = self.part, self.part.graph, self.part.n_nodes
        so_far, to_come = _of_sets(self.passed, self.begun), _of_sets(self.homeward, self.home)
        alive = so_far + to_come[::-1] < limit
        somewhere, sources = alive.any(axis=0), graph.sources
        useful = somewhere[sources] & somewhere[graph.targets]
        useful = np.flatnonzero(useful & (self.begun[sources] + graph.weights < limit))
        sources, targets = sources[useful], graph.targets[useful]
        weights, marks = graph.weights[useful], part.marks[useful]
        number = np.full((self.full + 1, n), -1, dtype=np.int32)
        number[alive] = np.arange(np.count_nonzero(alive))
        pieces, n_edges = [], 0
        for collected in range(self.full + 1):
            row = np.flatnonzero(alive[collected][sources])
            after = collected | marks[row]
            left = so_far[collected][sources[row]] + weights[row] + to_come[self.full ^ after, targets[row]]
            kept = left < limit
            row, after = row[kept], after[kept]
            pieces.append((number[collected, sources[row]], number[after, targets[row]], weights[row]))
            n_edges += len(row)
            if n_edges > most_edges:
                return None
        starts, ends, lengths = (np.concatenate(column) for column in zip(*pieces, strict=True))
        sound = np.flatnonzero(ends >= 0)
        counts = np.bincount(starts[sound], minlength=np.count_nonzero(alive))
        layered = Graph(np.concatenate([[0], np.cumsum(counts)]).astype(np.int32), ends[sound], lengths[sound])
        roots = np.flatnonzero(alive[0] & alive[-1] & (self.prices < limit))
        return Layers(layered, np.nonzero(alive)[1], number[0, roots], number[-1, roots])


def _of_sets(single: NDArray, none: NDArray) -> NDArray[np.float64]:
    """(2^M, n): the greatest of the values (M, n) of a set's members; `none` for the empty set."""
    result = none[None]
    for values in single:
        result = np.concatenate([result, np.maximum(result, values)])
    return result
