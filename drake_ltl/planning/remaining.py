"""What a word has not fulfilled yet of each part of a specification: formulas, progressed letter by letter.

Progression rewrites a formula by what one letter settles: f holds of a word `a w` iff progressed(f, a) holds of `w`
(Bacchus and Kabanza 1998). What must recur (`GF g`) is owed anew in every round of the suffix.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from enum import Enum
from functools import cache
from typing import Any

from drake_ltl.planning.demands import Demand, demands, spaced
from drake_ltl.scenario.formulas import canonical, propositions
from drake_ltl.scenario.model import Scenario
from drake_ltl.spot_questions import is_quick
from drake_ltl.spot_support import require_spot

MOST_CHARACTERS = 2000
"""A remainder longer than this is followed no further."""


class Standing(Enum):
    """How a demand stands after some letters."""

    OWED = "owed"
    """Something must still happen; what must recur: in this round."""
    MET = "met"
    """Nothing is left to do; what must recur: in this round."""
    KEPT = "kept"
    """Holds so far, and asks for nothing but to go on."""
    BROKEN = "broken"
    """Nothing that may follow can satisfy it."""
    UNKNOWN = "unknown"
    """Too large to be followed."""


@dataclass(frozen=True)
class Goal:
    """One demand, and what is left of it."""

    demand: Demand
    standing: Standing
    left: str = ""
    """What must still hold of the word from the next letter on, in LTL; empty where nothing is owed."""


@dataclass(frozen=True)
class Pursuit:
    """All demands of a scenario on their way through a word. Texts, not objects of Spot's, so that it can be kept."""

    scenario: Scenario
    parts: tuple[Demand, ...]
    left: tuple[str, ...]
    """Of each part: the formula that the rest of the word must satisfy; of what must recur, that of the round."""
    quiet: tuple[bool, ...] = ()
    """Of each part: whether a word that goes on like the last letter owes it nothing more."""

    @staticmethod
    def of(scenario: Scenario) -> Pursuit:
        """Before the first letter."""
        parts = demands(scenario)
        left = tuple(_round_goal(part.formula) or part.formula for part in parts)
        return Pursuit(scenario, parts, left, (False,) * len(parts))

    def after(self, letter: AbstractSet[str], *, begins_round: bool = False) -> Pursuit:
        """When one more letter has been read.

        Args:
            letter: canonical propositions `member.p`.
            begins_round: whether a round of the suffix begins with it.
        """
        left, quiet = [], []
        for part, rest in zip(self.parts, self.left, strict=True):
            own = _own(self.scenario, part.owner, letter)
            again = _round_goal(part.formula)
            start = again if again and begins_round else rest
            left.append(_after_letter(start, own))
            quiet.append(_is_quiet(part.formula, own))
        return replace(self, left=tuple(left), quiet=tuple(quiet))

    @property
    def goals(self) -> tuple[Goal, ...]:
        """How every demand stands."""
        return tuple(map(_goal, self.parts, self.left, self.quiet))


def pursuits(
    scenario: Scenario, word: Iterable[AbstractSet[str]], prefix_length: int, suffix_length: int
) -> Sequence[tuple[Goal, ...]]:
    """How the demands stand after each letter of a word whose rounds begin after `prefix_length` letters."""
    pursuit, found = Pursuit.of(scenario), []
    for position, letter in enumerate(word):
        pursuit = pursuit.after(letter, begins_round=begins_round(position, prefix_length, suffix_length))
        found.append(pursuit.goals)
    return found


def begins_round(position: int, prefix_length: int, suffix_length: int) -> bool:
    """Whether a round of the suffix begins at this position of the word (the first letter is at 0)."""
    return suffix_length > 0 and position >= prefix_length and (position - prefix_length) % suffix_length == 0


def progressed(formula: Any, letter: AbstractSet[str]) -> Any:
    """What the rest of a word must satisfy for the word `letter, rest` to satisfy Spot's `formula`."""
    spot = require_spot()
    make, kind = spot.formula, formula.kindstr()
    if kind in ("tt", "ff"):
        return formula
    if kind == "ap":
        return make.tt() if formula.ap_name() in letter else make.ff()
    if kind == "X":
        return formula[0]
    parts = [progressed(part, letter) for part in formula]
    if kind == "Not":
        return make.Not(parts[0])
    if kind in ("And", "Or"):
        return make.And(parts) if kind == "And" else make.Or(parts)
    if kind in ("Implies", "Equiv", "Xor"):
        return getattr(make, kind)(*parts)
    if kind == "F":
        return make.Or([parts[0], formula])
    if kind == "G":
        return make.And([parts[0], formula])
    if kind in ("U", "W"):
        return make.Or([parts[1], make.And([parts[0], formula])])
    return make.And([parts[1], make.Or([parts[0], formula])])  # R and M


@cache
def _after_letter(formula: str, letter: frozenset[str]) -> str:
    """Empty where it has become too large to follow."""
    spot = require_spot()
    if not formula or not is_quick(formula):
        return ""
    syntactic = spot.tl_simplifier_options(True, True, True, False, False)  # no automata: these could take long
    text = str(spot.tl_simplifier(syntactic).simplify(progressed(spot.formula(formula), letter)))
    return text if len(text) <= MOST_CHARACTERS else ""


@cache
def _round_goal(formula: str) -> str:
    """F g of G F g; empty for others."""
    spot = require_spot()
    parsed = spot.formula(formula)
    return str(parsed[0]) if parsed._is(spot.op_G) and parsed[0]._is(spot.op_F) else ""


def _is_quiet(formula: str, letter: frozenset[str]) -> bool:
    """Whether F G g is asked for and g, about one instant, holds now."""
    spot = require_spot()
    parsed = spot.formula(formula)
    if not (parsed._is(spot.op_F) and parsed[0]._is(spot.op_G)):
        return False
    return parsed[0][0].is_boolean() and progressed(parsed[0][0], letter).is_tt()


def _goal(part: Demand, left: str, quiet: bool) -> Goal:
    spot = require_spot()
    if not left:
        return Goal(part, Standing.UNKNOWN)
    rest = spot.formula(left)
    if rest.is_ff():
        return Goal(part, Standing.BROKEN)
    if rest.is_tt():
        return Goal(part, Standing.MET)
    owed = [piece for piece in _conjuncts(rest) if _is_owed(piece)]
    if quiet or not owed:
        return Goal(part, Standing.KEPT)
    return Goal(part, Standing.OWED, spaced(str(spot.formula.And(owed))))


def _is_owed(piece: Any) -> bool:
    """Whether something must still happen: not of what merely must not happen, nor of rules such as G(p -> F q)."""
    spot = require_spot()
    rule = piece._is(spot.op_G) and not piece[0]._is(spot.op_F)
    return not (rule or piece.is_syntactic_safety())


def _conjuncts(formula: Any) -> list[Any]:
    return list(formula) if formula._is(require_spot().op_And) else [formula]


def _own(scenario: Scenario, owner: str, letter: AbstractSet[str]) -> frozenset[str]:
    """The letter under the names that the owner's formula uses; the global formula's are the canonical ones."""
    if not owner:
        return frozenset(letter)
    return frozenset(name for name in propositions(scenario, owner) if canonical(owner, name) in letter)
