"""`drake-ltl verify RECORDING`: judge a recording by itself."""

from __future__ import annotations

import argparse

from drake_ltl.cli.arguments import file_path
from drake_ltl.cli.outcome import check_writable, console, working, write_json
from drake_ltl.cli.statuses import FAILURE, SUCCESS


def add_parser(commands: argparse._SubParsersAction) -> None:
    """Adds the command to the parser."""
    parser = commands.add_parser(
        "verify",
        help="judge a recording",
        description="Judges a recording by itself: temporal logic, regions, clearances, grasps, V, rest. "
        "Exit status: 0 satisfied, 1 violated, 2 bad input. Models that the scenario names by relative paths are "
        "looked for from the working folder.",
        epilog="example: drake-ltl verify out/recording.npz",
    )
    parser.add_argument("recording", type=file_path, metavar="RECORDING", help="a file (.npz) written by `simulate`")
    parser.add_argument("--json", type=file_path, metavar="OUT", help="write the verdict, as `simulate` does")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """0 if the recording satisfies its scenario, else 1."""
    check_writable(args.json, source=args.recording)

    # Other commands are known by the same parser and need none of this.
    from drake_ltl.execution.recording import Recording
    from drake_ltl.scenario import loads

    recording = Recording.load(args.recording)
    scenario = loads(recording.scenario, source_name=str(args.recording))

    # What judges takes a while to load: only now is it sure to be needed.
    from drake_ltl.verification import to_json, verdict_table, verify

    with working("judging the run"):
        verdict = verify(recording, scenario)
    console().print(verdict_table(verdict, scenario))
    write_json(args.json, to_json(verdict))
    return SUCCESS if verdict.satisfied else FAILURE
