"""Loops whose words an automaton reads more than once before it comes back to where it was.

Let v be the word of a loop that begins in state s of TS. An automaton that never counts is led by v v .. from q_0 to
q_1, q_2 .. and at last from some q_k to q_k, which is a loop of the product. So the run of the automaton is k + 1 runs
over the same loop, side by side: from (q_0, .. q_k) to (q_1, .. q_k, q_k). Level k follows the last k + 1 of them. Each
level bounds all that come after it from below, if a loop is priced by the way to s, whatever q_0; and it has the
cheapest loop of its own, priced by the way to (q_0, s). Which marks are met by the last of the runs is looked at when
a level has been cut down to what cheap enough loops can use (`layers`), for this multiplies its size.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.automaton import Automaton
from drake_ltl.planning.distances import between, least
from drake_ltl.planning.layers import MOST_LAYERED_EDGES, Priced
from drake_ltl.planning.loops import LoopProblem, cheapest_loop
from drake_ltl.planning.marks import Features, Marks
from drake_ltl.planning.orbits import nearest_accepted
from drake_ltl.planning.product import Graph, Part, multiply

MOST_EDGES = 20_000_000
"""Of a level, before it is cut down to what is of use."""
FEW_LAYERED_EDGES = 50_000
"""So few edges with sets of marks are searched as they are: to cut them down first would take longer."""


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
    nodes: NDArray[np.int64]
    """(n,): node of the part of the product where the last of the runs is."""
    roots: NDArray[np.int64]
    """(R,): nodes in which loops begin ..."""
    goals: NDArray[np.int64]
    """(R,): .. and end."""
    first: NDArray[np.int64]
    """(R,): where the automaton is when the first of the runs begins."""
    labels: NDArray[np.int64]
    """(R, F): rows that differ from root to root, for `LoopProblem`."""
    is_marked: bool = False
    """Whether nodes also say which marks the last of the runs has met, and its loops meet all."""

    @classmethod
    def of(cls, priced: Priced, n_system: int, features: Features) -> Level:
        """Level 0: loops of the product."""
        part = priced.marks.part
        shown, nodes = part.nodes % n_system, np.arange(part.n_nodes)
        roots = np.flatnonzero(np.isfinite(priced.prices))
        begins = part.nodes[roots]
        return cls(part.graph, shown, nodes, roots, roots, begins // n_system, features(begins))

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
        shown, nodes = (np.tile(column, automaton.n_states) for column in (self.shown, self.nodes))
        q, root = np.nonzero(by_state[:, self.states] < limit)
        other = q != self.first[root]
        q, root = q[other], root[other]
        roots, goals = q * n + self.roots[root], self.first[root] * n + self.goals[root]
        labels = np.column_stack([self.labels[root], q])
        level = replace(self, graph=graph, shown=shown, nodes=nodes, roots=roots, goals=goals, first=q, labels=labels)
        return level.within(by_state.min(axis=0)[level.states], limit)

    def within(self, prices: NDArray, limit: float) -> Level:
        """Only what loops of less price (R,) + weight than a limit can use."""
        n, ends = self.graph.n_nodes, np.zeros(len(self.goals))
        begins, ends = least(n, self.roots, prices), least(n, self.goals, ends)
        graph, kept, _ = between(self.graph, self.graph.reversed(), begins, ends, limit)
        number = np.full(n, -1)
        number[kept] = np.arange(len(kept))
        return self._over(graph, kept, number[self.roots], number[self.goals])

    def marked(self, marks: Marks, prices: NDArray, limit: float) -> Level | None:
        """Loops whose last run meets all marks, of less price (R,) + weight than a limit; nodes stand for a node of
        this level together with the marks that have been met (`Layers`). None if there are too many."""
        if self.is_marked:
            return self
        n, met = self.graph.n_nodes, Marks(Part(self.graph, self._met(marks.part), self.nodes), marks.full)
        begins, ends = least(n, self.roots, prices), least(n, self.goals, np.zeros(len(self.goals)))
        layers = Priced(met, begins, ends).layers(limit, MOST_LAYERED_EDGES)
        if layers is None:
            return None
        level = self._over(layers.graph, layers.nodes, layers.first[self.roots], layers.last[self.goals])
        return replace(level, is_marked=True)

    def _met(self, part: Part) -> NDArray[np.integer]:
        """(e,): marks of the last run's edges, which are a part's."""
        if self.graph is part.graph:
            return part.marks
        keys = part.graph.sources.astype(np.int64) * part.n_nodes + part.graph.targets
        order = np.argsort(keys)
        own = self.graph.at_sources(self.nodes) * part.n_nodes + self.graph.at_targets(self.nodes)
        return part.marks[order[np.searchsorted(keys, own, sorter=order)]]

    def _over(self, graph: Graph, nodes: NDArray, roots: NDArray, goals: NDArray) -> Level:
        """The same over another graph: of whose nodes is said which node of this one each is, (n,), and of the loops
        where each begins and ends, (R,), -1 if it does not."""
        kept = np.flatnonzero((roots >= 0) & (goals >= 0))
        of_nodes = {"shown": self.shown[nodes], "nodes": self.nodes[nodes]}
        of_loops = {"roots": roots[kept], "goals": goals[kept], "first": self.first[kept], "labels": self.labels[kept]}
        return replace(self, graph=graph, **of_nodes, **of_loops)

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
        best, low, level = None, -np.inf, Level.of(priced, len(self.prices), self.features)
        try:
            for number in range(first, self.automaton.n_states + 1):
                if number:
                    level = level.next(self.letter, self.automaton, self.by_state, limit)
                    relaxed = self._relaxed(level, limit)
                    if relaxed is None:
                        break
                    low = max(low, relaxed.weight)
                marked = level.marked(priced.marks, self._relaxed_prices(level), limit)
                if marked is not None:
                    relaxed = self._relaxed(marked, limit)
                    if relaxed is None:
                        break
                    nearest = self._nearest(relaxed)
                    if nearest is not None:
                        return nearest, nearest.weight
                    low = relaxed.weight
                    level = marked if len(marked.graph.targets) <= FEW_LAYERED_EDGES else level
                found = self._exact(marked or level.marked(priced.marks, self._prices(level), limit), limit)
                if found is not None:
                    best, limit = found, found.weight
        except SearchLimitError:
            return best, low
        return best, limit

    def _relaxed(self, level: Level, limit: float) -> ReadLoop | None:
        """The least loop of a level and all later ones, if the way to its state of TS were its price."""
        return level.cheapest(self._relaxed_prices(level), limit)

    def _exact(self, level: Level | None, limit: float) -> ReadLoop | None:
        """The least loop of a level.

        Raises:
            SearchLimitError: there is none, for it would have been too large.
        """
        if level is None:
            raise SearchLimitError(f"a level has more than {MOST_LAYERED_EDGES} edges with sets of marks")
        return level.cheapest(self._prices(level), limit)

    def _prices(self, level: Level) -> NDArray[np.float64]:
        """(R,): the way to where each loop of a level begins."""
        return self.by_state[level.first, level.states]

    def _relaxed_prices(self, level: Level) -> NDArray[np.float64]:
        """(R,): the same to its state of TS, wherever the automaton is then."""
        return self.prices[level.states]

    def _nearest(self, loop: ReadLoop) -> ReadLoop | None:
        """The loop read from where the way to its first state is least, if its word is accepted from there."""
        word = self.letter[loop.states[1:]].tolist()
        first = nearest_accepted(self.automaton, word, self.by_state[:, loop.states[0]])
        return None if first is None else replace(loop, first=first)
