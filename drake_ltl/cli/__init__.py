"""The command `drake-ltl`, with a module for each of its commands."""

from __future__ import annotations

import os
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence

# Everything else is loaded by the functions below: until `entry_point` is called nobody handles Ctrl-C.


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command in this process and returns its exit status.

    0: satisfied, or a plan was found; 1: violated or infeasible; 2: bad input, one line per mistake on stderr;
    130: interrupted.

    Raises:
        SystemExit: argparse ends a command line that asks for help, or is wrong.
    """
    from drake_ltl.cli.outcome import colours, complain
    from drake_ltl.cli.statuses import BAD_INPUT, INTERRUPTED
    from drake_ltl.errors import DrakeLtlError, InvalidInputError
    from drake_ltl.scenario.model_access import allow_models

    try:
        args = make_parser().parse_args(arguments)
        with colours(not args.no_color), allow_models(*getattr(args, "allow_models", ())):
            return args.run(args)
    except InvalidInputError as error:
        complain(str(error))
        return BAD_INPUT
    except (DrakeLtlError, OSError) as error:
        complain(_one_line(error))
        return BAD_INPUT
    except SystemExit as done:
        if done.code is None or isinstance(done.code, int):
            raise  # argparse, after help or a mistake
        complain(str(done.code).strip().partition("\n")[0] or "ended without a result")
        return BAD_INPUT  # Drake's failed conditions end the process with a text
    except KeyboardInterrupt:
        complain("interrupted")
        return INTERRUPTED


def entry_point() -> None:
    """What the installed script calls."""
    try:
        _open_closed_streams()
        _print_anything()
        from drake_ltl.cli.guard import guarded

        status = guarded(_run_and_flush)
    except KeyboardInterrupt:
        os.write(2, b"interrupted\n")
        status = 130
    sys.exit(status)


def _run_and_flush() -> int:
    """The command in its own process, up to the last byte that it writes."""
    import signal

    from drake_ltl.cli.outcome import complain, naming_stdout, silence
    from drake_ltl.cli.statuses import BAD_INPUT, SUCCESS

    try:
        status = main()
    except SystemExit as done:  # argparse, after help or a mistake
        status = SUCCESS if done.code is None else int(done.code)
    signal.signal(signal.SIGUSR1, signal.SIG_IGN)  # nothing is left to save
    try:
        with naming_stdout():
            sys.stdout.flush()
    except BrokenPipeError:
        silence(sys.stdout)
    except OSError as error:
        complain(_one_line(error))
        return BAD_INPUT
    return status


def _open_closed_streams() -> None:
    """Where a standard stream is closed (`>&-`), the next file opened would take its place and get what is printed."""
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        if getattr(sys, name) is None:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free: this one
            setattr(sys, name, open(number, mode, encoding="utf-8"))  # noqa: SIM115


def _print_anything() -> None:
    """Letters that a stream's encoding lacks never stop a command: others of the same width stand in for them."""
    import codecs

    codecs.register_error("stand in", _stand_in)
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="stand in")


def _stand_in(error: UnicodeError) -> tuple[str, int]:
    letters = error.object[error.start : error.end]
    return "".join(_STAND_INS.get(letter, "?") for letter in letters), error.end


_STAND_INS = {"\N{NO-BREAK SPACE}": " ", "\N{RIGHTWARDS ARROW}": ">"}


def _one_line(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    return " ".join(str(error).split())


def make_parser() -> argparse.ArgumentParser:
    """The parser of the whole command line; `run` of what it returns carries the command out."""
    import argparse

    import drake_ltl
    from drake_ltl.cli import check, completion, draw, explain, new, plan, simulate, sweep, verify, view

    parser = argparse.ArgumentParser(
        prog="drake-ltl",
        description="Plans, simulates and verifies missions of robots and objects given in linear temporal logic.",
        epilog="example: drake-ltl new errand.yaml && drake-ltl simulate errand.yaml",
    )
    parser.add_argument("--version", action="version", version=f"%(prog)s {drake_ltl.__version__}")
    parser.add_argument("--no-color", action="store_true", help=_NO_COLOR)
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for command in (new, check, draw, explain, plan, simulate, sweep, verify, view, completion):
        command.add_parser(commands)
    for name, command in commands.choices.items():
        if name not in ("new", "completion"):
            command.add_argument("--allow-models", action="append", default=[], metavar="DIR", help=_ALLOW_MODELS)
        # Suppressed: what stands before the command would be overruled by a default.
        command.add_argument("--no-color", action="store_true", default=argparse.SUPPRESS, help=_NO_COLOR)
    return parser


_ALLOW_MODELS = "folder outside the scenario's own that its models may come from; may be repeated"
_NO_COLOR = "no colours nor styles, as where NO_COLOR is set"
