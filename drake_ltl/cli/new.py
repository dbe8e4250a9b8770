"""`drake-ltl new [FILE]`: a commented scenario to begin with."""

from __future__ import annotations

import argparse
from pathlib import Path

from drake_ltl.cli.arguments import file_path
from drake_ltl.cli.outcome import console
from drake_ltl.cli.statuses import SUCCESS
from drake_ltl.errors import InvalidInputError, Mistake, naming_file


def add_parser(commands: argparse._SubParsersAction) -> None:
    """Adds the command to the parser."""
    parser = commands.add_parser(
        "new",
        help="write a commented scenario to begin with",
        description="Writes a small scenario in which every line is explained. It can be planned and simulated as it "
        "is. A file that is there already is left alone.",
        epilog="example: drake-ltl new errand.yaml",
    )
    parser.add_argument(
        "file",
        type=file_path,
        nargs="?",
        default=Path("scenario.yaml"),
        metavar="FILE",
        help="name of the new file (default: scenario.yaml)",
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Writes the file.

    Raises:
        InvalidInputError: it is there already.
        OSError: it cannot be written.
    """
    from drake_ltl.scenario.starter import STARTER

    try:
        with naming_file(args.file), open(args.file, "x", encoding="utf-8") as file:
            file.write(STARTER)
    except FileExistsError as error:
        raise InvalidInputError([Mistake(str(args.file), "is there already", "name a new file")]) from error
    out = console()
    out.print(f"wrote {args.file}; now try", highlight=False, markup=False, soft_wrap=True)
    for command in ("draw", "plan", "simulate"):
        out.print(f"  drake-ltl {command} {args.file}", highlight=False, markup=False, soft_wrap=True)
    return SUCCESS
