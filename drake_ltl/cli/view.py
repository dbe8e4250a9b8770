"""`drake-ltl view RECORDING`: watch a recorded run, in Meshcat or as a page."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from drake_ltl.cli.arguments import HOST_HELP, file_path, host
from drake_ltl.cli.guard import save_when_interrupted
from drake_ltl.cli.outcome import check_writable, complain, say_written, silence_matplotlib, working, write_json
from drake_ltl.cli.statuses import SUCCESS
from drake_ltl.errors import InvalidInputError, Mistake

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat

    from drake_ltl.execution.recording import Recording
    from drake_ltl.multibody.measure import MeasuredModels
    from drake_ltl.planning.geometry import Geometry
    from drake_ltl.scenario.model import Scenario
    from drake_ltl.visualization.page_data import PageData

REPORT = ("report.html", "verdict.json")
"""Files in the folder of `--report`, beside its figures."""


def add_parser(commands: argparse._SubParsersAction) -> None:
    """Adds the command to the parser."""
    parser = commands.add_parser(
        "view",
        help="watch a recording",
        description="Replays a recording in a browser until Ctrl-C, or writes it as a page that needs no network, as a "
        "report with figures, or both. Models that the scenario names by relative paths are looked for from the "
        "working folder.",
        epilog="example: drake-ltl view out/recording.npz --record page.html --report out",
    )
    parser.add_argument("recording", type=file_path, metavar="RECORDING", help="a file (.npz) written by `simulate`")
    parser.add_argument(
        "--record", type=file_path, metavar="OUT.html", help="write a page that replays the run, instead of showing it"
    )
    parser.add_argument(
        "--report", type=file_path, metavar="DIR", help="write report.html and its figures here, instead of showing it"
    )
    parser.add_argument("--meshcat-host", type=host, metavar="HOST", help=HOST_HELP)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Writes what is asked for, or shows the run until it is interrupted."""
    _check_shown(args)
    check_writable(args.record, source=args.recording, folder=args.report, inside=REPORT)
    silence_matplotlib()
    from drake_ltl.execution.recording import Recording
    from drake_ltl.scenario import loads

    recorded = Recording.load(args.recording)
    scenario = loads(recorded.scenario, source_name=str(args.recording))

    from drake_ltl.verification.data import finite_part  # what judges takes a while to load

    recording = finite_part(recorded)
    if not len(recording.time):
        raise InvalidInputError([Mistake(str(args.recording), "the run ended before its first sample", "run it again")])
    with working("loading the models"):
        from drake_ltl.multibody import MeasureGeometry  # Drake takes a while to load

        models = MeasureGeometry(scenario)
    if args.report is not None:
        _report(recorded, scenario, models.geometry, args.report)
    if args.record is not None:
        from drake_ltl.visualization.recorded_page import WritePage

        meshcat, data = _replayed(recording, scenario, models)
        WritePage(meshcat, args.record, data)
        say_written(args.record)
    if args.record is None and args.report is None:
        _show(recording, scenario, models, args.meshcat_host or "localhost")
    return SUCCESS


def _check_shown(args: argparse.Namespace) -> None:
    if args.meshcat_host is not None and (args.record, args.report) != (None, None):
        remedy = "leave out --record and --report, and the run is shown"
        raise InvalidInputError([Mistake("--meshcat-host", "has nothing to show", remedy)])


def _report(recording: Recording, scenario: Scenario, geometry: Geometry, folder: Path) -> None:
    from drake_ltl.verification import to_json, verify
    from drake_ltl.visualization.report import write_report

    with working("judging the run"):
        verdict = verify(recording, scenario)
    with working("drawing the report"):
        page, *_ = write_report(folder, recording, scenario, verdict, geometry=geometry)
        write_json(folder / "verdict.json", to_json(verdict))
    say_written(page)


def _replayed(recording: Recording, scenario: Scenario, models: MeasuredModels) -> tuple[Meshcat, PageData]:
    """The scene with all frames, and what the page says beside it."""
    from drake_ltl.visualization.meshcat_scene import MakeMeshcat
    from drake_ltl.visualization.page_data import recorded_page_data
    from drake_ltl.visualization.recorded_page import StartPage
    from drake_ltl.visualization.replay import PublishReplay

    meshcat = MakeMeshcat()
    StartPage(meshcat)
    with _progress() as report:
        PublishReplay(recording, scenario, models, meshcat, report=report)
    return meshcat, recorded_page_data(recording, scenario)


def _show(recording: Recording, scenario: Scenario, models: MeasuredModels, address: str) -> None:
    from drake_ltl.visualization.page_server import PageServer
    from drake_ltl.visualization.recorded_page import MakePage

    page = MakePage(*_replayed(recording, scenario, models))
    server = PageServer({"/": lambda _: page}, host=address)
    complain(f"watch at {server.url} (Ctrl-C ends)")
    _wait()


def _wait() -> None:
    """Until Ctrl-C, which is how a viewer is meant to end."""
    save_when_interrupted()
    try:
        while True:
            time.sleep(3600)
    except KeyboardInterrupt:
        return


@contextmanager
def _progress() -> Iterator[Callable[[float], None]]:
    """Tells a terminal how far the frames are; nothing in a pipe."""
    screen = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=screen, transient=True, disable=not screen.is_terminal) as bar:
        task = bar.add_task("replaying", total=1.0)
        yield lambda share: bar.update(task, completed=share)
