"""Whether an ultimately periodic word satisfies a formula, decided by Spot alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from drake_ltl.planning.plan import State
from drake_ltl.scenario.formulas import labels
from drake_ltl.scenario.model import Scenario
from drake_ltl.spot_questions import OPTIONS, ask
from drake_ltl.spot_support import require_spot

Letter = frozenset[str]
"""The propositions that hold at one position."""


def letter_of(scenario: Scenario, state: State) -> Letter:
    """L(pi_s): the canonical propositions that hold in a state."""
    members = scenario.agent_names + scenario.object_names
    where = zip(members, state.agents + state.objects, strict=True)
    return frozenset().union(*(labels(scenario, member, region) for member, region in where))


def satisfies(formula: str, prefix: Sequence[Letter], cycle: Sequence[Letter]) -> bool:
    """Whether the word prefix cycle cycle .. satisfies a formula.

    Args:
        formula: over the propositions of the letters.
        prefix: may be empty.
        cycle: at least one letter.

    Raises:
        ValueError: the cycle is empty.
    """
    if not cycle:
        raise ValueError("a word repeats at least one letter")
    return ask(_satisfies, formula, prefix, cycle)


def _satisfies(formula: str, prefix: Sequence[Letter], cycle: Sequence[Letter]) -> bool:
    spot = require_spot()
    parsed = spot.formula(formula)
    names = sorted(ap.ap_name() for ap in spot.atomic_prop_collect(parsed))
    text = "; ".join([*(_literals(letter, names) for letter in prefix), ""])
    text += "cycle{" + "; ".join(_literals(letter, names) for letter in cycle) + "}"
    word = spot.parse_word(text).as_automaton()
    conjuncts = list(parsed) if parsed.kind() == spot.op_And else [parsed]  # small automata are soon translated
    return all(_accepted(spot, word, conjunct) for conjunct in conjuncts)


def _accepted(spot: Any, word: Any, formula: Any) -> bool:
    """Whether the one word of an automaton satisfies a formula: whether it does not satisfy the negation, of which
    planning makes no automaton.

    Any automaton will do: to make it smaller takes longer than to read one word.
    """
    return not word.intersects(spot.formula.Not(formula).translate("any", "low", xargs=OPTIONS))


def _literals(letter: Letter, names: Sequence[str]) -> str:
    return " & ".join(f'"{name}"' if name in letter else f'!"{name}"' for name in names) or "1"
