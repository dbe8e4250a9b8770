"""Whether it matters to a formula how often a letter is repeated, that is, how many steps something takes."""

from __future__ import annotations

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.demands import Demand, demands
from drake_ltl.scenario.model import Scenario
from drake_ltl.spot_questions import ask
from drake_ltl.spot_support import require_spot

STUTTER_TIME = 5.0
"""For one formula; one that takes longer has an X in it, and is taken to be sensitive [s]."""


def is_stutter_sensitive(formula: str) -> bool:
    """Whether repeating letters of some word, or leaving out repetitions, changes if the word satisfies the formula.

    Formulas without X never are; those with X mostly are. Decided by Spot for the language, not for the text:
    `F(pi1 & X pi1) | F pi1` is not.
    """
    try:
        return ask(_is_stutter_sensitive, formula, seconds=STUTTER_TIME)
    except (TimeoutError, SearchLimitError):
        return True


def _is_stutter_sensitive(formula: str) -> bool:
    spot = require_spot()
    return not spot.is_stutter_invariant(spot.formula(formula))


def stutter_sensitive_demands(scenario: Scenario) -> tuple[Demand, ...]:
    """The parts of the scenario's formulas that count plan steps."""
    return tuple(demand for demand in demands(scenario) if is_stutter_sensitive(demand.formula))


def stutter_note(scenario: Scenario) -> str | None:
    """A line for people who read a plan, or None if no part of the formulas counts steps."""
    sensitive = stutter_sensitive_demands(scenario)
    if not sensitive:
        return None
    if len(sensitive) == 1:
        return f"{sensitive[0]} counts plan steps"
    return f"{sensitive[0]} and {len(sensitive) - 1} more count plan steps"
