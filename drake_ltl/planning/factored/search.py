"""The lasso of least J over a transition system that is never listed: like `planning.search`, for larger teams."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning import search
from drake_ltl.planning.automaton import Automaton
from drake_ltl.planning.factored.identities import Row, exchanged, follow
from drake_ltl.planning.factored.loops import ClosedLoops, Field, FoundLoop, LaterLoops, ReadLoops, find_loop
from drake_ltl.planning.factored.moves import Moves, all_moves, usual_weight
from drake_ltl.planning.factored.states import MergedStates
from drake_ltl.planning.factored.waves import WaveProduct, spread
from drake_ltl.planning.factors import way_costs
from drake_ltl.planning.orbits import nearest_accepted
from drake_ltl.planning.power import CanCarry
from drake_ltl.planning.profiles import all_profiles
from drake_ltl.planning.search import gap_between

WAVE = 1.5
"""Width of a wave in steps: wide enough to spare many small ones, narrow enough that few nodes are met twice."""

MOST_NODES = 12_000_000
"""Of a product, times marks: arrays of so many numbers are formed, some at a time."""
MOST_ENTRIES = 30_000_000
"""Of the tables that say how the formations of crowds follow each other."""


@dataclass(frozen=True)
class Route:
    """States as (options, places); the run is prefix, suffix, suffix .."""

    prefix: list[tuple[Row, list[int]]]
    suffix: list[tuple[Row, list[int]]]
    optimal: bool
    gap: float


@dataclass(frozen=True, eq=False)
class FactoredSearch:
    """The problem.

    Attributes:
        states: S; P F merged ones.
        can_carry: Lambda; the same for agents of a crowd.
        letter: (P, F), letter of each merged state.
        automaton: reads letters.
        start: options and places at the beginning.
        alpha, beta: weights of the prefix's and of the suffix's cost.
    """

    states: MergedStates
    can_carry: CanCarry
    letter: NDArray[np.int64]
    automaton: Automaton
    start: tuple[Row, list[int]]
    alpha: float = 1.0
    beta: float = 1.0

    def has_lasso(self) -> bool:
        """Whether any run is accepted."""
        return bool(self._fields)

    def run(self) -> Route | None:
        """The lasso of least J, then fewest steps, then fewest actions; None if there is none.

        Raises:
            SearchLimitError: too much is left to look at.
        """
        if not self._fields:
            return None
        settled = self.automaton.never_counts
        firsts = [self._closed_in(field, settled) for field in self._fields]
        best, later = min(firsts, key=lambda first: first.loop.weight), min(first.later for first in firsts)
        if best.loop.weight <= later:
            return self._route(best.root, best.loop)
        read_later = self._in_rounds if settled else self._over_profiles
        try:
            loop, root = read_later(best.loop, best.root)
        except SearchLimitError:
            route = self._route(best.root, best.loop)
            return Route(route.prefix, route.suffix, False, gap_between(later, best.loop.weight))
        return self._route(root, loop)

    def _in_rounds(self, loop: FoundLoop, root: int) -> tuple[FoundLoop, int]:
        """Exact search for a loop that is not closed after one round and better than a known one (`rounds`)."""
        for field in self._fields:
            kind = LaterLoops(field, self.automaton, self._by_state, self._width)
            better = find_loop(kind, loop.weight)
            if better is not None:
                loop, root = better, better.root
        return loop, root

    def _closed_in(self, field: Field, settled: bool) -> _First:
        """The cheapest loop that is closed in a product."""
        to_node = np.where(field.alive, self._distance, np.inf)
        to_state = np.broadcast_to(self._by_state.min(axis=0), self._by_state.shape).reshape(-1)
        nearest, later = bool((to_state == to_node)[field.alive].all()), float(to_state[field.alive].min())
        if settled and not nearest:
            relaxed = find_loop(ClosedLoops(field, to_state, self._width))
            root, later = self._accepted_root(relaxed), relaxed.weight
            if root is not None:
                return _First(relaxed, root, later)
        loop = find_loop(ClosedLoops(field, to_node, self._width))
        return _First(loop, loop.root, np.inf if settled and nearest else later)

    def _accepted_root(self, loop: FoundLoop) -> int | None:
        """Where the nearest way to the loop's first state ends, if the loop's word is accepted from there."""
        word, first = self.letter.reshape(-1)[loop.numbers[1:]].tolist(), loop.numbers[0]
        q = nearest_accepted(self.automaton, word, self._by_state[:, first])
        return None if q is None else q * self._prefixes.n_system + first

    def _over_profiles(self, loop: FoundLoop, root: int) -> tuple[FoundLoop, int]:
        """As `_in_rounds`, by the profiles of words, for automata that may count."""
        n_system = self._prefixes.n_system
        shown = self.letter.reshape(-1)[self._by_state.min(axis=0) < loop.weight]
        profiles = all_profiles(self.automaton, shown, search.MOST_PROFILES)
        for q, prices in enumerate(self._by_state):
            later = profiles.closed_later(q) if (prices < loop.weight).any() else None
            if later is None:
                continue
            reader, final = later
            if reader.n_states * n_system > MOST_NODES:
                raise SearchLimitError(f"a product with {reader.n_states} profiles is too large")
            kind = ReadLoops(WaveProduct(self._moves, self.letter, reader), final, prices, self._width)
            better = find_loop(kind, loop.weight)
            if better is not None:
                loop, root = better, q * n_system + better.numbers[0]
        return loop, root

    def _route(self, root: int, loop: FoundLoop) -> Route:
        """The shortest way to a node, then a loop that begins in the same merged state."""
        numbers = [node % self._prefixes.n_system for node in self._way(root)]
        rows = follow(self._prefixes.moves, numbers, self.start[0])
        suffix = exchanged(self.states, loop.rows, rows[-1])
        return Route(self._named(rows[:-1], numbers[:-1]), self._named(suffix[:-1], loop.numbers[:-1]), True, 0.0)

    def _named(self, rows: Sequence[Row], numbers: Sequence[int]) -> list[tuple[Row, list[int]]]:
        places = self.states.places[np.array(numbers, dtype=int) // self.states.n_formations].tolist()
        return list(zip(rows, places, strict=True))

    def _way(self, node: int) -> list[int]:
        """Nodes from the start to a node."""
        way, product = [node], self._prefixes
        below = np.full(product.n_nodes, np.inf)
        while self._distance[way[-1]] > 0.0:
            nodes, weights = product.backwards(np.array(way[-1:]), np.zeros(1), below)
            way.append(int(nodes[self._distance[nodes] + weights == self._distance[way[-1]]].min()))
        return way[::-1]

    @cached_property
    def _largest(self) -> float:
        members = len(self.states.scenario.agents) + len(self.states.scenario.objects)
        return max(self.alpha, self.beta) * members * float(way_costs(self.states.scenario).max())

    @cached_property
    def _moves(self) -> list[Moves]:
        return all_moves(self.states, self.can_carry, self.beta, self._largest)

    @cached_property
    def _prefixes(self) -> WaveProduct:
        same = self.alpha == self.beta
        moves = self._moves if same else all_moves(self.states, self.can_carry, self.alpha, self._largest)
        return WaveProduct(moves, self.letter, self.automaton)

    @cached_property
    def _width(self) -> float:
        return WAVE * usual_weight(self.states, self.beta, self._largest)

    @cached_property
    def _distance(self) -> NDArray[np.float64]:
        """(Q P F,): least prefix to each node."""
        product = self._prefixes
        offsets = np.full(product.n_nodes, np.inf)
        offsets[product.initial(self.states.number(*self.start))] = 0.0
        return spread(product.onwards, offsets, np.full(len(offsets), np.inf), self._width)

    @property
    def _by_state(self) -> NDArray[np.float64]:
        """(Q, P F)"""
        return self._distance.reshape(self.automaton.n_states, -1)

    @cached_property
    def _fields(self) -> list[Field]:
        """Accepting runs by the clauses of the automaton that some of them satisfy."""
        reached = np.isfinite(self._distance)
        products = (WaveProduct(self._moves, self.letter, rules) for rules in self.automaton.for_loops())
        fields = (Field.of(product, reached, self._width) for product in products)
        return [field for field in fields if field is not None]


@dataclass(frozen=True, eq=False)
class _First:
    """The cheapest loop that is closed in a product."""

    loop: FoundLoop
    root: int
    """Node of the product from which it is read."""
    later: float
    """No loop that only later rounds close has less."""


def check_size(states: MergedStates) -> None:
    """Whether merged states can be handled at all.

    Raises:
        SearchLimitError: there are too many.
    """
    n_objects = len(states.scenario.objects)
    n_places = len(states.scenario.regions) ** n_objects
    entries = n_places * 2**n_objects * sum(n * n for n in states.shape)
    if states.n_states > MOST_NODES or entries > MOST_ENTRIES:
        raise SearchLimitError(f"{states.n_states} states, {entries} entries of tables, too many to handle")


def check_product(states: MergedStates, automaton: Automaton) -> None:
    """Whether their product with an automaton can be searched.

    Raises:
        SearchLimitError: it is too large.
    """
    full = max((rules.full for rules in automaton.for_loops()), default=1)
    if states.n_states * automaton.n_states * full.bit_length() > MOST_NODES or full >= search.MOST_LAYERS:
        raise SearchLimitError(f"the product of {states.n_states} states and the automaton is too large")
