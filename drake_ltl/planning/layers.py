"""The accepting part of a product, once for each set of marks that a loop has collected so far.

Of these layers only what a loop cheaper than a known one can use is formed. What is known of single marks decides:
a loop that is at node v with the marks c has passed by each mark of c, and has the others before it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.distances import between, distances, least
from drake_ltl.planning.marks import Marks
from drake_ltl.planning.product import Graph, Part

MOST_LAYERED_EDGES = 10_000_000
"""Of the layers that are looked at together."""


@dataclass(frozen=True, eq=False)
class Layers:
    """Nodes of the graph stand for a product node together with a set of marks.

    A loop begins with no marks and has collected all of them when it is closed.
    """

    graph: Graph
    """n nodes."""
    nodes: NDArray[np.int64]
    """(n,): node of the part, P nodes."""
    first: NDArray[np.int32]
    """(P,): node of the graph that stands for a node of the part without marks, -1 if there is none ..."""
    last: NDArray[np.int32]
    """(P,): .. and for it with all marks."""


@dataclass(frozen=True, eq=False)
class Priced:
    """Marks, and where loops may begin.

    Attributes:
        marks: M of them, in a part with n nodes and e edges.
        prices: (n,), what it costs to begin a loop at each node; inf if none may begin there.
        ends: (n,), 0 for nodes where a loop may end and inf for others; None takes those where it may begin.
    """

    marks: Marks
    prices: NDArray[np.float64]
    ends: NDArray[np.float64] | None = None

    @cached_property
    def bounds(self) -> NDArray[np.float64]:
        """(n,): no loop that begins in a node has less price + weight."""
        return self.prices + self.marks.round_about

    @cached_property
    def begun(self) -> NDArray[np.float64]:
        """(n,): the least price + way from any root."""
        return distances(self.marks.part.graph, self.prices)[0]

    @cached_property
    def passed(self) -> NDArray[np.float64]:
        """(M, n): the least price + way from any root by way of each mark."""
        graph = self.marks.part.graph
        return distances(graph, self.marks.least_entering(graph.at_sources(self.begun) + graph.weights))[0]

    @cached_property
    def home(self) -> NDArray[np.float64]:
        """(n,): the least way to any node where a loop ends."""
        ends = np.where(np.isfinite(self.prices), 0.0, np.inf) if self.ends is None else self.ends
        return distances(self.marks.back, ends)[0] if ends.any() else ends

    @cached_property
    def homeward(self) -> NDArray[np.float64]:
        """(M, n): the least way by way of each mark to any node where a loop ends."""
        if not self.home.any():
            return self.marks.ahead
        graph = self.marks.part.graph
        return distances(self.marks.back, self.marks.least_leaving(graph.weights + graph.at_targets(self.home)))[0]

    def some_loop(self) -> tuple[list[int], float]:
        """A loop (its first node stands at its end too) and price + weight: from the cheapest node always on to the
        nearest mark until all are collected, and from where that ends again, for there the loop begins well."""
        marks = self.marks
        last = marks.collect(int(np.argmin(self.prices)))[-1]
        return self.begun_best(marks.closed(marks.collect(last)))

    def begun_best(self, loop: list[int]) -> tuple[list[int], float]:
        """A loop, begun in the one of its nodes where that is cheapest, and its price + weight."""
        root = min(range(len(loop)), key=lambda i: self.prices[loop[i]])
        loop = loop[root:-1] + loop[: root + 1]
        return loop, float(self.prices[loop[0]] + sum(map(self._weight, loop[:-1], loop[1:])))

    def _weight(self, node: int, after: int) -> float:
        graph = self.marks.part.graph
        edges = slice(graph.starts[node], graph.starts[node + 1])
        return float(graph.weights[edges][graph.targets[edges] == after].min())

    def within(self, roots: NDArray, limit: float) -> tuple[Priced, NDArray[np.int64]]:
        """What loops of less price + weight than a limit can use that begin in some nodes, (R,); and the nodes of
        this part that its nodes are."""
        part, n = self.marks.part, len(self.prices)
        roots = roots[self.bounds[roots] < limit]
        prices, ends = least(n, roots, self.prices[roots]), least(n, roots, np.zeros(len(roots)))
        graph, nodes, edges = between(part.graph, self.marks.back, prices, ends, limit)
        smaller = Part(graph, part.marks[edges], part.nodes[nodes])
        return Priced(Marks(smaller, self.marks.full), prices[nodes]), nodes

    def layers(self, limit: float, most_edges: int) -> Layers | None:
        """The layers without what only loops of price + weight `limit` or more can use.

        Returns:
            None if there are more than `most_edges` edges.
        """
        part, graph, full = self.marks.part, self.marks.part.graph, self.marks.full
        so_far, to_come = _of_sets(self.passed, self.begun), _of_sets(self.homeward, self.home)
        alive = so_far + to_come[::-1] < limit
        somewhere = alive.any(axis=0)
        useful = graph.at_sources(somewhere) & graph.at_targets(somewhere)
        useful = np.flatnonzero(useful & (graph.at_sources(self.begun) + graph.weights < limit))
        sources, targets = graph.sources[useful], graph.targets[useful]
        weights, marks = graph.weights[useful], part.marks[useful]
        number = np.full((full + 1, part.n_nodes), -1, dtype=np.int32)
        number[alive] = np.arange(np.count_nonzero(alive))
        pieces, n_edges = [], 0
        for collected in range(full + 1):
            row = np.flatnonzero(alive[collected][sources])
            after = collected | marks[row]
            left = so_far[collected][sources[row]] + weights[row] + to_come[full ^ after, targets[row]]
            kept = left < limit
            row, after = row[kept], after[kept]
            pieces.append((number[collected, sources[row]], number[after, targets[row]], weights[row]))
            n_edges += len(row)
            if n_edges > most_edges:
                return None
        starts, ends, lengths = (np.concatenate(column) for column in zip(*pieces, strict=True))
        sound = np.flatnonzero(ends >= 0)
        layered = Graph.of(np.count_nonzero(alive), starts[sound], ends[sound], lengths[sound])
        return Layers(layered, np.nonzero(alive)[1], number[0], number[-1])


def _of_sets(single: NDArray, none: NDArray) -> NDArray[np.float64]:
    """(2^M, n): the greatest of the values (M, n) of a set's members; `none` for the empty set."""
    result = none[None]
    for values in single:
        result = np.concatenate([result, np.maximum(result, values)])
    return result
