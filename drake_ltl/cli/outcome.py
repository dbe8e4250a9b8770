"""Exit statuses, and how a command speaks: results to stdout, complaints to stderr, data to files."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

from rich.console import Console

from drake_ltl.errors import InvalidInputError, Mistake

SUCCESS = 0
FAILURE = 1
"""Violated, or infeasible."""
BAD_INPUT = 2
INTERRUPTED = 130

PIPE_WIDTH = 120
"""Columns of a table that is not shown on a terminal."""


def console() -> Console:
    """Where results go."""
    return _Console() if sys.stdout.isatty() else _Console(width=PIPE_WIDTH)


class _Console(Console):
    def on_broken_pipe(self) -> None:
        """The reader of a pipe went away: say nothing more to it, but finish the work (the base class would exit)."""
        self.quiet = True
        silence_stdout()


def silence_stdout() -> None:
    """Whatever is still to be written to stdout is dropped."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def complain(text: str) -> None:
    """One line per mistake, on stderr."""
    print(text, file=sys.stderr)


def check_writable(*paths: Path | None) -> None:
    """Refuses outputs that could not be written, before any long work is done.

    Raises:
        InvalidInputError: a path is a folder, or its folder is not there.
    """
    mistakes = []
    for path in filter(None, paths):
        if path.is_dir():
            mistakes.append(Mistake(str(path), "is a folder", "name a file"))
        elif not path.absolute().parent.is_dir():
            mistakes.append(Mistake(str(path), f"there is no folder {path.parent}", "make it first"))
    if mistakes:
        raise InvalidInputError(mistakes)


def write_json(path: Path | None, data: dict[str, Any]) -> None:
    """Writes the data unless there is no path."""
    if path is not None:
        path.write_text(json.dumps(data, indent=2, allow_nan=False) + "\n", encoding="utf-8")
