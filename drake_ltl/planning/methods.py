"""The two ways to plan, and the choice between them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, get_args

from drake_ltl.errors import InvalidInputError, Mistake, SearchLimitError
from drake_ltl.planning.fits import Fits
from drake_ltl.planning.plan import Plan, State
from drake_ltl.planning.planner import plan
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.table import shown

Method = Literal["auto", "explicit", "bounded"]

BOUNDED_TIME = 60.0
"""Time for the bounded method where no limit is given [s]: it improves for as long as it may."""


def plan_by(
    method: Method,
    scenario: Scenario,
    start: State,
    fits: Fits,
    *,
    time_limit: float | None = None,
    report: Callable[[Any], None] | None = None,
) -> tuple[Plan, Method]:
    """A plan, and the method that found it.

    Args:
        method: `explicit` looks at the whole transition system, listed or factored, and proves its plan least;
            `bounded` searches lassos of growing length and bounds what any could cost; `auto` takes the first unless
            the problem is too large.
        time_limit: for the bounded method [s]; None takes BOUNDED_TIME.
        report: called by the bounded method with each better plan and bound (`bounded.Progress`).

    Raises:
        InvalidInputError: there is no such method.
        InfeasibleError: there is no plan.
        SearchLimitError: the problem is too large for the explicit method, or the time was too short.
    """
    if method not in get_args(Method):
        remedy = f"take one of {', '.join(get_args(Method))}"
        raise InvalidInputError([Mistake("method", f"there is no method {shown(method)}", remedy)])
    if method != "bounded":
        try:
            return plan(scenario, start, fits), "explicit"
        except SearchLimitError:
            if method == "explicit":
                raise
    from drake_ltl.planning.bounded import plan_bounded  # loading the solver takes longer than most plans

    limit = BOUNDED_TIME if time_limit is None else time_limit
    return plan_bounded(scenario, start, fits, time_limit=limit, report=report), "bounded"
