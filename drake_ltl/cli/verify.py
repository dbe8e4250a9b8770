"""`drake-ltl verify`: judges a recording."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from rich.console import Console

from drake_ltl.execution.recording import Recording
from drake_ltl.scenario import loads
from drake_ltl.verification import to_json, verdict_table, verify


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand; its namespace carries `run`."""
    parser = subparsers.add_parser(
        "verify",
        help="judge a recording",
        description="Judges a recording by itself: temporal logic, regions, clearances, grasps, V. "
        "Exit status: 0 satisfied, 1 violated, 2 bad input.",
    )
    parser.add_argument("recording", type=Path, metavar="RECORDING", help="a file (.npz) written by `simulate`")
    parser.add_argument("--json", type=Path, metavar="OUT", help="write the verdict as JSON, as `simulate` does")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Prints the verdict; returns the exit status.

    Raises:
        DrakeLtlError: the recording cannot be judged.
        OSError: the JSON cannot be written.
    """
    recording = Recording.load(args.recording)
    scenario = loads(recording.scenario, source_name=str(args.recording))
    verdict = verify(recording, scenario)
    Console().print(verdict_table(verdict, scenario))
    if args.json is not None:
        args.json.write_text(json.dumps(to_json(verdict), indent=2, allow_nan=False) + "\n", encoding="utf-8")
    return 0 if verdict.satisfied else 1
