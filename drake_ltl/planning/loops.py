"""The cheapest loop through any of many roots, each with a price of its own for getting there.

Few roots in a small graph are searched one by one. Otherwise it is branch and bound over sets of roots: one
shortest-path tree from a whole set, in which each root starts with its price, bounds from below what any member of
the set can cost. If the set's best path ends in the root it began in, the bound is met; else the set is split so that
the two ends of the path fall apart.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from functools import cached_property
from itertools import count

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from drake_ltl.planning.distances import distances, least, way
from drake_ltl.planning.product import Graph

MOST_AT_ONCE = 1 << 17
"""Roots x edges that are rather searched one root after the other."""
FIRST_PRUNING = 4
"""So many trees are grown before the graph is cut down for the first time."""


@dataclass(frozen=True, eq=False)
class LoopProblem:
    """R roots in a graph. All weights are integers, at least 1."""

    graph: Graph
    roots: NDArray[np.int64]
    """(R,): nodes in which a loop begins; no goal is a root."""
    goals: NDArray[np.int64]
    """(R, T): nodes of which any closes the loop of the root."""
    features: NDArray[np.int64]
    """(R, F): rows that differ from root to root; they say how sets are split."""

    @cached_property
    def trees(self) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        """From each root the least way to all n nodes, (R, n), and the node before it on that way, (R, n)."""
        return dijkstra(self.graph.matrix(), indices=self.roots, return_predecessors=True)


@dataclass(frozen=True)
class Loop:
    """A root, the cheapest path from it to one of its goals, and what both cost together."""

    root: int
    """Index into the problem's roots."""
    nodes: tuple[int, ...]
    weight: float


def cheapest_loop(problem: LoopProblem, prices: NDArray, limit: float) -> Loop | None:
    """The loop of least price + weight below `limit`; None if there is none.

    Args:
        problem: with R roots.
        prices: (R,), integers: what a root costs besides its loop.
        limit: may be inf.
    """
    if not len(prices) or not prices.min() < limit:
        return None
    at_once = len(problem.roots) * len(problem.graph.targets) <= MOST_AT_ONCE
    return _by_each(problem, prices, limit) if at_once else _by_sets(problem, prices, limit)


def _by_each(problem: LoopProblem, prices: NDArray, limit: float) -> Loop | None:
    """A search from each root."""
    distance, before = problem.trees
    weights = prices[:, None] + np.take_along_axis(distance, problem.goals, axis=1)
    root, goal = np.unravel_index(np.argmin(weights), weights.shape)
    if not weights[root, goal] < limit:
        return None
    return Loop(int(root), tuple(way(before[root], problem.goals[root, goal])), float(weights[root, goal]))


def _by_sets(problem: LoopProblem, prices: NDArray, limit: float) -> Loop | None:
    """Branch and bound."""
    tree = _Tree(problem, prices)
    bounds, best, ticket = prices.copy(), None, count()
    queue = [(0.0, next(ticket), np.arange(len(bounds)))]
    while queue and queue[0][0] < limit:
        members = heapq.heappop(queue)[2]
        members = members[bounds[members] < limit]
        if not len(members):
            continue
        found, loop = tree.grow(members, limit)
        bounds[members] = np.maximum(bounds[members], found)
        if loop is None:
            continue
        end = int(members[np.argmin(found)])
        if loop.root == end:
            best, limit = loop, loop.weight
            continue
        if tree.is_worn:  # a loop that closes bounds all further work
            _, closed = tree.grow(np.array([end]), limit)
            best, limit = (best, limit) if closed is None else (closed, closed.weight)
            bounds[tree.prune(np.flatnonzero(bounds < limit), limit)] = np.inf
        for part in split(problem.features, members[bounds[members] < limit], loop.root, end):
            heapq.heappush(queue, (bounds[part].min(), next(ticket), part))
    return best


def split(features: NDArray, members: NDArray, first: int, second: int) -> list[NDArray]:
    """Parts of a set by the value of the first feature in which two of its members differ."""
    feature = np.flatnonzero(features[first] != features[second])[0]
    values = features[members, feature]
    return [members[values == value] for value in np.unique(values)]


class _Tree:
    """Shortest-path trees of one problem: its graph with one more node, from which all paths begin.

    Now and then the graph is cut down to what is still of use.
    """

    def __init__(self, problem: LoopProblem, prices: NDArray):
        self._prices = prices
        self._nodes, self._age, self._prune_at = np.arange(problem.graph.n_nodes), 0, FIRST_PRUNING
        self._set(problem.graph, problem.roots, problem.goals)

    @property
    def is_worn(self) -> bool:
        """Whether enough trees have been grown for another pruning to pay."""
        return self._age >= self._prune_at

    def prune(self, members: NDArray, limit: float) -> NDArray[np.bool_]:
        """Leave out what only loops of roots other than `members`, or of weight `limit` or more, use.

        Returns:
            (R,): the roots that are left out.
        """
        self._prune_at *= 8
        graph, n = self._graph, self._graph.n_nodes
        goals = np.full(n, np.inf)
        goals[self._goals[members]] = 0.0
        begun = distances(graph, least(n, self._roots[members], self._prices[members]), limit)[0]
        left = distances(graph.reversed(), goals, limit)[0]
        kept = np.flatnonzero(begun + left < limit)
        number = np.full(n, len(kept), dtype=np.int32)  # all others become one node that nothing leads to
        number[kept] = np.arange(len(kept))
        edges = np.flatnonzero(graph.at_sources(begun) + graph.weights + graph.at_targets(left) < limit)
        self._nodes = np.append(self._nodes[kept], -1)
        ends = number[graph.sources[edges]], number[graph.targets[edges]]
        smaller = Graph.of(len(kept) + 1, *ends, graph.weights[edges])
        self._set(smaller, number[self._roots], number[self._goals])
        return self._roots == len(kept)

    def _set(self, graph: Graph, roots: NDArray, goals: NDArray) -> None:
        self._graph, self._roots, self._goals = graph, roots, goals
        self._targets = np.concatenate([graph.targets, np.zeros(len(roots), np.int32)])
        self._weights = np.concatenate([graph.weights, np.zeros(len(roots))])
        self._starts = np.append(graph.starts, graph.starts[-1]).astype(np.int32)

    def grow(self, members: NDArray, limit: float) -> tuple[NDArray, Loop | None]:
        """Paths from the roots `members`.

        Returns:
            For each member a lower bound of what its loop costs (inf at or above `limit`), and the best path:
            from some member's root to some member's goal.
        """
        self._age += 1
        edges, n = len(self._graph.targets), self._graph.n_nodes
        self._targets[edges : edges + len(members)] = self._roots[members]
        self._weights[edges : edges + len(members)] = self._prices[members] + 1.0  # no edge of weight zero
        self._starts[-1] = edges + len(members)
        matrix = csr_array(
            (self._weights[: self._starts[-1]], self._targets[: self._starts[-1]], self._starts),
            shape=(n + 1, n + 1),
        )
        distance, parent = dijkstra(matrix, indices=n, return_predecessors=True, limit=limit)
        at_goals = distance[self._goals[members]] - 1.0
        bounds = at_goals.min(axis=1)
        end = int(np.argmin(bounds))
        if not bounds[end] < limit:
            return np.full(len(members), np.inf), None
        nodes = [int(self._goals[members[end], np.argmin(at_goals[end])])]
        while parent[nodes[-1]] != n:
            nodes.append(int(parent[nodes[-1]]))
        root = int(members[np.flatnonzero(self._roots[members] == nodes[-1])[0]])
        return bounds, Loop(root, tuple(self._nodes[nodes[::-1]].tolist()), float(bounds[end]))
