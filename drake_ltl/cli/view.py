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

from drake_ltl.cli.guard import save_when_interrupted
from drake_ltl.cli.outcome import check_writable, complain, console, file_path
from drake_ltl.cli.statuses import SUCCESS
from drake_ltl.errors import InvalidInputError, Mistake

if TYPE_CHECKING:
    from drake_ltl.execution.recording import Recording
    from drake_ltl.scenario.model import Scenario


def add_parser(commands: argparse._SubParsersAction) -> None:
    """Adds the command to the parser."""
    parser = commands.add_parser(
        "view",
        help="watch a recording",
        description="Replays a recording in a browser until Ctrl-C, or writes it as a page that needs no network. "
        "Models that the scenario names by relative paths are looked for from the working folder.",
        epilog="example: drake-ltl view out/recording.npz --record page.html",
    )
    parser.add_argument("recording", type=file_path, metavar="RECORDING", help="a file (.npz) written by `simulate`")
    parser.add_argument(
        "--record", type=file_path, metavar="OUT.html", help="write a page that replays the run, instead of showing it"
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Writes the page, or shows the run until it is interrupted."""
    check_writable(args.record, source=args.recording)
    from drake_ltl.execution.recording import Recording
    from drake_ltl.scenario import loads
    from drake_ltl.verification.data import finite_part

    recording = finite_part(Recording.load(args.recording))
    if not len(recording.time):
        raise InvalidInputError([Mistake(str(args.recording), "the run ended before its first sample", "run it again")])
    scenario = loads(recording.scenario, source_name=str(args.recording))
    return _replay(recording, scenario, args.record)


def _replay(recording: Recording, scenario: Scenario, path: Path | None) -> int:
    # Drake takes a while to load: only now is it sure to be needed.
    from drake_ltl.multibody import MeasureGeometry
    from drake_ltl.visualization.meshcat_scene import MakeMeshcat
    from drake_ltl.visualization.page_data import recorded_page_data
    from drake_ltl.visualization.page_server import PageServer
    from drake_ltl.visualization.recorded_page import MakePage, StartPage, WritePage
    from drake_ltl.visualization.replay import PublishReplay

    models, meshcat = MeasureGeometry(scenario), MakeMeshcat()
    StartPage(meshcat)
    with _progress() as report:
        PublishReplay(recording, scenario, models, meshcat, report=report)
    data = recorded_page_data(recording, scenario)
    if path is not None:
        WritePage(meshcat, path, data)
        console().print(f"wrote {path}", highlight=False, markup=False, soft_wrap=True)
        return SUCCESS
    page = MakePage(meshcat, data)
    server = PageServer({"/": lambda _: page})
    complain(f"watch at {server.url} (Ctrl-C ends)")
    _wait()
    return SUCCESS


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
