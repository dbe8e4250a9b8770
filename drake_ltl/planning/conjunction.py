"""The automaton of a conjunction over the letters that a transition system can show, from its conjuncts' automata.

Spot makes small automata in no time, and their product over a few letters has far fewer states than one over all.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.acceptance import Clause, renumbered
from drake_ltl.planning.automaton import MOST_STATES, Automaton, conjuncts, tabulate, translate

MOST_CLAUSES = 64
"""Ways to accept."""
MOST_MARKS = 62
"""That a number has bits for."""


def translate_each(formula: str, effort: str = "low") -> list[Any]:
    """The deterministic `spot.twa_graph` of each conjunct; arguments and errors as of `translate`."""
    return [translate(conjunct, effort) for conjunct in conjuncts(formula)]


def propositions_of(automata: Sequence[Any]) -> list[str]:
    """Those that any of some `spot.twa_graph`s reads, in alphabetical order."""
    return sorted({ap.ap_name() for automaton in automata for ap in automaton.ap()})


def tabulate_all(automata: Sequence[Any], propositions: list[str], different: NDArray) -> Automaton:
    """The automaton that accepts what all of some accept; arguments as for `tabulate`.

    Raises:
        SearchLimitError: it is too large.
    """
    return conjunction([without_idle_marks(tabulate(automaton, propositions, different)) for automaton in automata])


def without_idle_marks(automaton: Automaton) -> Automaton:
    """The same without marks that all edges carry: safety formulas need none."""
    if len(automaton.clauses) != 1 or automaton.clauses[0].never:
        return automaton
    idle = int(np.bitwise_and.reduce(automaton.marks[automaton.successors >= 0], initial=-1))
    kept = sorted(mark for mark in automaton.clauses[0].often if not idle >> mark & 1)
    return replace(
        automaton, marks=renumbered(automaton.marks, kept), clauses=(Clause(frozenset(range(len(kept))), frozenset()),)
    )


def conjunction(automata: Sequence[Automaton]) -> Automaton:
    """The product of some automata over the same L letters: what is reached of it, and has a way on.

    Raises:
        SearchLimitError: it has more than MOST_STATES states, or too many ways to accept.
    """
    if len(automata) == 1:
        return automata[0]
    _check_size(automata)
    units = np.cumprod([1, *(automaton.n_states for automaton in automata[:-1])])
    codes = np.array([sum(int(unit) * a.initial for unit, a in zip(units, automata, strict=True))])
    rows, new = [_onwards(automata, units, codes)], codes
    while len(new):
        new = np.setdiff1d(rows[-1][rows[-1] >= 0], codes)
        if len(codes) + len(new) > MOST_STATES:
            raise SearchLimitError(f"a deterministic automaton of the formulas has more than {MOST_STATES} states")
        codes = np.concatenate([codes, new])
        rows.append(_onwards(automata, units, new))
    return _numbered(codes, np.concatenate(rows), _marks(automata, units, codes), _clauses(automata))


def _check_size(automata: Sequence[Automaton]) -> None:
    if math.prod(automaton.n_states for automaton in automata) >= 1 << 62:
        raise SearchLimitError(f"an automaton of {len(automata)} formulas has too many states to be numbered")
    if math.prod(len(automaton.clauses) for automaton in automata) > MOST_CLAUSES:
        raise SearchLimitError(f"an automaton of the formulas has more than {MOST_CLAUSES} ways to accept")
    if sum(map(_n_marks, automata)) > MOST_MARKS:
        raise SearchLimitError(f"an automaton of the formulas has more than {MOST_MARKS} marks")


def _onwards(automata: Sequence[Automaton], units: NDArray, codes: NDArray) -> NDArray[np.int64]:
    """(n, L): the states, by their codes (n,), in which each letter leads; -1 where one of the automata does not read
    it."""
    onwards = np.zeros((len(codes), automata[0].successors.shape[1]), dtype=np.int64)
    read = np.ones(onwards.shape, dtype=bool)
    for unit, automaton in zip(units, automata, strict=True):
        target = automaton.successors[codes // unit % automaton.n_states]
        read &= target >= 0
        onwards += unit * target
    return np.where(read, onwards, -1)


def _marks(automata: Sequence[Automaton], units: NDArray, codes: NDArray) -> NDArray[np.int64]:
    """(n, L): the marks of all, each automaton's after those of the ones before it."""
    marks = np.zeros((len(codes), automata[0].marks.shape[1]), dtype=np.int64)
    shift = 0
    for unit, automaton in zip(units, automata, strict=True):
        marks |= automaton.marks[codes // unit % automaton.n_states] << shift
        shift += _n_marks(automaton)
    return marks


def _clauses(automata: Sequence[Automaton]) -> tuple[Clause, ...]:
    """All ways in which all accept."""
    shifts = np.cumsum([0, *map(_n_marks, automata[:-1])]).tolist()
    found = []
    for chosen in product(*(automaton.clauses for automaton in automata)):
        pairs = list(zip(chosen, shifts, strict=True))
        often = frozenset(mark + shift for clause, shift in pairs for mark in clause.often)
        never = frozenset(mark + shift for clause, shift in pairs for mark in clause.never)
        found.append(Clause(often, never))
    return tuple(found)


def _n_marks(automaton: Automaton) -> int:
    """Numbers of marks that are used, on edges or in clauses."""
    asked = [mark + 1 for clause in automaton.clauses for mark in clause.often | clause.never]
    return max([int(automaton.marks.max(initial=0)).bit_length(), *asked])


def _numbered(codes: NDArray, onwards: NDArray, marks: NDArray, clauses: tuple[Clause, ...]) -> Automaton:
    """The automaton with its states, of which the first is the initial one, numbered from 0; without dead ends."""
    order = np.argsort(codes)
    targets = np.where(onwards < 0, -1, order[np.searchsorted(codes, onwards, sorter=order).clip(max=len(codes) - 1)])
    alive = np.ones(len(codes) + 1, dtype=bool)
    alive[-1] = False  # where -1 leads
    while True:
        targets = np.where(alive[targets], targets, -1)
        dead = alive[:-1] & (targets < 0).all(axis=1)
        dead[0] = False
        if not dead.any():
            break
        alive[:-1][dead] = False
    kept = np.flatnonzero(alive[:-1])
    number = np.full(len(codes) + 1, -1)
    number[kept] = np.arange(len(kept))
    return Automaton(0, number[targets[kept]], marks[kept], clauses)
