"""The cheapest loop, the weights and the layers, each against something simpler."""

from __future__ import annotations

from unittest import mock

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_ltl.planning.layers import Priced
from drake_ltl.planning.loops import LoopProblem, cheapest_loop
from drake_ltl.planning.marks import Marks
from drake_ltl.planning.product import Graph, Product, accepting_part
from drake_ltl.planning.shares import layered_loop, least_loop
from drake_ltl.planning.weights import ACTION_LIMIT, COST_UNIT, lexicographic

N = 6
EDGES = st.lists(st.tuples(st.integers(0, N - 1), st.integers(0, N - 1), st.integers(1, 9)), max_size=25)


def graph_of(edges, n=N):
    edges = sorted(edges, key=lambda edge: edge[0])
    counts = np.bincount([edge[0] for edge in edges], minlength=n)
    return Graph(
        np.concatenate([[0], np.cumsum(counts)]).astype(np.int32),
        np.array([edge[1] for edge in edges], dtype=np.int32),
        np.array([edge[2] for edge in edges], dtype=float),
    )


@pytest.mark.parametrize("at_once", [True, False])
@given(edges=EDGES, prices=st.lists(st.integers(0, 9), min_size=3, max_size=3), limit=st.integers(1, 40))
def test_cheapest_loop_against_one_search_per_root(at_once, edges, prices, limit):
    """Roots 0 to 2, each with two of the nodes 3 to 5 as goals; parallel edges occur."""
    goals = np.array([[3, 4], [4, 5], [5, 3]])
    problem = LoopProblem(graph_of(edges), np.arange(3), goals, np.arange(3)[:, None])
    oracle = nx.DiGraph()
    oracle.add_nodes_from(range(N))
    for source, target, weight in sorted(edges, key=lambda edge: -edge[2]):
        oracle.add_edge(source, target, weight=weight)
    costs = [
        prices[root] + nx.shortest_path_length(oracle, root, goal, "weight")
        for root in range(3)
        for goal in goals[root].tolist()
        if nx.has_path(oracle, root, goal)
    ]
    expected = min((cost for cost in costs if cost < limit), default=None)
    with mock.patch("drake_ltl.planning.loops.MOST_AT_ONCE", 1000 if at_once else -1):
        loop = cheapest_loop(problem, np.array(prices, dtype=float), float(limit))
    if expected is None:
        assert loop is None
        return
    assert loop.weight == expected
    assert loop.nodes[0] == loop.root
    assert loop.nodes[-1] in goals[loop.root]
    assert prices[loop.root] + nx.path_weight(oracle, loop.nodes, "weight") == expected


def product_of(edges):
    """Edges (source, target, weight, marks)."""
    edges = sorted(edges, key=lambda edge: edge[0])
    return Product(graph_of(edges), np.array([edge[3] for edge in edges], dtype=np.int64), N)


def test_accepting_components_carry_all_marks_inside():
    product = product_of([(0, 1, 1, 0b11), (1, 2, 1, 0b01), (2, 1, 1, 0b10), (3, 3, 1, 0b01), (4, 4, 1, 0b11)])
    reachable = np.array([True, True, True, True, False, True])
    part = accepting_part(product, reachable, 0b11)
    assert part.nodes.tolist() == [1, 2]
    assert part.graph.targets.tolist() == [1, 0]
    assert part.marks.tolist() == [0b01, 0b10]


def part_of(edges):
    return accepting_part(product_of(edges), np.ones(N, bool), 0b11)


@given(
    edges=st.lists(
        st.tuples(st.integers(0, N - 1), st.integers(0, N - 1), st.integers(1, 9), st.integers(0, 3)),
        max_size=25,
        unique_by=lambda edge: edge[:2],
    ),
    prices=st.lists(st.sampled_from([*range(10), np.inf, np.inf]), min_size=N, max_size=N),
)
def test_layers_keep_the_cheapest_loop_with_all_marks(edges, prices):
    """Against one search per root in all layers; the greedy loop and the bound enclose it. Share by share it is the
    same, or not proven."""
    part = part_of(edges)
    prices = np.array(prices, dtype=float)[part.nodes]
    if not np.isfinite(prices).any():
        return
    oracle = nx.DiGraph()
    for source, target, weight, met in edges:
        for marks in range(4):
            oracle.add_edge((source, marks), (target, marks | met), weight=weight)
    best = min(
        price + nx.shortest_path_length(oracle, (root, 0), (root, 3), "weight")
        for root, price in zip(part.nodes.tolist(), prices, strict=True)
        if nx.has_path(oracle, (root, 0), (root, 3))
    )
    priced = Priced(Marks(part, 0b11), prices)
    nodes, weight = priced.some_loop()
    assert nodes[0] == nodes[-1]
    assert priced.bounds.min() <= best <= weight
    layers = priced.layers(weight + 1.0, 1000)
    roots = np.flatnonzero((layers.first >= 0) & (layers.last >= 0) & np.isfinite(prices))
    assert (layers.nodes[layers.first[roots]] == roots).all()
    problem = LoopProblem(layers.graph, layers.first[roots], layers.last[roots, None], roots[:, None])
    assert cheapest_loop(problem, prices[roots], weight + 1.0).weight == best
    assert priced.layers(weight + 1.0, 0) is None
    without_implied = Priced(Marks.of(part, 0b11), prices)
    assert least_loop(without_implied, lambda nodes: nodes[:, None], weight + 1.0, 1000).weight == best
    for limit in (best, weight + 1.0):
        for most_edges in (0, 12, 20, 1000):
            least = least_loop(priced, lambda nodes: nodes[:, None], limit, most_edges)
            assert least.bound <= min(best, limit) <= least.weight
            assert least.bound == min(best, limit) or most_edges < 1000
            assert bool(least.nodes) == (least.weight < limit)
            if least.nodes:
                assert least.nodes[0] == least.nodes[-1]
            assert layered_loop(priced, lambda nodes: nodes[:, None], limit, 0) is None


@given(
    paths=st.lists(
        st.lists(st.tuples(st.integers(0, 2_000_000), st.integers(0, 5)), min_size=1, max_size=20),
        min_size=2,
        max_size=2,
    )
)
def test_weights_order_as_cost_then_steps_then_actions(paths):
    """Costs of two decimals up to 20000."""
    edges = [edge for path in paths for edge in path]
    weights = lexicographic(np.array([c for c, _ in edges]) / 100.0, np.array([a for _, a in edges]))
    sums = weights[: len(paths[0])].sum(), weights[len(paths[0]) :].sum()
    values = [(sum(c for c, _ in path), len(path), sum(a for _, a in path)) for path in paths]
    assert (sums[0] < sums[1]) == (values[0] < values[1])
    assert (sums[0] == sums[1]) == (values[0] == values[1])


@pytest.mark.parametrize("scale", [0.0, 1e-12, 1.0, 1e12])
def test_weights_are_integers_at_any_scale(scale):
    costs = np.array([0.0, 0.5, 1.0]) * scale
    weights = lexicographic(costs, np.zeros(3, dtype=int))
    assert np.all(weights == np.rint(weights))
    assert weights[0] == ACTION_LIMIT
    assert weights.sum() < 2.0**53
    if scale:
        assert (weights[1] - ACTION_LIMIT) / (weights[2] - ACTION_LIMIT) == pytest.approx(0.5, rel=1e-8)
        assert weights[1] > 1e8 * COST_UNIT  # that resolution again: nine digits of the largest cost
