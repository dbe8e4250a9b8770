"""One member's own walk: the cheapest lasso through its regions and automaton, and whether a given one is accepted."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from itertools import pairwise

import networkx as nx

from drake_ltl.planning.bounded.alone import Alone, Node, Step
from drake_ltl.planning.bounded.conjuncts import Clause

Walk = tuple[tuple[int, ...], tuple[int, ...]]
"""Regions that are entered one after the other, in the prefix and in the suffix; the start is left out."""


class Walker:
    """The walks of one member, when all others are left out."""

    def __init__(self, lone: Alone):
        self._lone = lone
        self._leaving: dict[Node, list[Step]] = {node: [] for node in lone.nodes}
        for step in lone.steps:
            self._leaving[step.source].append(step)

    @cached_property
    def _reads(self) -> Mapping[tuple[Node, int], Step]:
        return {(step.source, step.target[0]): step for step in self._lone.steps}

    @property
    def is_free(self) -> bool:
        """Whether any walk along its ways is accepted."""
        return len({state for _, state in self._lone.nodes}) == 1 and any(
            not clause.often and not clause.never for clause in self._lone.clauses
        )

    def accepts(self, walk: Walk) -> bool:
        """Whether the formula holds on a walk, for formulas that do not count steps."""
        prefix, suffix = walk
        node, _ = self._read(self._lone.start, prefix)
        begins: list[Node] = []
        marks: list[frozenset[int]] = []
        suffix = suffix or (prefix[-1] if prefix else self._lone.start[0],)
        while node is not None and node not in begins:
            begins.append(node)
            node, met = self._read(node, suffix)
            marks.append(met)
        if node is None:
            return False
        recurring = frozenset().union(*marks[begins.index(node) :])
        return any(clause.often <= recurring and not clause.never & recurring for clause in self._lone.clauses)

    def _read(self, node: Node, regions: Sequence[int]) -> tuple[Node | None, frozenset[int]]:
        met: set[int] = set()
        for region in regions:
            step = self._reads.get((node, region))
            if step is None:
                return None, frozenset()
            node = step.target
            met |= step.marks
        return node, frozenset(met)

    def cheapest(self, cost: Callable[[int, int], float]) -> Walk:
        """A lasso of least cost of those that close in regions and automaton alike.

        Args:
            cost: of a way between two different regions, at least 0; staying costs nothing.
        """
        weight = {s: cost(s.source[0], s.target[0]) if s.source[0] != s.target[0] else 0.0 for s in self._lone.steps}
        graph = nx.DiGraph()
        graph.add_node(self._lone.start)
        graph.add_weighted_edges_from((s.source, s.target, w) for s, w in weight.items())
        distance, paths = nx.single_source_dijkstra(graph, self._lone.start)
        best: tuple[float, Walk] | None = None
        for clause in self._lone.clauses:
            rounds = self._rounds(clause, weight)
            for node in sorted(distance, key=distance.__getitem__):
                left = float("inf") if best is None else best[0] - distance[node]
                found = self._round(rounds, clause, node, weight, left)
                if found is not None and found[0] < left:
                    best = distance[node] + found[0], (_moves(paths[node]), _moves([node, *found[1]]))
        assert best is not None, "a member without an accepted lasso"
        return best[1]

    def _rounds(self, clause: Clause, weight: Mapping[Step, float]) -> nx.DiGraph:
        """Nodes with the marks of `often` met so far, without steps that meet one of `never`."""
        graph = nx.DiGraph()
        fresh = [(node, frozenset[int]()) for node in self._lone.nodes]
        graph.add_nodes_from(fresh)
        while fresh:
            node, met = fresh.pop()
            for step in self._leaving[node]:
                if step.marks & clause.never:
                    continue
                target = step.target, met | (step.marks & clause.often)
                if target not in graph:
                    fresh.append(target)
                graph.add_edge((node, met), target, weight=weight[step])
        return graph

    def _round(
        self, rounds: nx.DiGraph, clause: Clause, root: Node, weight: Mapping[Step, float], limit: float
    ) -> tuple[float, list[Node]] | None:
        """The cheapest round from a node back to it that meets all marks, of at least one step."""
        best = None
        if (root, clause.often) not in rounds:
            return None
        back = nx.single_source_dijkstra(rounds.reverse(copy=False), (root, clause.often), cutoff=limit)
        for step in self._leaving[root]:
            first = step.target, step.marks & clause.often
            if step.marks & clause.never or first not in back[0]:
                continue
            length = weight[step] + back[0][first]
            if best is None or length < best[0]:
                best = length, [node for node, _ in reversed(back[1][first])]
        return best


def _moves(nodes: Sequence[Node]) -> tuple[int, ...]:
    """The regions after the first, without staying."""
    regions = [region for region, _ in nodes]
    return tuple(b for a, b in pairwise(regions) if a != b)
