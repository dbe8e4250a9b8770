"""The accepting part of a product, once for each stage of collecting the marks of a loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.product import Graph, Product


@dataclass(frozen=True, eq=False)
class Layers:
    """Node c * n + i of the graph stands for product node nodes[i] in layer c.

    A loop begins in layer 0 and has collected all marks when it is in the last layer.
    """

    graph: Graph
    nodes: NDArray[np.int64]
    """(n,)"""
    exact: bool
    """Whether marks may be met in any order: layer c stands for the set of marks c. Otherwise they are collected
    one after the other, a loop through them in another order takes more rounds, and the cheapest may be missed."""


def layered(product: Product, component: NDArray, full: int, exact: bool, most_edges: int) -> Layers | None:
    """Form the layers.

    Args:
        product: n nodes.
        component: (n,), accepting component of each product node, or -1.
        full: all marks.
        exact: as in `Layers`; takes 2^marks layers instead of marks + 1.
        most_edges: give up and return None rather than form more edges.
    """
    graph, sources = product.graph, product.graph.sources
    inside = (component[sources] >= 0) & (component[sources] == component[graph.targets])
    n_layers = full + 1 if exact else full.bit_length() + 1
    if n_layers * int(inside.sum()) > most_edges:
        return None
    nodes = np.flatnonzero(component >= 0)
    local = np.full(graph.n_nodes, -1)
    local[nodes] = np.arange(len(nodes))
    counts = np.bincount(local[sources[inside]], minlength=len(nodes))
    targets, marks = local[graph.targets[inside]], product.marks[inside]
    following = [c | marks if exact else _in_order(c, marks, full) for c in range(n_layers)]
    return Layers(
        Graph(
            np.concatenate([[0], np.cumsum(np.tile(counts, n_layers))]).astype(np.int32),
            np.concatenate([(targets + layer * len(nodes)).astype(np.int32) for layer in following]),
            np.tile(graph.weights[inside], n_layers),
        ),
        nodes,
        exact,
    )


def _in_order(layer: int, marks: NDArray, full: int) -> NDArray:
    """The number of marks collected after `layer` of them, if only the next one in order ever counts."""
    collected = np.full(marks.shape, layer)
    for mark in range(layer, full.bit_length()):
        collected += (collected == mark) & (marks >> mark & 1)
    return collected
