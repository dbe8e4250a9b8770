"""What a finite word says of a formula already: whether every continuation satisfies it, none does, or some do.

A Spot monitor is the automaton that reads exactly the prefixes of words that satisfy a formula. A prefix that the
formula's monitor cannot read is bad: nothing that follows can make it good. One that the monitor of the negation cannot
read is good. All others are undecided, as every prefix is of `GF p`.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from enum import Enum
from typing import Any, NamedTuple

from drake_ltl.errors import SearchLimitError
from drake_ltl.spot_questions import OPTIONS, ask
from drake_ltl.spot_support import require_spot

SECONDS = 5.0
"""Time for the monitors of one formula."""

Edge = tuple[frozenset[str], frozenset[str], int]
"""Propositions that hold in a letter, others that do not, and the state that is reached by reading it."""
Table = tuple[tuple[Edge, ...], ...]
"""The edges that leave each state of a deterministic monitor; the first state is the initial one."""


class Standing(Enum):
    """What a prefix says of a formula."""

    GOOD = "good"
    BAD = "bad"
    UNDECIDED = "undecided"


class Place(NamedTuple):
    """Where the two monitors are; None where one could not read on."""

    formula: int | None
    negation: int | None

    @property
    def standing(self) -> Standing:
        if self.formula is None:
            return Standing.BAD
        return Standing.GOOD if self.negation is None else Standing.UNDECIDED


START = Place(0, 0)


@dataclass(frozen=True)
class Prefixes:
    """The monitors of a formula and of its negation, as plain tables."""

    formula: Table
    negation: Table

    def after(self, place: Place, letter: AbstractSet[str]) -> Place:
        """When one more letter is read."""
        return Place(_next(self.formula, place.formula, letter), _next(self.negation, place.negation, letter))


def prefixes(formula: str, seconds: float = SECONDS) -> Prefixes:
    """The monitors of an LTL formula.

    Raises:
        SearchLimitError: they take longer, or more memory, than there is.
        MissingDependencyError: Spot is not installed.
    """
    try:
        return Prefixes(*ask(_tables, formula, seconds=seconds))
    except TimeoutError as error:
        raise SearchLimitError(f"its automaton is not made within {seconds:g} s") from error


def _next(table: Table, state: int | None, letter: AbstractSet[str]) -> int | None:
    if state is None:
        return None
    return next((to for holds, fails, to in table[state] if holds <= letter and not fails & letter), None)


def _tables(formula: str) -> tuple[Table, Table]:
    spot = require_spot()
    parsed = spot.formula(formula)
    return _table(parsed.translate("monitor", "det", xargs=OPTIONS)), _table(
        spot.formula.Not(parsed).translate("monitor", "det", xargs=OPTIONS)
    )


def _table(monitor: Any) -> Table:
    """Of a deterministic `spot.twa_graph`, its states renumbered so that the initial one comes first."""
    buddy = importlib.import_module("buddy")  # comes with Spot
    names = {monitor.register_ap(proposition): proposition.ap_name() for proposition in monitor.ap()}
    first = monitor.get_init_state_number()
    order = [first, *(state for state in range(monitor.num_states()) if state != first)]
    number = {state: index for index, state in enumerate(order)}
    return tuple(
        tuple(
            (holds, fails, number[edge.dst])
            for edge in monitor.out(state)
            for holds, fails in _cubes(buddy, edge.cond, names)
        )
        for state in order
    )


def _cubes(
    buddy: Any,
    condition: Any,
    names: Mapping[int, str],
    holds: frozenset[str] = frozenset(),
    fails: frozenset[str] = frozenset(),
) -> Iterator[tuple[frozenset[str], frozenset[str]]]:
    """The paths of a decision diagram to true."""
    if condition == buddy.bddtrue:
        yield holds, fails
    elif condition != buddy.bddfalse:
        name = {names[buddy.bdd_var(condition)]}
        yield from _cubes(buddy, buddy.bdd_high(condition), names, holds | name, fails)
        yield from _cubes(buddy, buddy.bdd_low(condition), names, holds, fails | name)
