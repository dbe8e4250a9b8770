"""What a finite word does to an automaton: the profiles that make loops of the transition system exact.

A word v leads the automaton from each state q to a state q' with marks m; all these triples are the profile of v.
Profiles multiply as words are joined, and the profile of v alone decides from which states v^omega is accepted.
So the profiles of all words are the states of one more deterministic automaton: a loop in its product with the
transition system is a loop of the transition system, whether or not the automaton returns to its state within
one round.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.automaton import Automaton
from drake_ltl.planning.orbits import accepted, all_rows, closed


@dataclass(frozen=True, eq=False)
class Profiles:
    """All profiles of words over the letters, G of them; number 0 stands for the empty word and for no other."""

    automaton: Automaton
    """Its states are the profiles; it has no marks, and no clauses to accept by."""
    accepted: NDArray[np.bool_]
    """(G, Q): from which states v^omega is accepted if v has the profile; from none for number 0."""
    closed: NDArray[np.bool_]
    """(G, Q): which states v leads back to themselves, with marks that are accepted if they recur."""

    def closed_later(self, state: int) -> tuple[Automaton, NDArray[np.bool_]] | None:
        """The words v with v^omega accepted from a state that v itself does not close in that way.

        Returns:
            The least automaton that reads them, and which of its states are final; None if there are none.
        """
        final = self.accepted[:, state] & ~self.closed[:, state]
        return _smallest(self.automaton, final) if final.any() else None


def all_profiles(automaton: Automaton, letters: NDArray, most: int) -> Profiles:
    """The profiles of all words over some letters.

    Raises:
        SearchLimitError: there are more than `most`.
    """
    rows, onwards = all_rows(automaton, letters, most)
    nothing = np.zeros((1, automaton.n_states), dtype=bool)
    return Profiles(
        Automaton(0, onwards, np.zeros_like(onwards), ()),
        np.concatenate([nothing, accepted(automaton, rows)]),
        np.concatenate([nothing, closed(automaton, rows)]),
    )


def _smallest(automaton: Automaton, final: NDArray) -> tuple[Automaton, NDArray[np.bool_]]:
    """The least deterministic automaton that reads the same words to its final states, without dead ends."""
    columns = automaton.successors
    alike: dict[bytes, int] = {}  # letters that lead everywhere to the same
    letter = np.array([alike.setdefault(column.tobytes(), len(alike)) for column in columns.T])
    onwards = columns[:, np.unique(letter, return_index=True)[1]]
    alive, more = final, final | (_looked_up(final, onwards, False)).any(axis=1)
    while (more != alive).any():
        alive, more = more, more | _looked_up(more, onwards, False).any(axis=1)
    onwards = np.where(_looked_up(alive, onwards, False), onwards, -1)
    kind, n_kinds = np.where(alive, final.astype(int), -1), 0
    while n_kinds < len(set(kind.tolist())):
        n_kinds = len(set(kind.tolist()))
        kind = _ranks(np.column_stack([kind, _looked_up(kind, onwards, -1)]))
    first = np.unique(kind, return_index=True)[1]
    successors = _looked_up(kind, onwards, -1)[first][:, letter]
    return Automaton(int(kind[automaton.initial]), successors, np.zeros_like(successors), ()), final[first]


def _ranks(table: NDArray) -> NDArray[np.int64]:
    """Which of the different rows each row is, in lexicographic order (`np.unique` by rows takes ten times as long)."""
    order = np.lexsort(table.T[::-1])
    changes = (table[order[1:]] != table[order[:-1]]).any(axis=1)
    ranks = np.zeros(len(table), dtype=np.int64)
    ranks[order[1:]] = np.cumsum(changes)
    return ranks


def _looked_up(values: NDArray, numbers: NDArray, missing: object) -> NDArray:
    """values[numbers], and `missing` for the number -1."""
    return np.where(numbers >= 0, values[numbers], missing)
