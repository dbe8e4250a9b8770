"""`drake-ltl plan FILE`: the least-cost plan of a scenario, as a table and as JSON."""

from __future__ import annotations

import argparse
import time
from contextlib import suppress

from drake_ltl.cli.arguments import SCENARIO_HELP, TIME_LIMIT_HELP, file_path, scenario_path, seconds
from drake_ltl.cli.guard import at_the_latest
from drake_ltl.cli.outcome import check_writable, complain, console, write_json
from drake_ltl.cli.starting import measured_geometry
from drake_ltl.cli.statuses import FAILURE, SUCCESS
from drake_ltl.errors import InfeasibleError, SearchLimitError

OUTPUTS = ("plan.json", "plan.txt", "plan.dot", "projections.json", "automaton.hoa")
"""Files in the folder of `--outputs`."""


def add_parser(commands: argparse._SubParsersAction) -> None:
    """Adds the command to the parser."""
    parser = commands.add_parser(
        "plan",
        help="find the least-cost plan",
        description="Finds the plan of least cost that satisfies every formula, and proves it least.",
        epilog="example: drake-ltl plan case_ii --json plan.json",
    )
    parser.add_argument("file", type=scenario_path, metavar="FILE", help=SCENARIO_HELP)
    parser.add_argument("--json", type=file_path, metavar="OUT", help="write the plan here")
    parser.add_argument(
        "--method",
        choices=("auto", "explicit", "bounded"),
        default="auto",
        help="explicit: enumerate the transition system; bounded: lassos of growing length, for large teams; "
        "auto: explicit unless too large (default)",
    )
    parser.add_argument("--time-limit", type=seconds, metavar="S", help=TIME_LIMIT_HELP)
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

    from drake_ltl.scenario import load

    scenario = load(args.file)

    geometry = measured_geometry(scenario)

    # What plans takes a while to load: only now is it sure to be needed.
    from drake_ltl.api import planning_problem
    from drake_ltl.cli import infeasibility, planning
    from drake_ltl.planning.plan_json import no_plan_json, plan_to_json
    from drake_ltl.planning.table import plan_table

    start, fits = planning_problem(scenario, geometry)
    began = time.monotonic()
    try:
        found, method = planning.planned(args, scenario, start, fits)
    except InfeasibleError as error:
        complain(f"infeasible: {error}")
        write_json(args.json, no_plan_json(scenario, "infeasible"))
        left = planning.remaining(args.time_limit, began)
        with suppress(TimeoutError), at_the_latest(left, complaint=""), planning.time_limit(left):
            infeasibility.explain(scenario, start, fits, time_limit=left)
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
