"""Loops whose words an automaton reads more than once before it comes back to where it was.

Let v be the word of a loop that begins in state s of TS. An automaton that never counts is led by v v .. from q_0 to
q_1, q_2 .. and at last from some q_k to q_k, which is a loop of the product. So the run of the automaton is k + 1 runs
over the same loop, side by side: from (q_0, .. q_k) to (q_1, .. q_k, q_k). Level k follows the last k + 1 of them. Each
level bounds all that come after it from below, if a loop is priced by the way to s, whatever q_0; and it has the
cheapest loop of its own, priced by the way to (q_0, s).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.automaton import Automaton
from drake_ltl.planning.distances import distances, least
from drake_ltl.planning.layers import Layers, Priced
from drake_ltl.planning.loops import Loop, LoopProblem, cheapest_loop
from drake_ltl.planning.marks import Features
from drake_ltl.planning.product import Graph, multiply

MOST_EDGES = 20_000_000
"""Of a level, before it is cut down to what is of use."""


@dataclass(frozen=True, eq=False)
class ReadLoop:
    """A loop of TS, and the state of the automaton in which its word is first read."""

    first: int
    states: list[int]
    """The first one stands at the end again."""
    weight: float
    """Price + weight."""


@dataclass(frozen=True, eq=False)
class Level:
    """Runs side by side; R loops may be looked for.

    A level's nodes each show a state of TS and hold a state of the automaton for each of the runs.
    """

    graph: Graph
    """n nodes."""
    shown: NDArray[np.int64]
    """(n,): state of TS."""
    roots: NDArray[np.int64]
    """(R,): nodes in which loops begin ..."""
    goals: NDArray[np.int64]
    """(R,): .. and end."""
    first: NDArray[np.int64]
    """(R,): where the automaton is when the first of the runs begins."""
    labels: NDArray[np.int64]
    """(R, F): rows that differ from root to root, for `LoopProblem`."""

    @classmethod
    def of(cls, priced: Priced, layers: Layers, n_system: int, features: Features) -> Level:
        """Level 0: loops of the product, with all marks."""
        nodes = priced.marks.part.nodes[layers.nodes]
        begins = nodes[layers.roots]
        return cls(layers.graph, nodes % n_system, layers.roots, layers.goals, begins // n_system, features(begins))

    @classmethod
    def unmarked(cls, priced: Priced, n_system: int, features: Features) -> Level:
        """Level 0 without regard to marks: smaller, and its further levels are still bounds."""
        part = priced.marks.part
        roots = np.flatnonzero(np.isfinite(priced.prices))
        begins = part.nodes[roots]
        return cls(part.graph, part.nodes % n_system, roots, roots, begins // n_system, features(begins))

    @property
    def states(self) -> NDArray[np.int64]:
        """(R,): state of TS in which each loop begins."""
        return self.shown[self.roots]

    def next(self, letter: NDArray, automaton: Automaton, by_state: NDArray, limit: float) -> Level:
        """One more run, before the others, from any other state that is reached in time.

        Args:
            letter: (S,)
            automaton: Q states.
            by_state: (Q, S), the least price to begin in each state.
            limit: loops of this price + weight or more need not be kept, however they begin.

        Raises:
            SearchLimitError: the level is too large.
        """
        n, reached = len(self.shown), np.isfinite(by_state)[:, self.shown]
        graph = multiply(self.graph, letter[self.shown], automaton, reached, MOST_EDGES).graph
        shown = np.tile(self.shown, automaton.n_states)
        q, root = np.nonzero(by_state[:, self.states] < limit)
        other = q != self.first[root]
        q, root = q[other], root[other]
        roots, goals = q * n + self.roots[root], self.first[root] * n + self.goals[root]
        level = Level(graph, shown, roots, goals, q, np.column_stack([self.labels[root], q]))
        return level.within(by_state.min(axis=0)[level.states], limit)

    def within(self, prices: NDArray, limit: float) -> Level:
        """Only what loops of less price (R,) + weight than a limit can use."""
        graph, n = self.graph, self.graph.n_nodes
        begun = distances(graph, least(n, self.roots, prices), limit)[0]
        home = distances(graph.reversed(), least(n, self.goals, np.zeros(len(self.goals))), limit)[0]
        nodes = np.flatnonzero(begun + home < limit)
        edges = np.flatnonzero(begun[graph.sources] + graph.weights + home[graph.targets] < limit)
        number = np.full(n, -1)
        number[nodes] = np.arange(len(nodes))
        ends = number[graph.sources[edges]], number[graph.targets[edges]].astype(np.int32)
        roots, goals = number[self.roots], number[self.goals]
        kept = np.flatnonzero((roots >= 0) & (goals >= 0))
        return Level(
            Graph.of(len(nodes), *ends, graph.weights[edges]),
            self.shown[nodes],
            roots[kept],
            goals[kept],
            self.first[kept],
            self.labels[kept],
        )

    def cheapest(self, prices: NDArray, limit: float) -> ReadLoop | None:
        """The loop of least price (R,) + weight below a limit."""
        problem = LoopProblem(self.graph, self.roots, self.goals[:, None], prices, self.labels)
        loop: Loop | None = cheapest_loop(problem, limit)
        if loop is None:
            return None
        return ReadLoop(int(self.first[loop.root]), self.shown[list(loop.nodes)].tolist(), loop.weight)
