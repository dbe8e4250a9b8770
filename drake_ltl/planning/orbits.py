"""Profiles of words as rows of numbers: where a word leads an automaton from each state, and with which marks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.automaton import Automaton


def row_of(automaton: Automaton, word: Sequence[int]) -> NDArray[np.int64]:
    """The profile of a word of at least one letter, (Q,)."""
    singles, n_marks = _letter_rows(automaton), _n_marks(automaton)
    row = singles[word[0]]
    for letter in word[1:]:
        row = _join(row, singles[letter], n_marks)
    return row


def all_rows(automaton: Automaton, letters: NDArray, most: int) -> tuple[NDArray, NDArray]:
    """The profiles of all words over some letters.

    Args:
        automaton: Q states, L letters.
        letters: those to form words of.
        most: give up rather than find more profiles.

    Returns:
        Rows (G, Q) of target * 2^marks + marks met, or -1 where the word is not read; and how each goes on with
        each letter, (1 + G, L): the number 1, 2 .. of a profile, 0 being the empty word, or -1.

    Raises:
        SearchLimitError: there are more.
    """
    n_letters, n_marks = automaton.successors.shape[1], _n_marks(automaton)
    singles, same = np.unique(_letter_rows(automaton)[np.unique(letters)], axis=0, return_inverse=True)
    number: dict[bytes, int] = {np.full(automaton.n_states, -1).tobytes(): -1}
    found: list[NDArray] = []

    def enter(rows: NDArray) -> list[int]:
        for row in rows:
            if number.setdefault(row.tobytes(), len(found) + 1) > len(found):
                found.append(row)
        return [number[row.tobytes()] for row in rows]

    follows = [enter(singles)]
    while len(follows) <= len(found):
        if len(found) > most:
            raise SearchLimitError(f"words have more than {most} profiles")
        new = np.array(found[len(follows) - 1 :])
        follows += [enter(joined) for joined in _join(new[:, None], singles[None], n_marks)]
    rows = np.array(found, dtype=np.int64).reshape(-1, automaton.n_states)
    onwards = np.full((len(follows), n_letters), -1)
    onwards[:, np.unique(letters)] = np.array(follows)[:, same.reshape(-1)]
    return rows, onwards


def accepted(automaton: Automaton, rows: NDArray) -> NDArray[np.bool_]:
    """(G, Q): whether the word repeated for ever is accepted from each state, for rows (G, Q)."""
    n_states, n_marks = rows.shape[1], _n_marks(automaton)
    word = np.column_stack([rows, np.full(len(rows), n_states * n_marks)])  # one more state: rejected for good
    word[:, :-1][rows < 0] = n_states * n_marks
    many = word
    for _ in range(n_states.bit_length()):
        many = _join(many, many, n_marks)  # so many rounds lead to those that recur
    settled, round_about = many // n_marks, word
    for _ in range(n_states.bit_length()):  # marks of 2, 4 .. rounds; in the end all that recur
        round_about = _join(round_about, round_about, n_marks)
    met = np.take_along_axis(round_about % n_marks, settled, axis=1)
    return ((settled < n_states) & automaton.accepts(met))[:, :-1]


def nearest_accepted(automaton: Automaton, word: Sequence[int], ways: NDArray) -> int | None:
    """The state to which the way (Q,) is least, if a word repeated for ever is accepted from there."""
    nearest = np.flatnonzero(ways == ways.min()).tolist()
    return next((state for state in nearest if _is_accepted(automaton, word, state)), None)


def _is_accepted(automaton: Automaton, word: Sequence[int], state: int) -> bool:
    """Whether a word repeated for ever is accepted from a state: read, round by round, until a state comes again."""
    rounds: dict[int, int] = {}
    met: list[int] = []
    while state not in rounds:
        rounds[state] = len(met)
        met.append(0)
        for letter in word:
            met[-1] |= int(automaton.marks[state, letter])
            state = int(automaton.successors[state, letter])
            if state < 0:
                return False
    recurring = np.bitwise_or.reduce(met[rounds[state] :])
    return bool(automaton.accepts(recurring))


def closed(automaton: Automaton, rows: NDArray) -> NDArray[np.bool_]:
    """(G, Q): whether the word leads each state back to itself with marks that are accepted if they recur."""
    target, met = np.divmod(rows, _n_marks(automaton))
    return (target == np.arange(rows.shape[1])) & automaton.accepts(met)


def _n_marks(automaton: Automaton) -> int:
    """Number of sets of marks."""
    return 1 << int(automaton.marks.max(initial=0)).bit_length()


def _letter_rows(automaton: Automaton) -> NDArray[np.int64]:
    """(L, Q): rows of the words of one letter."""
    successors, marks = automaton.successors.T, automaton.marks.T
    return np.where(successors >= 0, successors * _n_marks(automaton) + marks, -1)


def _join(first: NDArray, second: NDArray, n_marks: int) -> NDArray[np.int64]:
    """Rows of the words that begin with one and go on with another; leading axes are broadcast."""
    shape = np.broadcast_shapes(first.shape, second.shape)
    first, second = np.broadcast_to(first, shape), np.broadcast_to(second, shape)
    onwards = np.take_along_axis(second, np.maximum(first, 0) // n_marks, axis=-1)
    return np.where((first < 0) | (onwards < 0), -1, onwards | (np.maximum(first, 0) % n_marks))
