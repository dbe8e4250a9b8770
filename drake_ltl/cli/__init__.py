"""The command `drake-ltl`: plan, simulate, verify."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import drake_ltl
from drake_ltl.cli import plan, simulate, verify
from drake_ltl.cli.outcome import BAD_INPUT, INTERRUPTED, complain, silence_stdout
from drake_ltl.errors import DrakeLtlError, InvalidInputError


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command and returns its exit status.

    0: satisfied, or a plan was found; 1: violated or infeasible; 2: bad input, one line per mistake on stderr.
    """
    args = _parser().parse_args(arguments)
    try:
        return args.run(args)
    except InvalidInputError as error:
        complain(str(error))
        return BAD_INPUT
    except (DrakeLtlError, OSError) as error:
        complain(_one_line(error))
        return BAD_INPUT
    except KeyboardInterrupt:
        complain("interrupted")
        return INTERRUPTED


def entry_point() -> None:
    """What the installed script calls."""
    status = main()
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        silence_stdout()
    sys.exit(status)


def _one_line(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    return " ".join(str(error).split())


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="drake-ltl",
        description="Plans, simulates and verifies missions of robots and objects given in linear temporal logic.",
    )
    parser.add_argument("--version", action="version", version=f"%(prog)s {drake_ltl.__version__}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for command in (plan, simulate, verify):
        command.add_parser(commands)
    return parser
