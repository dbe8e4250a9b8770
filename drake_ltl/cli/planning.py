"""Planning for a command: within its time limit, and with a progress line on a terminal."""

from __future__ import annotations

import argparse
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console

from drake_ltl.cli.guard import at_the_latest
from drake_ltl.cli.outcome import json_text, working
from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.fits import Fits
from drake_ltl.planning.methods import Method, plan_by
from drake_ltl.planning.plan import Plan, State
from drake_ltl.planning.plan_json import no_plan_json
from drake_ltl.scenario.model import Scenario

OVERTIME = 0.25
"""Share of the time limit that the bounded method may take beyond it, to end a solver's step and to check its plan."""


def planned(args: argparse.Namespace, scenario: Scenario, start: State, fits: Fits) -> tuple[Plan, Method]:
    """The plan, and the method that found it.

    Raises:
        TimeoutError: the time limit is over. The bounded method minds it by itself, and is left some time more to
            come to its end with what it has found.
    """
    limit, began = args.time_limit, time.monotonic()
    complaint = f"the time limit of {limit:g} s is over" if limit else ""
    last = {"path": args.json, "text": json_text(no_plan_json(scenario, "unknown"))}
    if args.method != "bounded":
        try:
            latest = at_the_latest(limit, f"no plan: {complaint}", **last)
            with latest, time_limit(limit, complaint), working("planning"):
                return plan_by("explicit", scenario, start, fits)
        except SearchLimitError:
            if args.method == "explicit":
                raise
    left = remaining(limit, began)
    latest = left and left + OVERTIME * limit + 1.0
    with at_the_latest(latest, f"no plan: {complaint}", **last), time_limit(latest, complaint), _standing() as report:
        return plan_by("bounded", scenario, start, fits, time_limit=left, report=report)


def remaining(limit: float | None, began: float) -> float | None:
    """What is left of a time limit [s]; None if there is none."""
    return None if limit is None else max(0.01, limit - (time.monotonic() - began))


@contextmanager
def _standing() -> Iterator[Callable[[Any], None] | None]:
    """Shows incumbent, bound and gap of a long search on a terminal."""
    screen = Console(stderr=True)
    if not screen.is_terminal:
        yield None
        return
    with screen.status("planning") as status:

        def report(progress: Any) -> None:
            cost = "none yet" if progress.cost is None else f"{progress.cost:g}"
            gap = "" if progress.gap is None else f", gap {progress.gap:.1%}"
            status.update(f"planning, {progress.seconds:.0f} s: best {cost}, bound {progress.lower_bound:g}{gap}")

        yield report


@contextmanager
def time_limit(seconds: float | None, complaint: str = "time is over") -> Iterator[None]:
    """Raises TimeoutError in the body after so many seconds; None: never."""

    def stop(signum: int, frame: object) -> None:
        raise TimeoutError(complaint)

    if seconds is None:
        yield
        return
    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
