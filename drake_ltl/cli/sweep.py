"""`drake-ltl sweep FILE`: many runs with drawn starts and disturbances, and what they show together."""

from __future__ import annotations

import argparse
import functools
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from drake_ltl.cli.arguments import SCENARIO_HELP, SUFFIX_ROUNDS, file_path, number, scenario_path, whole
from drake_ltl.cli.guard import save_when_interrupted
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
    ExecutionError,
    InfeasibleError,
    InvalidInputError,
    Mistake,
    SearchLimitError,
    naming_file,
)

if TYPE_CHECKING:
    from drake_ltl.multibody import MeasuredModels
    from drake_ltl.scenario.model import Scenario
    from drake_ltl.sweep.journal import Journal
    from drake_ltl.sweep.outcome import Outcome
    from drake_ltl.sweep.sweep import Sweep

PER_CENT = number(0.0, 90.0, "number of per cent")
MOST_RUNS = 1_000_000
MOST_JOBS = 256
MOST_ON_CLUSTER = 2000
"""Runs that a cluster is given at a time."""
SUMMARY = "summary.json"
PICTURE = "summary.png"


def add_parser(commands: argparse._SubParsersAction) -> None:
    """Adds the command to the parser."""
    parser = commands.add_parser(
        "sweep",
        help="simulate many times with drawn starts and disturbances",
        description="Draws starts, gains of the controllers and masses of the objects, plans, simulates and verifies "
        "each run, and shows success, clearances and durations with intervals of confidence: exit status 0 only if "
        "all runs are satisfied. The same command goes on with a sweep that was interrupted.",
        epilog="example: drake-ltl sweep case_ii --runs 100 --seed 7 --jobs 4",
    )
    parser.add_argument("file", type=scenario_path, metavar="FILE", help=SCENARIO_HELP)
    parser.add_argument("--runs", type=whole(1, MOST_RUNS), metavar="N", help="how many runs")
    parser.add_argument("--seed", type=whole(0, 2**63 - 1), default=0, metavar="S", help="of all draws (default: 0)")
    who = parser.add_mutually_exclusive_group()
    who.add_argument("--jobs", type=whole(1, MOST_JOBS), metavar="J", help="processes (default: one for each core)")
    who.add_argument("--dask", metavar="ADDRESS", help="of a dask scheduler, such as tcp://host:8786")
    who.add_argument("--only", type=whole(0, MOST_RUNS), metavar="K", help="nothing but run K, with its recording")
    parser.add_argument("--gains", type=PER_CENT, metavar="P", help="largest change of gains in per cent (default: 5)")
    parser.add_argument(
        "--masses", type=PER_CENT, metavar="P", help="largest change of objects' masses in per cent (default: 1)"
    )
    parser.add_argument("--suffix-rounds", type=SUFFIX_ROUNDS, metavar="N", help="rounds of the plan's loop")
    parser.add_argument("--output", type=file_path, metavar="DIR", help="folder of all results (default: sweep_NAME)")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """0 if all runs are satisfied, else 1."""
    from drake_ltl.scenario import load

    if (args.runs is None) is (args.only is None):
        remedy = "write either `--runs N` or `--only K`"
        raise InvalidInputError([Mistake("sweep", "it is not clear which runs are meant", remedy)])
    scenario = load(args.file)

    models = measured_models(scenario)

    from drake_ltl.sweep.journal import NAME  # what sweeps takes a while to load

    folder = args.output or Path(f"sweep_{args.file.stem}")
    check_writable(source=args.file, folder=folder, inside=(NAME, SUMMARY, PICTURE))
    silence_matplotlib()
    try:
        with working("planning"):
            sweep = _prepare(args, scenario, models)
    except (InfeasibleError, SearchLimitError) as error:
        complain(f"no plan: {error}")
        return FAILURE
    return _run_only(sweep, args.only, folder) if args.runs is None else _run_all(sweep, args, folder)


def _prepare(args: argparse.Namespace, scenario: Scenario, models: MeasuredModels) -> Sweep:
    from drake_ltl import mission
    from drake_ltl.sweep.sweep import GAINS, MASSES, Sweep

    rounds = scenario.simulation.suffix_rounds if args.suffix_rounds is None else args.suffix_rounds
    return Sweep(
        scenario=scenario,
        geometry=models.geometry,
        plan=mission.plan_and_place(scenario, models).plan,
        seed=args.seed,
        gains=GAINS if args.gains is None else args.gains,
        masses=MASSES if args.masses is None else args.masses,
        suffix_rounds=rounds,
    )


def _run_all(sweep: Sweep, args: argparse.Namespace, folder: Path) -> int:
    from drake_ltl.sweep.collect import collect
    from drake_ltl.sweep.journal import Journal, header_of
    from drake_ltl.sweep.one_run import run_one

    with Journal(folder, header_of(sweep)) as journal:
        missing = [number for number in range(args.runs) if number not in journal.outcomes]
        status, jobs = None, args.jobs or len(os.sched_getaffinity(0))
        save_when_interrupted()
        try:
            if missing:
                with _executor(args.dask, min(jobs, len(missing))) as executor, _progress(args, journal) as advance:

                    def keep(outcome: Outcome) -> None:
                        journal.add(outcome)
                        advance()

                    width = MOST_ON_CLUSTER if args.dask else jobs
                    collect(missing, functools.partial(run_one, sweep), executor, keep, width=width)
        except KeyboardInterrupt:
            complain("interrupted; the same command goes on from here")
            status = INTERRUPTED
        except ExecutionError as error:
            complain(f"{error}; the same command goes on from here")
            status = FAILURE
        unsatisfied = _report(sweep, args.runs, journal, folder)
    return (FAILURE if unsatisfied else SUCCESS) if status is None else status


@contextmanager
def _executor(address: str | None, jobs: int) -> Iterator[Executor]:
    if address is not None:
        from drake_ltl.sweep.cluster import cluster

        with cluster(address) as executor:
            yield executor
        return
    from drake_ltl.sweep.processes import SteadyProcesses

    with SteadyProcesses(jobs) as executor:
        yield executor


@contextmanager
def _progress(args: argparse.Namespace, journal: Journal) -> Iterator[Callable[[], None]]:
    """A bar on a terminal; nothing in a pipe."""
    from drake_ltl.sweep.outcome import SATISFIED

    screen = Console(stderr=True)
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[bad]}"),
        console=screen,
        transient=True,
        disable=not screen.is_terminal,
    ) as bar:
        task = bar.add_task("sweeping", total=args.runs, bad="")

        def advance() -> None:
            ours = [outcome for outcome in journal.outcomes.values() if outcome.run < args.runs]
            bad = sum(outcome.status != SATISFIED for outcome in ours)
            bar.update(task, completed=len(ours), bad=f"{bad} not satisfied" if bad else "")

        advance()
        yield advance


def _report(sweep: Sweep, runs: int, journal: Journal, folder: Path) -> int:
    """Writes what is known; returns how many runs are not satisfied, or not done."""
    from drake_ltl.sweep.drawing import write_drawn
    from drake_ltl.sweep.figure import write_summary_figure
    from drake_ltl.sweep.journal import header_of
    from drake_ltl.sweep.statistics import summarize
    from drake_ltl.sweep.table import summary_table, summary_to_json

    summary = summarize(outcome for outcome in journal.outcomes.values() if outcome.run < runs)
    write_json(folder / SUMMARY, summary_to_json(summary, header_of(sweep), runs))
    write_summary_figure(summary, sweep.scenario, folder / PICTURE)
    for outcome in summary.unsatisfied:
        if outcome.drawn is not None:
            path = folder / f"run_{outcome.run}.yaml"
            heading = f"run {outcome.run} of seed {sweep.seed}, {outcome.status}: {outcome.reason}"
            with naming_file(path):
                write_drawn(sweep.scenario, outcome.drawn, path, heading)
    out = console()
    out.print(summary_table(summary, sweep.scenario.name, runs))
    say_written(folder)
    return len(summary.unsatisfied) + runs - len(summary.outcomes)


def _run_only(sweep: Sweep, number: int, folder: Path) -> int:
    """One run as `simulate` does it; the journal is left alone."""
    from drake_ltl.sweep.drawing import write_drawn
    from drake_ltl.sweep.one_run import carry_out
    from drake_ltl.sweep.outcome import SATISFIED
    from drake_ltl.verification import verdict_table

    save_when_interrupted()
    with working(f"run {number}"):
        result = carry_out(sweep, number)
    outcome = result.outcome
    folder.mkdir(parents=True, exist_ok=True)
    heading = f"run {number} of seed {sweep.seed}, {outcome.status}: {outcome.reason or 'nothing to complain of'}"
    with naming_file(folder):
        write_drawn(sweep.scenario, outcome.drawn, folder / f"run_{number}.yaml", heading)
        if result.run is not None:
            result.run.recording.save(folder / f"run_{number}.npz")
    out = console()
    if result.verdict is None:
        complain(f"{outcome.status}: {outcome.reason}")
    else:
        out.print(verdict_table(result.verdict, result.scenario))
    say_written(folder)
    if result.run is not None and result.run.interrupted:
        complain("interrupted")
        return INTERRUPTED
    return SUCCESS if outcome.status == SATISFIED else FAILURE
