"""Buchi automata from Spot, read as tables over the letters that a transition system can show."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from drake_ltl.planning.transition_system import TransitionSystem
from drake_ltl.scenario.formulas import labels
from drake_ltl.spot_questions import OPTIONS, ask
from drake_ltl.spot_questions import automaton as spot_automaton
from drake_ltl.spot_support import require_spot

MOST_DETERMINISTIC = 1000
"""States of automata that are made deterministic; larger ones take long to make."""


@dataclass(frozen=True, eq=False)
class Automaton:
    """A generalised Buchi automaton with Q states over L letters, at most A alternatives each.

    A run is accepting if it meets each mark again and again. A set of marks is a bit mask.
    """

    initial: int
    successors: NDArray[np.int64]
    """(Q, L, A): states reached by reading a letter; -1 fills up."""
    marks: NDArray[np.int64]
    """(Q, L, A): marks met on the way."""
    full: int
    """All marks together, at least one."""

    @property
    def n_states(self) -> int:
        return len(self.successors)

    @property
    def deterministic(self) -> bool:
        """Whether no letter leaves a choice."""
        return self.successors.shape[2] <= 1

    def after(self, word: Iterable[int]) -> Automaton:
        """The same when some letters have been read."""
        states = {self.initial}
        for letter in word:
            states = {q for state in states for q in self.successors[state, letter].tolist()} - {-1}
        if len(states) == 1:
            return replace(self, initial=states.pop())
        return self._with_choice(sorted(states))

    def _with_choice(self, states: list[int]) -> Automaton:
        """One more state, the initial one: it reads what any of some states reads."""
        width = self.successors.shape[2]
        more = max(1, width, len(states) * width)
        room = ((0, 1), (0, 0), (0, more - width))
        successors = np.pad(self.successors, room, constant_values=-1)
        marks = np.pad(self.marks, room)
        for table, old in ((successors, self.successors), (marks, self.marks)):
            for i, state in enumerate(states):
                table[-1, :, i * width : (i + 1) * width] = old[state]
        return Automaton(self.n_states, successors, marks, self.full)


def translate(formula: str) -> Any:
    """The `spot.twa_graph` of a formula: generalised Buchi acceptance, deterministic if Spot finds it so."""
    made = spot_automaton(formula, "tgba", "deterministic", options=f"{OPTIONS},det-max-states={MOST_DETERMINISTIC}")
    return made if require_spot().is_deterministic(made) else spot_automaton(formula, "tgba", "small")


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
    """Read a `spot.twa_graph` with generalised Buchi acceptance as tables.

    Args:
        automaton: from `translate`.
        propositions: names of the P columns of `different`; at least those of the automaton.
        different: the letters, (L, P).
    """
    columns = {automaton.register_ap(ap): different[:, propositions.index(ap.ap_name())] for ap in automaton.ap()}
    read = _LetterSets({variable: _as_bits(column) for variable, column in columns.items()}, len(different))
    n_states, n_letters, n_marks = automaton.num_states(), len(different), automaton.num_sets()
    choices: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for edge in automaton.edges():
        # With no mark asked for, every run is accepting: all edges carry the one mark.
        marks = sum(1 << mark for mark in edge.acc.sets()) if n_marks else 1
        for letter in _members(read.of(edge.cond)):
            alternatives = choices.setdefault((edge.src, letter), [])
            if (edge.dst, marks) not in alternatives:
                alternatives.append((edge.dst, marks))
    width = max(map(len, choices.values()), default=1)
    successors = np.full((n_states, n_letters, width), -1)
    marks_met = np.zeros((n_states, n_letters, width), dtype=np.int64)
    for (state, letter), alternatives in choices.items():
        for a, (target, marks) in enumerate(alternatives):
            successors[state, letter, a], marks_met[state, letter, a] = target, marks
    return Automaton(automaton.get_init_state_number(), successors, marks_met, (1 << max(n_marks, 1)) - 1)


class _LetterSets:
    """For which letters a binary decision diagram is true: sets of letters as the bits of integers."""

    def __init__(self, variables: dict[int, int], n_letters: int):
        """Letters in which each variable is true."""
        self._buddy = importlib.import_module("buddy")  # comes with Spot
        self._variables, self._all = variables, (1 << n_letters) - 1
        self._known = {self._buddy.bddtrue.id(): self._all, self._buddy.bddfalse.id(): 0}

    def of(self, condition: Any) -> int:
        key = condition.id()
        if key not in self._known:
            high, low = self.of(self._buddy.bdd_high(condition)), self.of(self._buddy.bdd_low(condition))
            true = self._variables[self._buddy.bdd_var(condition)]
            self._known[key] = (true & high) | (self._all & ~true & low)
        return self._known[key]


def _as_bits(column: NDArray[np.bool_]) -> int:
    """The set of the rows where a column is true."""
    return int.from_bytes(np.packbits(column, bitorder="little").tobytes(), "little")


def _members(bits: int) -> Iterator[int]:
    while bits:
        yield (bits & -bits).bit_length() - 1
        bits &= bits - 1


def never_counts(automaton: Automaton) -> bool:
    """Whether a word v that is repeated for ever needs but one round to close a loop of the automaton.

    If true, v^omega is accepted from a state only if some state q (met after some rounds) returns to itself with
    all marks within one round. A round that leads a to b, b to c .. and back to a makes the pair (a, b) reach
    (b, c) and come back; so it suffices that no strongly connected set of pairs has (a, b) and (b, c), a != b.
    LTL cannot count, but an automaton for it may. Only a sufficient condition: False means unknown.
    """
    if not automaton.deterministic and automaton.full > 1:
        return False  # rounds from q to q may choose different marks
    n = automaton.n_states
    pairs = set()
    for letter in range(automaton.successors.shape[1]):
        table = automaton.successors[:, letter]
        steps = [(q, t) for q in range(n) for t in set(table[q].tolist()) - {-1}]
        pairs |= {(a * n + b, s * n + t) for a, s in steps for b, t in steps}
    if not pairs:
        return True
    rows, columns = np.array(sorted(pairs)).T
    graph = csr_array((np.ones(len(rows)), (rows, columns)), shape=(n * n, n * n))
    component = connected_components(graph, connection="strong")[1].reshape(n, n)
    same = component[:, :, None] == component[None, :, :]  # (a, b, c): (a, b) and (b, c) together
    same[np.arange(n), np.arange(n)] = False
    return not same.any()
