"""Automata from Spot, read as tables over the letters that a transition system can show."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.acceptance import Clause, clauses, mask, renumbered
from drake_ltl.planning.transition_system import TransitionSystem
from drake_ltl.scenario.formulas import labels
from drake_ltl.spot_questions import OPTIONS, ask
from drake_ltl.spot_questions import automaton as spot_automaton
from drake_ltl.spot_support import require_spot

MOST_STATES = 3000
"""Of an automaton while it is made deterministic; larger ones take long to make."""
MOST_SYMBOLIC_EDGES = 1_000_000
"""Of such an automaton."""
FEW_STATES, FEW_MARKS = 8, 4
"""To make smaller automata simpler takes longer than to search with them."""
MOST_PAIRS = 20_000_000
"""Of states, that are looked at to see whether an automaton counts, times letters."""


@dataclass(frozen=True, eq=False)
class Automaton:
    """A deterministic automaton with Q states over L letters, whose edges carry marks.

    A run is accepting if the marks that it meets again and again satisfy a clause. Such an automaton exists for
    every formula. A set of marks is a bit mask.
    """

    initial: int
    successors: NDArray[np.int64]
    """(Q, L): the state reached by reading a letter; -1 if no word goes on so."""
    marks: NDArray[np.int64]
    """(Q, L): marks met on the way."""
    clauses: tuple[Clause, ...]
    """Ways to accept."""

    @property
    def n_states(self) -> int:
        return len(self.successors)

    @property
    def full(self) -> int:
        """All marks, of an automaton whose loops must meet each of them (`for_loops`)."""
        (clause,) = self.clauses
        return mask(clause.often)

    def after(self, word: Iterable[int]) -> Automaton:
        """The same when some letters have been read; if they cannot be, it reads nothing."""
        state = self.initial
        for letter in word:
            state = int(self.successors[state, letter]) if state >= 0 else -1
        if state >= 0:
            return self if state == self.initial else replace(self, initial=state)
        return replace(self, successors=np.full_like(self.successors, -1))

    def simplified(self) -> Automaton:
        """The same with fewer states, and marks that say more (`saturated`), unless it is small as it is."""
        small = self.n_states <= FEW_STATES and int(self.marks.max(initial=0)) < 1 << FEW_MARKS
        return self if small else self.saturated().reduced()

    def reduced(self) -> Automaton:
        """The same without states that are not reached, and with states that nothing tells apart made one."""
        reached, onwards = np.zeros(self.n_states, dtype=bool), np.array([self.initial])
        while len(onwards):
            reached[onwards] = True
            onwards = np.unique(self.successors[onwards])
            onwards = onwards[(onwards >= 0) & ~reached[onwards]]
        states = np.flatnonzero(reached)
        successors, marks = self.successors[states], np.where(self.successors[states] < 0, -1, self.marks[states])
        number, n_kinds = np.zeros(self.n_states + 1, dtype=np.int64), 0  # one more: where -1 leads
        while True:
            rows = np.column_stack([number[states], np.where(successors < 0, -1, number[successors]), marks])
            _, first, kind = np.unique(rows, axis=0, return_index=True, return_inverse=True)
            number[states] = kind.reshape(-1)
            if len(first) == n_kinds:
                break
            n_kinds = len(first)
        onto = np.where(successors[first] < 0, -1, number[successors[first]])
        return replace(self, initial=int(number[self.initial]), successors=onto, marks=self.marks[states[first]])

    def saturated(self) -> Automaton:
        """The same with each mark on all edges where it makes no difference: those that lie on no cycle without it."""
        sources, read = np.nonzero(self.successors >= 0)
        targets, marks = self.successors[sources, read], self.marks[sources, read]
        for mark in range(int(marks.max(initial=0)).bit_length()):
            rest = np.flatnonzero((marks >> mark & 1) == 0)
            ends = sources[rest], targets[rest]
            graph = csr_array((np.ones(len(rest)), ends), shape=(self.n_states, self.n_states))
            component = connected_components(graph, connection="strong")[1]
            marks[rest[component[ends[0]] != component[ends[1]]]] |= 1 << mark
        everywhere = np.zeros_like(self.marks)
        everywhere[sources, read] = marks
        return replace(self, marks=everywhere)

    def accepts(self, met: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether sets of marks that recur satisfy any clause."""
        good = np.zeros(met.shape, dtype=bool)
        for clause in self.clauses:
            often, never = mask(clause.often), mask(clause.never)
            good |= (met & (often | never)) == often
        return good

    @cached_property
    def never_counts(self) -> bool:
        """Whether a word v that is repeated for ever needs but one round to close a loop of the automaton.

        If true, some state q, met after some rounds, returns to itself within one round, whose marks decide whether
        v^omega is accepted. A round that leads a to b, b to c .. and back to a makes the pair (a, b) reach (b, c) and
        come back; so it suffices that no strongly connected set of pairs has (a, b) and (b, c), a != b.
        LTL cannot count, but an automaton for it may. Only a sufficient condition: False means unknown.
        """
        n, columns = self.n_states, np.array([*{row.tobytes(): row for row in self.successors.T}.values()])
        pairs = self._pairs_met(columns)
        if pairs is None or len(pairs) * len(columns) > MOST_PAIRS:
            return False
        first, second = np.divmod(pairs, n)
        number = np.full(n * n, -1, dtype=np.int32)
        number[pairs] = np.arange(len(pairs))
        onwards = columns[:, first] * n + columns[:, second]  # of each pair, by each letter
        read, pair = np.nonzero((columns[:, first] >= 0) & (columns[:, second] >= 0))
        graph = csr_array((np.ones(len(pair)), (pair, number[onwards[read, pair]])), shape=(len(pairs),) * 2)
        component = connected_components(graph, connection="strong")[1].astype(np.int64)
        return not np.isin((component * n + second)[first != second], component * n + first).any()

    def _pairs_met(self, columns: NDArray) -> NDArray[np.int64] | None:
        """Pairs a Q + b of states that two runs over the same word can be in, for some letter leads to both; all pairs
        of few states, None of too many."""
        if self.n_states**2 > MOST_PAIRS:
            return None
        if self.n_states <= FEW_STATES:
            return np.arange(self.n_states**2)
        met = np.zeros((self.n_states, self.n_states), dtype=bool)
        for column in columns:
            states = np.unique(column[column >= 0])
            met[np.ix_(states, states)] = True
        return np.flatnonzero(met)

    def for_loops(self) -> Iterator[Automaton]:
        """For each clause what may be used, and must be met, by a loop: the edges without marks that must not recur,
        with the others' marks numbered from 0. There is at least one mark, if need be one that all edges carry."""
        for clause in self.clauses:
            often = sorted(clause.often)
            if often and len(self.clauses) == 1 and not clause.never and often == list(range(len(often))):
                yield self
                continue
            kept = (self.marks & mask(clause.never)) == 0
            marks = renumbered(self.marks, often) if often else np.ones_like(self.marks)
            successors = self.successors if kept.all() else np.where(kept, self.successors, -1)
            every = Clause(frozenset(range(max(1, len(often)))), frozenset())
            yield Automaton(self.initial, successors, marks, (every,))


def translate(formula: str, effort: str = "low") -> Any:
    """The deterministic `spot.twa_graph` of a formula, with any acceptance.

    Args:
        formula: over canonical propositions.
        effort: "low", "medium" or "high": how much is done to make it small.

    Raises:
        SearchLimitError: it is too large.
    """
    options = f"{OPTIONS},det-max-states={MOST_STATES}"
    made = spot_automaton(formula, "generic", "deterministic", effort, options=options)
    if not require_spot().is_deterministic(made):
        raise SearchLimitError(f"a deterministic automaton of the formulas has more than {MOST_STATES} states")
    return made


def conjuncts(formula: str) -> list[str]:
    """The formulas that a conjunction is made of; the formula itself if it is none."""
    spot = require_spot()
    parsed = spot.formula(formula)
    return [str(part) for part in parsed] if parsed.kind() == spot.op_And else [str(parsed)]


def joint(formula: str, effort: str = "low") -> Any:
    """As `translate`, as the product of the automata of the formula's conjuncts.

    It is made in a fraction of the time, and where Spot cannot make a whole one; it may have some states that are equal
    (`Automaton.reduced`).
    """
    spot, parts = require_spot(), conjuncts(formula)
    made, aborter = translate(parts[0], effort), spot.output_aborter(MOST_STATES, MOST_SYMBOLIC_EDGES)
    for part in parts[1:]:
        try:
            made = spot.product(made, translate(part, effort), aborter)
        except RuntimeError as error:
            raise SearchLimitError("an automaton of the formulas has more marks than Spot can tell apart") from error
        if made is None:
            raise SearchLimitError(f"a deterministic automaton of the formulas has more than {MOST_STATES} states")
        made.purge_dead_states()
    return made


def buchi_size(formula: str, seconds: float | None = None) -> tuple[int, int]:
    """States and edges of the paper's automaton BA: state-based Buchi acceptance, small, complete.

    Raises:
        TimeoutError: it takes longer than so many seconds.
    """
    return ask(_buchi_size, formula, seconds=seconds)


def _buchi_size(formula: str) -> tuple[int, int]:
    made = require_spot().formula(formula).translate("BA", "small", "complete", xargs=OPTIONS)
    return made.num_states(), made.num_edges()


def letters(system: TransitionSystem, propositions: list[str]) -> tuple[NDArray, NDArray]:
    """L on arrays: which of some canonical propositions hold in each state.

    Returns:
        The L different letters, (L, P) booleans, and the letter of each state, (S,).
    """
    scenario = system.scenario
    members = scenario.agent_names + scenario.object_names
    codes, rows = np.zeros(system.n_states, dtype=np.int64), np.zeros((1, len(propositions)), dtype=bool)
    for member, column in zip(members, (*system.agent_regions.T, *system.places.T), strict=True):
        shown = [labels(scenario, member, region) for region in scenario.region_names]
        kinds: dict[tuple[bool, ...], int] = {}
        kind = np.array([kinds.setdefault(tuple(p in s for p in propositions), len(kinds)) for s in shown])
        truth = np.array(list(kinds))
        if truth.any():
            there, codes = _renumbered(codes * len(truth) + kind[column], len(rows) * len(truth))
            rows = rows[there // len(truth)] | truth[there % len(truth)]
    return rows, codes


def _renumbered(numbers: NDArray, size: int) -> tuple[NDArray, NDArray]:
    """The different ones among numbers below a size, and for each its place among them."""
    present = np.zeros(size, dtype=bool)
    present[numbers] = True
    return np.flatnonzero(present), (np.cumsum(present) - 1)[numbers]


def tabulate(automaton: Any, propositions: list[str], different: NDArray) -> Automaton:
    """Read a deterministic `spot.twa_graph` as tables.

    Args:
        automaton: from `translate`.
        propositions: names of the P columns of `different`; at least those of the automaton.
        different: the letters, (L, P).
    """
    columns = {automaton.register_ap(ap): different[:, propositions.index(ap.ap_name())] for ap in automaton.ap()}
    read = _LetterSets({variable: _as_bits(column) for variable, column in columns.items()}, len(different))
    successors = np.full((automaton.num_states(), len(different)), -1)
    marks = np.zeros_like(successors)
    for edge in automaton.edges():
        letters_read = read.of(edge.cond)
        successors[edge.src, letters_read], marks[edge.src, letters_read] = edge.dst, mask(edge.acc.sets())
    return Automaton(automaton.get_init_state_number(), successors, marks, clauses(automaton))


class _LetterSets:
    """For which letters a binary decision diagram is true: sets of letters as the bits of integers."""

    def __init__(self, variables: dict[int, int], n_letters: int):
        """Letters in which each variable is true."""
        self._buddy = importlib.import_module("buddy")  # comes with Spot
        self._variables, self._n_letters = variables, n_letters
        self._all = (1 << n_letters) - 1
        self._known = {self._buddy.bddtrue.id(): self._all, self._buddy.bddfalse.id(): 0}

    def of(self, condition: Any) -> NDArray[np.int64]:
        """The letters for which a condition is true."""
        text = self._bits(condition).to_bytes(-(-self._n_letters // 8), "little")
        return np.flatnonzero(np.unpackbits(np.frombuffer(text, np.uint8), bitorder="little"))

    def _bits(self, condition: Any) -> int:
        key = condition.id()
        if key not in self._known:
            high, low = self._bits(self._buddy.bdd_high(condition)), self._bits(self._buddy.bdd_low(condition))
            true = self._variables[self._buddy.bdd_var(condition)]
            self._known[key] = (true & high) | (self._all & ~true & low)
        return self._known[key]


def _as_bits(column: NDArray[np.bool_]) -> int:
    """The set of the rows where a column is true."""
    return int.from_bytes(np.packbits(column, bitorder="little").tobytes(), "little")
