"""`drake-ltl simulate FILE`: plan, carry out in Drake's Simulator, judge the recording."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Column

from drake_ltl.cli.arguments import HOST_HELP, SCENARIO_HELP, SUFFIX_ROUNDS, file_path, host, number, scenario_path
from drake_ltl.cli.guard import save_when_interrupted
from drake_ltl.cli.infeasibility import explain
from drake_ltl.cli.outcome import (
    check_writable,
    complain,
    console,
    say_written,
    silence_matplotlib,
    working,
    write_json,
)
from drake_ltl.cli.starting import measured_models
from drake_ltl.cli.statuses import FAILURE, INTERRUPTED, SUCCESS
from drake_ltl.errors import (
    InfeasibleError,
    InvalidInputError,
    Mistake,
    NoPlacesError,
    SearchLimitError,
    naming_file,
)

if TYPE_CHECKING:
    from drake_ltl.execution.recording import Recording

REPORT = ("recording.npz", "verdict.json", "plan.json", "report.html")
"""Files in the folder of `--report`, beside its figures."""


def add_parser(commands: argparse._SubParsersAction) -> None:
    """Adds the command to the parser."""
    parser = commands.add_parser(
        "simulate",
        help="plan, carry out and verify",
        description="Plans a scenario, carries the plan out in a multibody simulation and judges the recording: "
        "exit status 0 only if the specification held and nothing collided.",
        epilog="example: drake-ltl simulate case_ii --report out --record page.html",
    )
    parser.add_argument("file", type=scenario_path, metavar="FILE", help=SCENARIO_HELP)
    parser.add_argument(
        "--suffix-rounds", type=SUFFIX_ROUNDS, metavar="N", help="rounds of the plan's loop (default: 1)"
    )
    parser.add_argument("--keep-going", action="store_true", help="go on when a monitor sees something wrong")
    parser.add_argument("--meshcat", action="store_true", help="show the run live in a browser (localhost)")
    parser.add_argument("--meshcat-host", type=host, metavar="HOST", help=f"for --meshcat: {HOST_HELP}")
    parser.add_argument("--realtime-rate", type=number(0.0, 1000.0, "rate"), metavar="R", help=_RATE_HELP)
    parser.add_argument("--record", type=file_path, metavar="OUT.html", help="write a page that replays the run")
    parser.add_argument("--recording", type=file_path, metavar="OUT.npz", help="write the data of the run")
    parser.add_argument("--json", type=file_path, metavar="OUT", help="write the verdict")
    parser.add_argument("--report", type=file_path, metavar="DIR", help="write report.html, its figures and data here")
    parser.add_argument("--graphviz", type=file_path, metavar="OUT", help="write the diagram of systems (.dot or .svg)")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """0 if the mission was carried out and satisfies everything, else 1."""
    _check_live(args)
    outputs = (args.json, args.record, args.graphviz)
    check_writable(*outputs, source=args.file, replaced=args.recording, folder=args.report, inside=REPORT)
    silence_matplotlib()

    from drake_ltl.scenario import load

    scenario = load(args.file)

    models = measured_models(scenario)

    # What plans and simulates takes a while to load: only now is it sure to be needed.
    from drake_ltl import mission
    from drake_ltl.api import planning_problem
    from drake_ltl.planning.plan_json import plan_to_json
    from drake_ltl.planning.table import plan_table
    from drake_ltl.verification import to_json, verdict_table, verify

    out = console()
    try:
        with working("planning"):
            planned = mission.plan_and_place(scenario, models)
    except (InfeasibleError, SearchLimitError) as error:
        impossible = isinstance(error, InfeasibleError) and not isinstance(error, NoPlacesError)
        complain(f"{'infeasible' if impossible else 'no plan'}: {error}")
        write_json(args.json, _no_run_json(str(error)))
        if impossible:
            explain(scenario, *planning_problem(scenario, models.geometry))
        return FAILURE
    out.print(plan_table(planned.plan, scenario))
    rounds = scenario.simulation.suffix_rounds if args.suffix_rounds is None else args.suffix_rounds
    with _progress() as bar:
        result = mission.simulate(
            planned,
            scenario,
            models,
            suffix_rounds=rounds,
            keep_going=args.keep_going,
            live=args.meshcat,
            meshcat_host=args.meshcat_host or "localhost",
            realtime_rate=1.0 if args.realtime_rate is None else args.realtime_rate,
            page=args.record,
            graphviz=args.graphviz,
            announce=complain,
            report=_reporter(bar),
        )
    for seen in result.recording.monitored:
        complain(f"the {seen.monitor} monitor saw: {seen}")
    unsaved = _unsaved(result.recording, args.recording)
    with working("judging the run"):
        verdict = verify(result.recording, scenario)
    out.print(verdict_table(verdict, scenario))
    data = to_json(verdict, wall_seconds=result.wall_seconds)
    write_json(args.json, data)
    if args.record is not None:
        say_written(args.record)
    if unsaved is not None:
        raise unsaved
    if args.report is not None:
        from drake_ltl.visualization.report import write_report

        args.report.mkdir(parents=True, exist_ok=True)
        _save(result.recording, args.report / "recording.npz")
        write_json(args.report / "verdict.json", data)
        write_json(args.report / "plan.json", plan_to_json(planned.plan, scenario))
        with working("drawing the report"):
            files = write_report(
                args.report, result.recording, scenario, verdict, geometry=models.geometry, plan=planned.plan
            )
        say_written(files[0])
    if result.interrupted:
        complain("interrupted")
        return INTERRUPTED
    return SUCCESS if verdict.satisfied else FAILURE


def _check_live(args: argparse.Namespace) -> None:
    """Raises InvalidInputError for options that mean nothing without a live page."""
    idle = [name for name in ("meshcat_host", "realtime_rate") if not args.meshcat and getattr(args, name) is not None]
    mistakes = [Mistake(f"--{name.replace('_', '-')}", "has nothing to show", "add --meshcat") for name in idle]
    if mistakes:
        raise InvalidInputError(mistakes)


_RATE_HELP = "simulated seconds per second of a --meshcat run, until the page's buttons change it; 0: as many as the "
_RATE_HELP += "computer can (default: 1)"


def _unsaved(recording: Recording, path: Path | None) -> OSError | None:
    """What kept the recording from being saved: that is said after the verdict, which would else be lost as well."""
    try:
        _save(recording, path)
    except OSError as error:
        return error
    return None


def _save(recording: Recording, path: Path | None) -> None:
    if path is not None:
        with naming_file(path):
            recording.save(path)


def _no_run_json(reason: str) -> dict[str, Any]:
    """The contract's keys for a mission that could not begin."""
    nothing = ("word", "steps", "min_clearance", "max_lyapunov_increase", "max_weld_error")
    times = ("simulated_seconds", "wall_seconds", "realtime_factor")
    return {"satisfied": False, "violations": [reason], **dict.fromkeys((*nothing, *times))}


def _progress() -> Progress:
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(bar_width=12),
        TextColumn("{task.fields[step]}"),
        TimeElapsedColumn(),
        TextColumn("{task.fields[waiting]}", table_column=Column(ratio=1, no_wrap=True)),  # all that is left of a line
        expand=True,
        console=Console(stderr=True),
        transient=True,
        disable=not Console(stderr=True).is_terminal,
    )


def _reporter(bar: Progress):
    task = bar.add_task("simulating", total=None, step="", waiting="")

    def report(progress) -> None:
        save_when_interrupted()
        waiting = progress.waiting_for[0] if progress.waiting_for else ""
        text = f"t = {progress.time:.0f} s: {waiting}"
        step = f"step {min(progress.step + 1, progress.num_steps)} of {progress.num_steps}"
        bar.update(task, completed=progress.step, total=progress.num_steps, step=step, waiting=text)

    return report
