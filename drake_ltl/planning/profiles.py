"""What a finite word does to an automaton: the profiles that make loops of the transition system exact.

A word v leads the automaton from q to q' with marks m in possibly many ways; all these triples are the profile of
v. Profiles multiply as words are joined, and the profile of v alone decides from which states v^omega is accepted.
So the profiles of all words are the states of one more deterministic automaton: a loop in its product with the
transition system is a loop of the transition system, whether or not the automaton returns to its state within
one round.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.automaton import Automaton
from drake_ltl.planning.orbits import accepted, all_rows

Profile = frozenset[tuple[int, int, int]]
"""Triples (q, q', marks met); of sets of marks between the same states only the largest are kept."""


@dataclass(frozen=True, eq=False)
class Profiles:
    """All profiles of words over the letters, G of them; number 0 stands for the empty word and for no other."""

    automaton: Automaton
    """Its states are the profiles; its marks mean nothing."""
    accepted: NDArray[np.bool_]
    """(G, Q): from which states v^omega is accepted if v has the profile; from none for number 0."""
    closed: NDArray[np.bool_]
    """(G, Q): which states v leads back to themselves with all marks."""

    def closed_later(self, state: int) -> tuple[Automaton, NDArray[np.bool_]] | None:
        """The words v with v^omega accepted from a state to which v itself does not lead back with all marks.

        Returns:
            The least automaton that reads them, and which of its states are final; None if there are none.
        """
        final = self.accepted[:, state] & ~self.closed[:, state]
        return _smallest(self.automaton, final) if final.any() else None


def profile_of(automaton: Automaton, word: list[int]) -> Profile:
    """The profile of a word of at least one letter."""
    result = _letter_profile(automaton, word[0])
    for letter in word[1:]:
        result = _join(result, _letter_profile(automaton, letter))
    return result


def accepted_from(profile: Profile, full: int) -> frozenset[int]:
    """The states from which v^omega is accepted, if v has the profile: they reach a cycle with all marks."""
    states = sorted({q for triple in profile for q in triple[:2]})
    number = {q: i for i, q in enumerate(states)}
    reach = np.eye(len(states), dtype=bool)
    for q, target, _ in profile:
        reach[number[q], number[target]] = True
    for _ in range(len(states).bit_length()):
        reach = reach @ reach
    mutual = reach & reach.T
    collected = np.zeros(len(states), dtype=np.int64)
    for q, target, marks in profile:
        if mutual[number[q], number[target]]:
            collected[mutual[number[q]]] |= marks
    good = reach[:, collected == full].any(axis=1)
    return frozenset(q for q in states if good[number[q]])


def all_profiles(automaton: Automaton, letters: NDArray, most: int) -> Profiles | None:
    """The profiles of all words over some letters; None if there are more than `most`."""
    full, n_states = automaton.full, automaton.n_states
    if automaton.deterministic:
        found = all_rows(automaton, letters, most)
        if found is None:
            return None
        rows, onwards = found
        good, closed = accepted(rows, full), rows == np.arange(n_states) * (full + 1) + full
    else:
        listed = _all_of_choices(automaton, letters, most)
        if listed is None:
            return None
        profiles, onwards = listed
        good, closed = np.zeros((2, len(profiles), n_states), dtype=bool)
        for g, profile in enumerate(profiles):
            good[g, list(accepted_from(profile, full))] = True
            closed[g, [q for q, target, marks in profile if q == target and marks == full]] = True
    nothing = np.zeros((1, n_states), dtype=bool)
    numbered = Automaton(0, onwards[:, :, None], np.zeros_like(onwards)[:, :, None], 1)
    return Profiles(numbered, np.concatenate([nothing, good]), np.concatenate([nothing, closed]))


def _smallest(automaton: Automaton, final: NDArray) -> tuple[Automaton, NDArray[np.bool_]]:
    """The least deterministic automaton that reads the same words to its final states, without dead ends."""
    columns = automaton.successors[:, :, 0]
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
    successors = _looked_up(kind, onwards, -1)[first][:, letter][:, :, None]
    return Automaton(int(kind[automaton.initial]), successors, np.zeros_like(successors), 1), final[first]


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


def _all_of_choices(automaton: Automaton, letters: NDArray, most: int) -> tuple[list[Profile], NDArray] | None:
    """`all_profiles` of an automaton with choices: the profiles, and (1 + G, L) how each goes on."""
    singles = {letter: _letter_profile(automaton, letter) for letter in np.unique(letters).tolist()}
    number: dict[Profile, int] = {}
    found: list[Profile] = []
    rows: list[dict[int, int]] = []

    def enter(profile: Profile) -> int:
        if not profile:
            return -1
        if profile not in number:
            found.append(profile)
            number[profile] = len(found)
        return number[profile]

    rows.append({letter: enter(single) for letter, single in singles.items()})
    while len(rows) <= len(found):
        if len(found) > most:
            return None
        profile = found[len(rows) - 1]
        after = {single: enter(_join(profile, single)) for single in set(singles.values())}
        rows.append({letter: after[single] for letter, single in singles.items()})
    onwards = np.full((len(rows), automaton.successors.shape[1]), -1)
    for i, row in enumerate(rows):
        onwards[i, list(row)] = list(row.values())
    return found, onwards


def _letter_profile(automaton: Automaton, letter: int) -> Profile:
    successors, marks = automaton.successors[:, letter], automaton.marks[:, letter]
    q, a = np.nonzero(successors >= 0)
    return _largest(set(zip(q.tolist(), successors[q, a].tolist(), marks[q, a].tolist(), strict=True)))


def _join(first: Profile, second: Profile) -> Profile:
    onwards: dict[int, list[tuple[int, int]]] = {}
    for q, target, marks in second:
        onwards.setdefault(q, []).append((target, marks))
    return _largest({(q, t, m | n) for q, via, m in first for t, n in onwards.get(via, ())})


def _largest(triples: set[tuple[int, int, int]]) -> Profile:
    """Without triples whose marks another one between the same states has too."""
    between: dict[tuple[int, int], list[int]] = {}
    for q, target, marks in triples:
        between.setdefault((q, target), []).append(marks)
    return frozenset(
        (*ends, m)
        for ends, sets in between.items()
        for m in sets
        if not any(m != other and m & other == m for other in sets)
    )
