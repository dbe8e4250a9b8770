"""The cheapest loops of a factored product, by growing limits.

Bounds that hold for every node leave, at each limit, but the nodes that a loop of less price + weight can use. These
few are searched as an ordinary graph. A loop that costs less than the limit is then the cheapest of all.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.automaton import Automaton
from drake_ltl.planning.factored.identities import Row, follow, sorted_row
from drake_ltl.planning.factored.nearby import Local, Nearby
from drake_ltl.planning.factored.waves import Step, WaveProduct, least, spread
from drake_ltl.planning.loops import LoopProblem, cheapest_loop
from drake_ltl.planning.marks import Marks
from drake_ltl.planning.product import accepting_part
from drake_ltl.planning.rounds import Rounds
from drake_ltl.planning.search import closed_loop

FIRST_STEP = 1 / 32
"""Share of the lower bound by which the first limit exceeds it; steps grow if nothing is found."""
MOST_FAILURES = 6
"""So often steps are made smaller if too much is left to look at."""


@dataclass(frozen=True)
class FoundLoop:
    """A loop of TS."""

    weight: float
    """Price + weight."""
    root: int
    """Node of the product in which it begins."""
    numbers: list[int]
    """Merged states; the first one stands at the end too."""
    rows: list[Row]
    """Options of the agents in each, those of a crowd sorted in the first and, again, in the last."""


class Kind(Protocol):
    """What a loop has to be."""

    low: float
    """No loop has less price + weight."""
    grain: float
    """Weight of about one ordinary step."""

    def within(self, limit: float) -> Nearby | None:
        """What loops below a limit can use."""

    def solve(self, local: Local, limit: float) -> tuple[float, list[int]]:
        """The cheapest loop of a graph, or any if none is below a limit: price + weight, inf if there is none at all,
        and nodes of the graph's product."""


def find_loop(kind: Kind, high: float = np.inf) -> FoundLoop | None:
    """The cheapest loop below `high`; None if there is none.

    Raises:
        SearchLimitError: too much is left to look at.
    """
    low, known, failures = kind.low, np.inf, 0
    step = max(kind.low * FIRST_STEP, kind.grain)
    while low < high:
        limit = min(low + np.ceil(step), high, known if known > low else np.inf)
        try:
            found, weight = _below(kind, limit)
        except SearchLimitError:
            failures += 1
            if failures > MOST_FAILURES:
                raise
            step /= 3.0
            continue
        if found is not None:
            return found
        low, known, step = limit, weight + 1.0, step * 2.0
    return None


def _below(kind: Kind, limit: float) -> tuple[FoundLoop | None, float]:
    """The cheapest loop below a limit; and price + weight of any, up to who is who, if there is none."""
    nearby = kind.within(limit)
    if nearby is None:
        return None, np.inf
    merged = nearby.merged()
    weight, nodes = kind.solve(merged, limit)
    if weight >= limit:
        return None, weight
    found = _with_identities(nearby, merged, weight, nodes)
    if found is None:
        labelled = nearby.labelled()
        weight, nodes = kind.solve(labelled, limit)
        if weight < limit:
            rows = labelled.system.options[_states(labelled, nodes)].tolist()
            found = _found(nearby, labelled, weight, nodes, rows)
    return found, weight


def _states(local: Local, nodes: list[int]) -> NDArray[np.int64]:
    return np.array(nodes) % local.system.n_states


def _with_identities(nearby: Nearby, merged: Local, weight: float, nodes: list[int]) -> FoundLoop | None:
    """The loop with an agent for each option, if in the end everybody can be who he was."""
    numbers = merged.numbers[_states(merged, nodes)].tolist()
    moves = nearby.product.moves
    rows = follow(moves, numbers, sorted_row(moves[0].states, numbers[0]), closed=True)
    return None if rows is None else _found(nearby, merged, weight, nodes, rows)


def _found(nearby: Nearby, local: Local, weight: float, nodes: list[int], rows: list[Row]) -> FoundLoop:
    numbers = local.numbers[_states(local, nodes)].tolist()
    root = nodes[0] // local.system.n_states * nearby.product.n_system + numbers[0]
    return FoundLoop(weight, root, numbers, rows)


@dataclass(frozen=True, eq=False)
class Field:
    """What is known of a product's accepting runs, for M marks."""

    product: WaveProduct
    alive: NDArray[np.bool_]
    """(n,): nodes that a run from the start reaches and from which it can be accepted."""
    ahead: NDArray[np.float64]
    """(M, n): least way that ends with an edge with each mark."""
    since: NDArray[np.float64]
    """(M, n): at most the least way from the end of such an edge."""

    @classmethod
    def of(cls, product: WaveProduct, reached: NDArray[np.bool_], width: float) -> Field | None:
        """None if no node that is reached has an accepting run.

        Nodes from which some mark is out of reach are left out, until there are none: a greatest fixed point.
        """
        alive = reached
        while alive.any():
            ahead = _ahead(product, alive, width)
            smaller = np.isfinite(ahead).all(axis=0)
            if (smaller == alive).all():
                return cls(product, alive, ahead, _since(product, alive, width))
            alive = smaller
        return None


def _ahead(product: WaveProduct, alive: NDArray, width: float) -> NDArray[np.float64]:
    below, nodes = np.where(alive, np.inf, -np.inf), np.flatnonzero(alive)
    first = [
        least(len(alive), product.only(mark).backwards(nodes, np.zeros(len(nodes)), below)) for mark in _marks(product)
    ]
    return _spread_all(product.backwards, first, below, width)


def _since(product: WaveProduct, alive: NDArray, width: float) -> NDArray[np.float64]:
    below = np.where(alive, np.inf, -np.inf)
    first = [np.where(alive & product.marked(mark), 0.0, np.inf) for mark in _marks(product)]
    return _spread_all(product.onwards, first, below, width)


def _spread_all(step: Step, offsets: list[NDArray], below: NDArray, width: float) -> NDArray[np.float64]:
    """(M, n), for M offsets (n,) at once."""
    return spread(step, np.concatenate(offsets), np.tile(below, len(offsets)), width).reshape(len(offsets), -1)


def _marks(product: WaveProduct) -> range:
    return range(product.automaton.full.bit_length())


class ClosedLoops:
    """Loops that are closed in the product, with all marks."""

    def __init__(self, field: Field, prices: NDArray, width: float):
        """Prices (n,): what it costs to begin a loop at each node; width of waves."""
        self._field, self._prices, self._width = field, prices, width
        self._round = (field.ahead + field.since).max(axis=0)
        self._least = np.where(field.alive, prices, np.inf) + self._round
        self.low, self.grain = float(self._least.min()), width

    def within(self, limit: float) -> Nearby | None:
        """Nodes on the way from some root by way of each mark, before or after, and back to some root in time."""
        product, width, roots, marks = (
            self._field.product,
            self._width,
            self._least < limit,
            _marks(self._field.product),
        )
        if not roots.any():
            return None
        prices = np.where(roots, self._prices, np.inf)
        round_about = np.where(self._round + prices.min() < limit, limit, -np.inf)
        begun = spread(product.onwards, prices, round_about, width)
        below = np.where(np.isfinite(begun), limit - begun, -np.inf)
        home = spread(product.backwards, np.where(roots, 0.0, np.inf), below, width)
        at, n = np.flatnonzero(np.isfinite(home)), len(home)
        homeward = [least(n, product.only(mark).backwards(at, home[at], below)) for mark in marks]
        homeward = _spread_all(product.backwards, homeward, below, width)
        below = np.where(np.isfinite(home), limit - home, -np.inf)
        passed = [least(n, product.only(mark).onwards(at, begun[at], below)) for mark in marks]
        passed = _spread_all(product.onwards, passed, below, width)
        nodes = np.flatnonzero(np.minimum(passed + home, begun + homeward).max(axis=0) < limit)
        return Nearby(product, nodes, prices[nodes], begun[nodes], home[nodes], limit) if len(nodes) else None

    def solve(self, local: Local, limit: float) -> tuple[float, list[int]]:
        """The cheapest loop of the accepting part."""
        full = self._field.product.automaton.full
        part = accepting_part(local.product, local.alive, full)
        prices = local.prices[part.nodes]
        if not np.isfinite(prices).any():
            return np.inf, []
        loop = closed_loop(Marks.of(part, full), prices, local.features, limit)
        if loop.bound < min(loop.weight, limit):
            raise SearchLimitError("too many loops are left near the best ones")
        return loop.weight, part.nodes[loop.nodes].tolist()


class LaterLoops(ClosedLoops):
    """Loops that stay where those with all marks are, but that only later rounds close."""

    def __init__(self, field: Field, automaton: Automaton, by_state: NDArray, width: float):
        """The automaton that reads the whole run; by_state (Q, P F), the least way to each node; width of waves."""
        super().__init__(field, np.tile(by_state.min(axis=0), len(by_state)), width)
        self._automaton, self._by_state = automaton, by_state

    def solve(self, local: Local, limit: float) -> tuple[float, list[int]]:
        """The cheapest loop; of its nodes the first one says where the automaton begins to read it."""
        n_states, full = local.system.n_states, self._field.product.automaton.full
        part = accepting_part(local.product, local.alive, full)
        by_state = self._by_state[:, local.numbers]
        prices = np.where(np.isfinite(local.prices.reshape(-1, n_states)).any(axis=0), by_state.min(axis=0), np.inf)
        letter = self._field.product.letter.reshape(-1)[local.numbers]
        if not np.isfinite(prices[part.nodes % n_states]).any():
            return np.inf, []
        rounds = Rounds(self._automaton, letter, by_state, prices, local.features)
        loop, bound = rounds.cheapest(Marks.of(part, full), limit)
        if bound < (limit if loop is None else loop.weight):
            raise SearchLimitError("too many loops are left near the best ones")
        return (
            (np.inf, []) if loop is None else (loop.weight, [loop.first * n_states + loop.states[0], *loop.states[1:]])
        )


class ReadLoops:
    """Loops whose words are read to a final state; they begin in the reader's initial state."""

    def __init__(self, product: WaveProduct, final: NDArray[np.bool_], prices: NDArray, width: float):
        """Final states (Q,) of the product's automaton; prices (P F,), what it costs to begin at a merged state;
        width of waves."""
        self._product, self._final, self._prices, self._width = product, final, prices, width
        self.low, self.grain = float(prices.min()), width

    def within(self, limit: float) -> Nearby | None:
        """Nodes from where some root's state can be met in time."""
        product, initial = self._product, self._product.automaton.initial
        prices = np.full((product.automaton.n_states, product.n_system), np.inf)
        prices[initial] = np.where(self._prices < limit, self._prices, np.inf)
        goals = np.where(self._final[:, None] & np.isfinite(prices[initial]), 0.0, np.inf).reshape(-1)
        prices = prices.reshape(-1)
        begun = spread(product.onwards, prices, np.full(len(prices), limit), self._width)
        below = np.where(np.isfinite(begun), limit - begun, -np.inf)
        home = spread(product.backwards, goals, below, self._width)
        nodes = np.flatnonzero(begun + home < limit)
        return Nearby(product, nodes, prices[nodes], begun[nodes], home[nodes], limit) if len(nodes) else None

    def solve(self, local: Local, limit: float) -> tuple[float, list[int]]:
        """The cheapest loop."""
        n_states, initial = local.system.n_states, self._product.automaton.initial
        prices = local.prices.reshape(-1, n_states)[initial]
        states = np.flatnonzero(np.isfinite(prices))
        goals = states[:, None] + np.flatnonzero(self._final) * n_states
        roots = states + initial * n_states
        problem = LoopProblem(local.product.graph, roots, goals, local.features(states))
        loop = cheapest_loop(problem, prices[states], limit)
        return (np.inf, []) if loop is None else (loop.weight, list(loop.nodes))
