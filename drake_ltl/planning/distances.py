"""Shortest ways in a graph from many nodes at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from drake_ltl.planning.product import Graph


def distances(graph: Graph, offsets: NDArray, limit: float = np.inf) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Dijkstra from all nodes with a finite offset, each at the distance of its offset.

    Args:
        graph: n nodes; all weights at least 1.
        offsets: (n,), integers; inf for nodes from which no way begins.
        limit: ways of this length and more are not looked for.

    Returns:
        The least offset + length of a way to each node, (n,), and the node before it on such a way; n if it
        begins there, negative if there is none.
    """
    n = graph.n_nodes
    first = np.flatnonzero(offsets < limit)
    matrix = csr_array(
        (
            np.append(graph.weights, offsets[first] + 1.0),  # no edge of weight zero
            np.append(graph.targets, first.astype(np.int32)),
            np.append(graph.starts, graph.starts[-1] + len(first)).astype(np.int32),
        ),
        shape=(n + 1, n + 1),
    )
    distance, before = dijkstra(matrix, indices=n, return_predecessors=True, limit=limit + 1.0)
    return distance[:n] - 1.0, before[:n]


def single(n: int, node: int) -> NDArray[np.float64]:
    """Offsets (n,) for ways that begin in one node."""
    offsets = np.full(n, np.inf)
    offsets[node] = 0.0
    return offsets


def least(n: int, nodes: NDArray, values: NDArray) -> NDArray[np.float64]:
    """(n,): the least of the values given for each node, inf if there is none."""
    result = np.full(n, np.inf)
    np.minimum.at(result, nodes, values)
    return result


def way(before: NDArray, node: int) -> list[int]:
    """The nodes of the way to a node, from where it begins."""
    nodes = [int(node)]
    while 0 <= before[nodes[-1]] < len(before):
        nodes.append(int(before[nodes[-1]]))
    return nodes[::-1]
