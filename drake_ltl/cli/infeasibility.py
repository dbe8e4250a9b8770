"""Says which formulas and facts clash where there is no plan."""

from __future__ import annotations

from typing import TYPE_CHECKING

from drake_ltl.cli.outcome import complain
from drake_ltl.errors import DrakeLtlError

if TYPE_CHECKING:
    from drake_ltl.planning.fits import Fits
    from drake_ltl.planning.plan import State
    from drake_ltl.scenario.model import Scenario

EXPLANATION_TIME = 10.0
"""For finding out [s]."""


def explain(scenario: Scenario, start: State, fits: Fits, time_limit: float | None = None) -> None:
    """A line for each, as far as they can be found in a short time; nothing if there is a plan after all.

    The time is EXPLANATION_TIME, or `time_limit` if that is less [s].
    """
    from drake_ltl.planning.explanation import explain_infeasible  # rarely needed

    try:
        seconds = min(EXPLANATION_TIME, time_limit or EXPLANATION_TIME)
        explanation = explain_infeasible(scenario, start, fits, time_limit=seconds)
    except (DrakeLtlError, ValueError):
        return
    for line in explanation.lines:
        complain(f"  {line}")
