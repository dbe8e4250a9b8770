"""`drake-ltl plan FILE`: the least-cost plan of a scenario, as a table and as JSON."""

from __future__ import annotations

import argparse
import math
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from rich.console import Console

from drake_ltl.api import planning_geometry, planning_problem
from drake_ltl.cli.guard import at_the_latest
from drake_ltl.cli.infeasibility import explain
from drake_ltl.cli.outcome import check_writable, complain, console, file_path, json_text, write_json
from drake_ltl.cli.statuses import FAILURE, SUCCESS
from drake_ltl.errors import InfeasibleError, SearchLimitError
from drake_ltl.planning.fits import Fits
from drake_ltl.planning.methods import Method, plan_by
from drake_ltl.planning.plan import Plan, State
from drake_ltl.planning.plan_json import no_plan_json, plan_to_json
from drake_ltl.planning.table import plan_table
from drake_ltl.scenario import load
from drake_ltl.scenario.model import Scenario

OVERTIME = 0.25
"""Share of the time limit that the bounded method may take beyond it, to end a solver's step and to check its plan."""

OUTPUTS = ("plan.json", "plan.txt", "plan.dot", "projections.json", "automaton.hoa")
"""Files in the folder of `--outputs`."""

PLAN_TIME_HELP = "give up after S seconds of planning"


def add_parser(commands: argparse._SubParsersAction) -> None:
    """Adds the command to the parser."""
    parser = commands.add_parser(
        "plan",
        help="find the least-cost plan",
        description="Finds the plan of least cost that satisfies every formula, and proves it least.",
        epilog="example: drake-ltl plan examples/case_ii.yaml --json plan.json",
    )
    parser.add_argument("file", type=file_path, metavar="FILE", help="scenario (YAML)")
    parser.add_argument("--json", type=file_path, metavar="OUT", help="write the plan here")
    parser.add_argument(
        "--method",
        choices=("auto", "explicit", "bounded"),
        default="auto",
        help="explicit: enumerate the transition system; bounded: lassos of growing length, for large teams; "
        "auto: explicit unless too large (default)",
    )
    parser.add_argument("--time-limit", type=seconds, metavar="S", help=PLAN_TIME_HELP)
    parser.add_argument(
        "--outputs",
        type=file_path,
        metavar="DIR",
        help="write plan and projections (JSON), table, lasso (DOT) and automaton (HOA) here",
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Plans; 0 if there is a plan, 1 if there is none."""
    check_writable(args.json, source=args.file, folder=args.outputs, inside=OUTPUTS)
    scenario = load(args.file)
    geometry = planning_geometry(scenario)
    start, fits = planning_problem(scenario, geometry)
    began = time.monotonic()
    try:
        found, method = planned(args, scenario, start, fits)
    except InfeasibleError as error:
        complain(f"infeasible: {error}")
        write_json(args.json, no_plan_json(scenario, "infeasible"))
        left = _left(args.time_limit, began)
        with suppress(TimeoutError), at_the_latest(left, complaint=""), _time_limit(left):
            explain(scenario, start, fits, time_limit=left)
        return FAILURE
    except (SearchLimitError, TimeoutError) as error:
        complain(f"no plan: {error}")
        write_json(args.json, no_plan_json(scenario, "unknown"))
        return FAILURE
    out = console()
    out.print(plan_table(found, scenario))
    out.print(
        "not checked: whether the bodies find places in the regions (`simulate` does)", style="dim", highlight=False
    )
    if args.method == "auto" and method == "bounded":
        out.print("too large to enumerate: planned by the bounded method")
    write_json(args.json, plan_to_json(found, scenario))
    if args.outputs is not None:
        from drake_ltl.planning.outputs import write_outputs  # rarely asked for

        write_outputs(found, scenario, args.outputs)
    return SUCCESS


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
            with at_the_latest(limit, f"no plan: {complaint}", **last), _time_limit(limit, complaint):
                return plan_by("explicit", scenario, start, fits)
        except SearchLimitError:
            if args.method == "explicit":
                raise
    left = _left(limit, began)
    latest = left and left + OVERTIME * limit + 1.0
    with at_the_latest(latest, f"no plan: {complaint}", **last), _time_limit(latest, complaint), _standing() as report:
        return plan_by("bounded", scenario, start, fits, time_limit=left, report=report)


def _left(limit: float | None, began: float) -> float | None:
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


def seconds(text: str) -> float:
    """The type of an argument that is a time [s]."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < 1e9:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of seconds above 0")
    return value


@contextmanager
def _time_limit(seconds: float | None, complaint: str = "time is over") -> Iterator[None]:
    """Raises TimeoutError in the body after so many seconds."""

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
