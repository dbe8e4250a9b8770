"""The file of a sweep's outcomes: a line for each, on the disk before the next, so that nothing is lost.

JSON lines: first a header with all that outcomes depend on, then an outcome in each line, in the order in which runs
ended. A last line that was cut off is dropped, and its run done again.
"""

from __future__ import annotations

import fcntl
import importlib.metadata
import json
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO

import drake_ltl
from drake_ltl.errors import InvalidInputError, Mistake, naming_file
from drake_ltl.sweep.outcome import Outcome, outcome_from_json, outcome_to_json
from drake_ltl.sweep.sweep import Sweep

NAME = "runs.jsonl"
FORMAT = "drake_ltl sweep"
VERSION = 1
LIBRARIES = ("drake", "numpy", "scipy", "ortools", "spottl")
"""Whose versions may change an outcome."""
_ANEW = "name another folder with `--output`"
_WORDS = {
    "scenario": "of another scenario",
    "seed": "of another seed",
    "gains": "with other changes of gains",
    "masses": "with other changes of masses",
    "suffix_rounds": "of other rounds",
    "versions": "by other versions of drake_ltl or its libraries",
}


def header_of(sweep: Sweep) -> dict[str, Any]:
    """All that outcomes depend on."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "scenario": sweep.scenario.source,
        "seed": sweep.seed,
        "gains": sweep.gains,
        "masses": sweep.masses,
        "suffix_rounds": sweep.suffix_rounds,
        "versions": versions(),
    }


def versions() -> dict[str, str]:
    """Of this library and of those in which outcomes have their numbers."""
    found = {"drake_ltl": drake_ltl.__version__}
    for name in LIBRARIES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:  # Spot, where it comes from conda-forge
            found[name] = "unknown"
    return found


class Journal:
    """An open journal; close it, or use it as a context manager."""

    def __init__(self, folder: Path, header: Mapping[str, Any]):
        """Opens or begins the journal in a folder, which is made if it is not there.

        Raises:
            InvalidInputError: the file is no journal, that of a sweep with another header, damaged, or in use.
            OSError: it cannot be written.
        """
        folder.mkdir(parents=True, exist_ok=True)
        self.path = folder / NAME
        self.outcomes: dict[int, Outcome] = {}
        """By run."""
        self._file: BinaryIO = open(self.path, "a+b")  # noqa: SIM115
        try:
            self._lock()
            self._resume(header)
        except BaseException:
            self._file.close()
            raise

    def add(self, outcome: Outcome) -> None:
        """Writes a line; when this returns it is on the disk."""
        self._write(outcome_to_json(outcome))
        self.outcomes[outcome.run] = outcome

    def close(self) -> None:
        """All that could be written is written before."""
        with suppress(OSError):
            self._file.close()

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def _lock(self) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise _mistake(self.path, "another sweep is writing it", f"wait for that, or {_ANEW}") from error

    def _resume(self, header: Mapping[str, Any]) -> None:
        self._file.seek(0)
        data = self._file.read()
        whole = data.rfind(b"\n") + 1
        if whole < len(data) and not data.startswith(b'{"format"'[: len(data)]):
            raise _mistake(self.path, "is not a sweep's journal", _ANEW)
        self._file.truncate(whole)  # the rest is a line that was cut off
        lines = data[:whole].splitlines()
        if not lines:
            self._write(header)
            return
        _check_header(self.path, lines[0], header)
        for number, line in enumerate(lines[1:], start=2):
            try:
                outcome = outcome_from_json(json.loads(line))
            except Exception as error:  # damage shows in many ways
                raise _mistake(self.path, f"line {number} is damaged", f"delete that line, or {_ANEW}") from error
            self.outcomes[outcome.run] = outcome

    def _write(self, data: Mapping[str, Any]) -> None:
        with naming_file(self.path):
            self._file.write(json.dumps(data, allow_nan=False).encode() + b"\n")
            self._file.flush()
            os.fsync(self._file.fileno())


def _check_header(path: Path, line: bytes, header: Mapping[str, Any]) -> None:
    try:
        found = json.loads(line)
        is_journal = found["format"] == FORMAT
    except Exception:
        is_journal = False
    if not is_journal:
        raise _mistake(path, "is not a sweep's journal", _ANEW)
    if found.get("version") != VERSION:
        raise _mistake(path, f"is of version {found.get('version')}, and this release writes {VERSION}", _ANEW)
    differing = [words for key, words in _WORDS.items() if found.get(key) != header[key]]
    if differing:
        raise _mistake(path, f"holds a sweep {', '.join(differing)}", _ANEW)


def _mistake(path: Path, what: str, remedy: str) -> InvalidInputError:
    return InvalidInputError([Mistake(str(path), what, remedy)])
