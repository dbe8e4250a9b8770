"""The global formula as a list of small deterministic automata, one for each conjunct."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.acceptance import Clause, clauses
from drake_ltl.planning.automaton import translate
from drake_ltl.planning.demands import parts
from drake_ltl.planning.words import Letter
from drake_ltl.scenario.formulas import global_formula
from drake_ltl.scenario.model import Scenario
from drake_ltl.spot_questions import automaton as translated
from drake_ltl.spot_support import require_spot

Cube = tuple[tuple[str, bool], ...]
"""Some propositions `m.p` and whether they hold; the others do not matter."""

_MOST_LETTERS = 64
_MOST_WORDS = 3000
_MOST_TOGETHER = 10
"""Beyond the first two it is not computed after how many rounds an automaton settles; beyond the third, not
whether all conjuncts together are contradictory."""


@dataclass(frozen=True)
class Edge:
    """Reading a letter within `cube` leads from a state to a state; None: no word goes on from there."""

    source: int
    cube: Cube
    target: int | None
    marks: frozenset[int] = frozenset()


@dataclass(frozen=True)
class Conjunct:
    """A deterministic Emerson-Lei automaton, complete in its edges (some lead nowhere).

    Deterministic automata always exist if the acceptance may be any Boolean combination of recurring marks; so
    a run needs no guess, and most fairness formulas need but one state.
    """

    formula: str
    initial: int
    n_states: int
    edges: tuple[Edge, ...]
    clauses: tuple[Clause, ...]

    @cached_property
    def propositions(self) -> tuple[str, ...]:
        """All that occur in the edges' cubes, `m.p`."""
        return tuple(sorted({name for edge in self.edges for name, _ in edge.cube}))

    @property
    def members(self) -> frozenset[str]:
        """Whom it speaks of."""
        return frozenset(name.partition(".")[0] for name in self.propositions)

    def read(self, state: int, letter: Iterable[str]) -> tuple[int | None, frozenset[int]]:
        """The state after a letter, and the marks met."""
        holds = set(letter)
        for edge in self.edges:
            if edge.source == state and all((name in holds) == truth for name, truth in edge.cube):
                return edge.target, edge.marks
        raise AssertionError(f"no edge of {self.formula} reads {sorted(holds)} in state {state}")

    def accepts(self, prefix: Sequence[Letter], cycle: Sequence[Letter]) -> bool:
        """Whether the formula holds on the word prefix cycle cycle ..

        Args:
            prefix: may be empty.
            cycle: at least one letter.
        """
        state: int | None = self.initial
        for letter in prefix:
            state, _ = self._read(state, letter)
        begins: list[int | None] = []
        met: list[frozenset[int]] = []
        while state is not None and state not in begins:
            begins.append(state)
            marks: set[int] = set()
            for letter in cycle:
                state, some = self._read(state, letter)
                marks |= some
            met.append(frozenset(marks))
        if state is None:
            return False
        recurring = frozenset().union(*met[begins.index(state) :])
        return any(clause.often <= recurring and not clause.never & recurring for clause in self.clauses)

    def _read(self, state: int | None, letter: Letter) -> tuple[int | None, frozenset[int]]:
        """`read`, remembered; None leads to None."""
        if state is None:
            return None, frozenset()
        key = state, letter & self._names
        if key not in self._known:
            self._known[key] = self.read(*key)
        return self._known[key]

    @cached_property
    def _names(self) -> frozenset[str]:
        return frozenset(self.propositions)

    @cached_property
    def _known(self) -> dict[tuple[int, Letter], tuple[int | None, frozenset[int]]]:
        return {}

    @cached_property
    def settles(self) -> int | None:
        """After how many rounds of any word v the automaton is in a state to which v returns; None: unknown.

        The least r such that v^r leads from each state to one that v keeps, or to none at all, for all v: found by
        forming all maps of states that words are. LTL cannot count, so that r exists for some automaton of each
        formula, though not necessarily for this one.
        """
        if self.n_states == 1 and all(edge.target == 0 for edge in self.edges):
            return 0
        if 1 << len(self.propositions) > _MOST_LETTERS:
            return None
        dead = self.n_states
        letters = {self._map(letter, dead) for letter in _subsets(self.propositions)}
        words, fresh = set(letters), list(letters)
        while fresh:
            word = fresh.pop()
            new = {tuple(letter[q] for q in word) for letter in letters} - words
            words |= new
            fresh += new
            if len(words) > _MOST_WORDS:
                return None
        rounds = [_index(word) for word in words]
        return None if None in rounds else max(r for r in rounds if r is not None)

    def _map(self, letter: Iterable[str], dead: int) -> tuple[int, ...]:
        targets = (self.read(q, letter)[0] for q in range(self.n_states))
        return (*(dead if t is None else t for t in targets), dead)


def conjuncts(scenario: Scenario) -> list[Conjunct]:
    """One automaton for each conjunct at the top of the global formula; together they are that formula."""
    return [automaton(str(part)) for part in parts(require_spot().formula(global_formula(scenario)))]


def automaton_of_each_member(scenario: Scenario) -> dict[str, Conjunct]:
    """The conjunction of the conjuncts that speak of one member alone, for each member that has one.

    Conjuncts without propositions are left out, and those that would make an automaton too large: what is left
    allows at least as much.
    """
    spot = require_spot()
    own: dict[str, list[Any]] = {}
    for part in parts(spot.formula(global_formula(scenario))):
        members = {ap.ap_name().partition(".")[0] for ap in spot.atomic_prop_collect(part)}
        if len(members) == 1:
            own.setdefault(members.pop(), []).append(part)
    return {member: _together(those) for member, those in own.items()}


def _together(formulas: list[Any]) -> Conjunct:
    """One automaton of as many formulas as it can be made of."""
    spot = require_spot()
    try:
        return automaton(str(spot.formula.And(formulas)))
    except SearchLimitError:
        kept, found = [], automaton("1")
        for formula in formulas:
            with suppress(SearchLimitError):
                found = automaton(str(spot.formula.And([*kept, formula])))
                kept.append(formula)
        return found


def is_contradictory(scenario: Scenario) -> bool:
    """Whether it is found that no word at all satisfies the global formula; not asked if it has many conjuncts.

    The automaton of a whole formula grows exponentially with the number of its conjuncts.
    """
    formula = require_spot().formula(global_formula(scenario))
    return len(list(parts(formula))) <= _MOST_TOGETHER and bool(translated(str(formula), "small").is_empty())


def automaton(formula: str) -> Conjunct:
    """A deterministic automaton of a formula.

    Raises:
        SearchLimitError: it is too large.
    """
    made = translate(formula, "high")
    names = {made.register_ap(ap): ap.ap_name() for ap in made.ap()}
    buddy = importlib.import_module("buddy")  # comes with Spot
    edges, left = [], [buddy.bddtrue for _ in range(made.num_states())]
    for edge in made.edges():
        left[edge.src] = buddy.bdd_and(left[edge.src], buddy.bdd_not(edge.cond))
        marks = frozenset(edge.acc.sets())
        edges += [Edge(edge.src, cube, edge.dst, marks) for cube in _cubes(buddy, edge.cond, names)]
    for state, condition in enumerate(left):
        edges += [Edge(state, cube, None) for cube in _cubes(buddy, condition, names)]
    return Conjunct(formula, made.get_init_state_number(), made.num_states(), tuple(edges), clauses(made))


def _cubes(buddy: Any, condition: Any, names: Mapping[int, str], so_far: Cube = ()) -> Iterator[Cube]:
    """Disjoint cubes that together are a binary decision diagram: its paths."""
    if condition == buddy.bddfalse:
        return
    if condition == buddy.bddtrue:
        yield so_far
        return
    name = names[buddy.bdd_var(condition)]
    yield from _cubes(buddy, buddy.bdd_low(condition), names, (*so_far, (name, False)))
    yield from _cubes(buddy, buddy.bdd_high(condition), names, (*so_far, (name, True)))


def _subsets(names: tuple[str, ...]) -> Iterator[list[str]]:
    for truth in product((False, True), repeat=len(names)):
        yield [name for name, holds in zip(names, truth, strict=True) if holds]


def _index(word: tuple[int, ...]) -> int | None:
    """After how many rounds of a word no state changes any more, unless it dies; None: some go round in a circle."""
    dead = len(word) - 1
    most = 0
    for state in range(dead):
        met = [state]
        while word[met[-1]] not in met:
            met.append(word[met[-1]])
        if word[met[-1]] != met[-1]:
            return None
        if met[-1] != dead:
            most = max(most, len(met) - 1)
    return most
