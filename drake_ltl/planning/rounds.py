"""Loops whose words an automaton reads more than once before it comes back to where it was.

Let v be the word of a loop that begins in state s of TS. An automaton that never counts is led by v v .. from q_0 to
q_1, q_2 .. and at last from some q_k to q_k, which is a loop of the product. So the run of the automaton is k + 1 runs
over the same loop, side by side: from (q_0, .. q_k) to (q_1, .. q_k, q_k). Level k follows the last k + 1 of them. Each
level bounds all that come after it from below, if a loop is priced by the way to s, whatever q_0; and it has the
cheapest loop of its own, priced by the way to (q_0, s).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.automaton import Automaton
from drake_ltl.planning.distances import between, least
from drake_ltl.planning.layers import MOST_LAYERED_EDGES, Layers, Priced
from drake_ltl.planning.loops import LoopProblem, cheapest_loop
from drake_ltl.planning.marks import Features, Marks
from drake_ltl.planning.orbits import nearest_accepted
from drake_ltl.planning.product import Graph, multiply

MOST_EDGES = 20_000_000
"""Of a level, before it is cut down to what is of use."""
FEW_LAYERED_EDGES = 50_000
"""Not worth a look without marks first."""


def are_few(marks: Marks) -> bool:
    """Whether the marks' layers are so small that less would not be searched faster."""
    return len(marks.part.marks) * marks.full <= FEW_LAYERED_EDGES


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
        n, ends = self.graph.n_nodes, np.zeros(len(self.goals))
        begins, ends = least(n, self.roots, prices), least(n, self.goals, ends)
        graph, nodes, _ = between(self.graph, self.graph.reversed(), begins, ends, limit)
        number = np.full(n, -1)
        number[nodes] = np.arange(len(nodes))
        roots, goals = number[self.roots], number[self.goals]
        kept = np.flatnonzero((roots >= 0) & (goals >= 0))
        return Level(graph, self.shown[nodes], roots[kept], goals[kept], self.first[kept], self.labels[kept])

    @cached_property
    def _problem(self) -> LoopProblem:
        return LoopProblem(self.graph, self.roots, self.goals[:, None], self.labels)

    def cheapest(self, prices: NDArray, limit: float) -> ReadLoop | None:
        """The loop of least price (R,) + weight below a limit."""
        loop = cheapest_loop(self._problem, prices, limit)
        if loop is None:
            return None
        return ReadLoop(int(self.first[loop.root]), self.shown[list(loop.nodes)].tolist(), loop.weight)


@dataclass(frozen=True, eq=False)
class Rounds:
    """Where loops of TS may begin, and how far the automaton can then be.

    Attributes:
        automaton: never counts; Q states.
        letter: (S,)
        by_state: (Q, S), the least way to each node of the product.
        prices: (S,), the least of them; inf where no loop may begin.
        features: of nodes of the product, for `LoopProblem`.
    """

    automaton: Automaton
    letter: NDArray[np.int64]
    by_state: NDArray[np.float64]
    prices: NDArray[np.float64]
    features: Features

    def cheapest(self, marks: Marks, limit: float, first: int = 1) -> tuple[ReadLoop | None, float]:
        """The least loop below a limit that stays in a part of the product.

        Args:
            marks: of the part.
            limit: loops of this price + weight or more are not looked for.
            first: level to begin with; 1 leaves out loops that are closed after one round.

        Returns:
            The loop, if one is known; and a bound below which there is none, at least its weight or the limit unless
            that is too much to search.
        """
        priced = Priced(marks, self.prices[marks.part.nodes % len(self.prices)])
        roots = np.flatnonzero(priced.bounds < limit)
        if not len(roots):
            return None, limit
        if are_few(marks):
            priced = replace(priced, prices=np.where(priced.bounds < limit, priced.prices, np.inf))
        else:
            priced, _ = priced.within(roots, limit)
        best, low = None, -np.inf
        try:
            if first > 0 and not are_few(priced.marks):
                level = Level.unmarked(priced, len(self.prices), self.features)
                relaxed = self._relaxed(self._next(level, limit), limit)
                if relaxed is None:
                    return None, limit
                low = relaxed.weight
            layers = priced.layers(limit, MOST_LAYERED_EDGES)
            if layers is None:
                return None, low
            level = Level.of(priced, layers, len(self.prices), self.features)
            for number in range(first, self.automaton.n_states + 1):
                level = self._next(level, limit) if number else level
                relaxed = self._relaxed(level, limit)
                if relaxed is None:
                    break
                nearest = self._nearest(relaxed)
                if nearest is not None:
                    return nearest, nearest.weight
                low = relaxed.weight
                found = level.cheapest(self.by_state[level.first, level.states], limit)
                if found is not None:
                    best, limit = found, found.weight
        except SearchLimitError:
            return best, low
        return best, limit

    def _next(self, level: Level, limit: float) -> Level:
        return level.next(self.letter, self.automaton, self.by_state, limit)

    def _relaxed(self, level: Level, limit: float) -> ReadLoop | None:
        """The least loop of a level and all later ones, if the way to its state of TS were its price."""
        return level.cheapest(self.prices[level.states], limit)

    def _nearest(self, loop: ReadLoop) -> ReadLoop | None:
        """The loop read from where the way to its first state is least, if its word is accepted from there."""
        word = self.letter[loop.states[1:]].tolist()
        first = nearest_accepted(self.automaton, word, self.by_state[:, loop.states[0]])
        return None if first is None else replace(loop, first=first)
