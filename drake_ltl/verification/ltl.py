"""Linear temporal logic on a word that repeats for ever, judged by Spot."""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet

from drake_ltl.spot_questions import OPTIONS, ask
from drake_ltl.spot_support import require_spot


def holds(formula: str, prefix: Sequence[AbstractSet[str]], cycle: Sequence[AbstractSet[str]]) -> bool:
    """Whether the word prefix cycle cycle .. satisfies the formula.

    Args:
        formula: LTL over the propositions of the letters.
        prefix: letters, may be empty.
        cycle: at least one letter.

    Raises:
        ValueError: the cycle is empty.
        MissingDependencyError: Spot is not installed.
    """
    if not cycle:
        raise ValueError("a word that goes on for ever repeats at least one letter")
    return ask(_holds, formula, prefix, cycle)


def _holds(formula: str, prefix: Sequence[AbstractSet[str]], cycle: Sequence[AbstractSet[str]]) -> bool:
    spot = require_spot()
    parsed = spot.formula(formula)
    names = sorted(proposition.ap_name() for proposition in spot.atomic_prop_collect(parsed))
    letters = "".join(f"{_literals(letter, names)}; " for letter in prefix)
    repeated = "; ".join(_literals(letter, names) for letter in cycle)
    word = spot.parse_word(f"{letters}cycle{{{repeated}}}").as_automaton()
    return not word.intersects(spot.formula.Not(parsed).translate(xargs=OPTIONS))


def _literals(letter: AbstractSet[str], names: Sequence[str]) -> str:
    return " & ".join(f'"{name}"' if name in letter else f'!"{name}"' for name in names) or "1"
