"""The cheapest loop with all marks where the layers (`layers`) of all loops together are too many.

Loops are shared out by where they begin. Of each share it is known that no loop lies below some bound. The share
with the least bound is looked at next, up to a limit a little above it, in the few nodes that loops below the limit
can use. If these are still too many, the step to the limit is made smaller, and at last the share divided.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import count

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.distances import distances, least
from drake_ltl.planning.layers import Marks
from drake_ltl.planning.loops import LoopProblem, cheapest_loop, split
from drake_ltl.planning.product import Graph, Part

FIRST_STEP, LEAST_STEP = 1 / 16, 1 / 64
"""Parts of the limit by which a share is searched beyond its bound, at first and before it is divided."""
MOST_LOOKS = 600
"""The search is given up after so many looks at shares."""

Features = Callable[[NDArray], NDArray]


@dataclass(frozen=True)
class LeastLoop:
    """What is known of the cheapest loop below a limit."""

    nodes: list[int]
    """Of the part, the first one at the end too; empty if no loop is known."""
    weight: float
    """Price + weight; the limit if no loop is known."""
    bound: float
    """No loop has less; equal to `weight` if the search came to its end."""


def layered_loop(marks: Marks, features: Features, limit: float, most_edges: int) -> tuple[list[int], float] | None:
    """The cheapest loop below a limit and its price + weight, ([], limit) if there is none.

    Args:
        marks: of a part, with prices.
        features: of nodes of the product, for `LoopProblem`.
        limit: loops of this price + weight or more are not looked for.
        most_edges: of the layers.

    Returns:
        None if the layers have more edges.
    """
    many = marks.part.n_nodes * (marks.full + 1) > most_edges
    layers = None if many else marks.layers(limit, most_edges)
    if layers is None:
        return None
    roots = layers.nodes[layers.roots]
    if not len(roots):
        return [], limit
    prices, rows = marks.prices[roots], features(marks.part.nodes[roots])
    loop = cheapest_loop(LoopProblem(layers.graph, layers.roots, layers.goals[:, None], prices, rows), limit)
    return ([], limit) if loop is None else (layers.nodes[list(loop.nodes)].tolist(), loop.weight)


def shared_out(marks: Marks, features: Features, limit: float, most_edges: int) -> LeastLoop:
    """The cheapest loop below a limit, share by share; arguments as for `layered_loop`."""
    shares = _Shares(marks, features, most_edges)
    best, ticket = LeastLoop([], limit, limit), count()
    low = float(shares.bounds.min())
    queue = [(low, next(ticket), np.flatnonzero(np.isfinite(marks.prices)), limit * FIRST_STEP)]
    for _ in range(MOST_LOOKS):
        if not queue or queue[0][0] >= best.weight:
            return LeastLoop(best.nodes, best.weight, best.weight)
        low, _, roots, step = heapq.heappop(queue)
        roots = roots[shares.bounds[roots] < best.weight]
        if not len(roots):
            continue
        goal = min(low + np.ceil(step), best.weight)
        found = shares.look(roots, goal)
        if found is not None and found[0]:
            best = LeastLoop(*found, found[1])
        elif found is not None:
            heapq.heappush(queue, (goal, next(ticket), roots, 1.5 * step))
        elif step > limit * LEAST_STEP or len(roots) == 1:
            heapq.heappush(queue, (low, next(ticket), roots, step / 4.0))
        else:
            for part in shares.split(roots):
                bound = max(low, float(shares.bounds[part].min()))
                heapq.heappush(queue, (bound, next(ticket), part, limit * FIRST_STEP))
    return LeastLoop(best.nodes, best.weight, min([best.weight, *(share[0] for share in queue)]))


class _Shares:
    def __init__(self, marks: Marks, features: Features, most_edges: int):
        self._marks, self._features, self._most_edges = marks, features, most_edges

    @cached_property
    def bounds(self) -> NDArray[np.float64]:
        """(n,): no loop that begins in a node has less price + weight: it leads to each mark, and from there back."""
        return self._marks.prices + (self._marks.ahead + self._marks.since).max(axis=0)

    def split(self, roots: NDArray) -> list[NDArray]:
        """Smaller shares."""
        rows = self._features(self._marks.part.nodes[roots])
        other = int(np.flatnonzero((rows != rows[0]).any(axis=1))[0])
        return [roots[part] for part in split(rows, np.arange(len(roots)), 0, other)]

    def look(self, roots: NDArray, limit: float) -> tuple[list[int], float] | None:
        """The cheapest loop that begins in one of some nodes; as `layered_loop`."""
        graph, n = self._marks.part.graph, self._marks.part.n_nodes
        prices = least(n, roots, self._marks.prices[roots])
        begun = distances(graph, prices, limit)[0]
        home = distances(self._back, least(n, roots, np.zeros(len(roots))), limit)[0]
        nodes = np.flatnonzero(begun + home < limit)
        edges = np.flatnonzero(begun[graph.sources] + graph.weights + home[graph.targets] < limit)
        number = np.full(n, -1, dtype=np.int32)
        number[nodes] = np.arange(len(nodes))
        counts = np.bincount(number[graph.sources[edges]], minlength=len(nodes))
        starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
        smaller = Graph(starts, number[graph.targets[edges]], graph.weights[edges])
        part = Part(smaller, self._marks.part.marks[edges], self._marks.part.nodes[nodes])
        if not len(nodes):
            return [], limit
        found = layered_loop(Marks(part, self._marks.full, prices[nodes]), self._features, limit, self._most_edges)
        return None if found is None else (nodes[found[0]].tolist() if found[0] else [], found[1])

    @cached_property
    def _back(self) -> Graph:
        return self._marks.part.graph.reversed()
