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
        offsets: (n,), integers; inf for nodes from which no way begins. Or (M, n): M searches.
        limit: ways of this length and more are not looked for.

    Returns:
        The least offset + length of a way to each node, as `offsets`, and the node before it on such a way; n or
        more if it begins there, negative if there is none.
    """
    n, rows = graph.n_nodes, np.atleast_2d(offsets)
    search, first = np.nonzero(rows < limit)
    extra = np.searchsorted(search, np.arange(1, len(rows) + 1))  # one more node for each search, where it begins
    matrix = csr_array(
        (
            np.concatenate([graph.weights, rows[search, first] + 1.0]),  # no edge of weight zero
            np.concatenate([graph.targets, first.astype(np.int32)]),
            np.concatenate([graph.starts, graph.starts[-1] + extra.astype(np.int32)]),
        ),
        shape=(n + len(rows), n + len(rows)),
    )
    sources = np.arange(n, n + len(rows))
    distance, before = dijkstra(matrix, indices=sources, return_predecessors=True, limit=limit + 1.0)
    shape = (*offsets.shape[:-1], n)
    return (distance[:, :n] - 1.0).reshape(shape), before[:, :n].reshape(shape)


def between(
    graph: Graph, back: Graph, begins: NDArray, ends: NDArray, limit: float
) -> tuple[Graph, NDArray[np.int64], NDArray[np.int64]]:
    """What ways from where they begin to where they end can use below a limit.

    Args:
        graph: n nodes.
        back: the same with all edges turned round.
        begins: (n,), offsets of nodes in which ways begin, inf for others.
        ends: (n,), the same for where they end.
        limit: of offset + length + offset.

    Returns:
        The smaller graph, and which nodes and edges of the graph its nodes and edges are, increasing.
    """
    begun, home = distances(graph, begins, limit)[0], distances(back, ends, limit)[0]
    nodes = np.flatnonzero(begun + home < limit)
    edges, lengths = graph.edges_of(nodes), graph.starts[nodes + 1] - graph.starts[nodes]
    through = np.repeat(begun[nodes], lengths) + graph.weights[edges] + home[graph.targets[edges]]
    edges = edges[through < limit]
    return graph.part(nodes, edges), nodes, edges


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
