"""What a finite word does to an automaton: the profiles that make loops of the transition system exact.

A word v leads the automaton from q to q' with marks m in possibly many ways; all these triples are the profile of
v. Profiles multiply as words are joined, and the profile of v alone decides from which states v^omega is accepted.
So the profiles of all words are the states of one more deterministic automaton: a loop in its product with the
transition system is a loop of the transition system, whether or not the automaton returns to its state within
one round.
"""

from __future__ import annotations

from dataclasses import dataclass

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.automaton import Automaton

Profile = frozenset[tuple[int, int, int]]
"""Triples (q, q', marks met); of sets of marks between the same states only the largest are kept."""


@dataclass(frozen=True, eq=False)
class Profiles:
    """All profiles of words over the letters; number 0 stands for the empty word and for no other."""

    automaton: Automaton
    """Its states are the profiles; its marks mean nothing."""
    accepted: tuple[frozenset[int], ...]
    """For each profile of v the states from which v^omega is accepted; empty for number 0."""


def profile_of(automaton: Automaton, word: list[int]) -> Profile:
    """The profile of a word of at least one letter."""
    result = _letter_profile(automaton, word[0])
    for letter in word[1:]:
        result = _join(result, _letter_profile(automaton, letter))
    return result


def accepted_from(profile: Profile, full: int) -> frozenset[int]:
    """The states from which v^omega is accepted, if v has the profile: they reach a cycle with all marks."""
    graph = nx.MultiDiGraph()
    graph.add_edges_from((q, t, {"marks": m}) for q, t, m in profile)
    good: set[int] = set()
    for component in nx.strongly_connected_components(graph):
        collected = 0
        for _, _, marks in graph.subgraph(component).edges(data="marks"):
            collected |= marks
        if collected == full:
            good |= component
            good |= set().union(*(nx.ancestors(graph, q) for q in component))
    return frozenset(good)


def all_profiles(automaton: Automaton, letters: NDArray, most: int) -> Profiles | None:
    """The profiles of all words over some letters; None if there are more than `most`."""
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
    n_letters = automaton.successors.shape[1]
    successors = np.full((len(rows), n_letters, 1), -1)
    for i, row in enumerate(rows):
        for letter, target in row.items():
            successors[i, letter, 0] = target
    accepted = (frozenset(), *(accepted_from(profile, automaton.full) for profile in found))
    return Profiles(Automaton(0, successors, np.zeros_like(successors), 1), accepted)


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
