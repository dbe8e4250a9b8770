"""Runs of milliseconds, for workers in other processes, which load nothing of drake_ltl for them."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from types import SimpleNamespace


def same(number: int) -> int:
    return number


def environment(name: str) -> str | None:
    return os.environ.get(name)


def sigterm_ends(_: int) -> bool:
    return signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


def note(folder: Path, number: int) -> int:
    """Leaves its number and its process in a file."""
    with open(folder / "calls", "a", encoding="utf-8") as file:
        file.write(f"{number} {os.getpid()}\n")
    return number


def calls(folder: Path) -> list[int]:
    """Numbers that were noted, in order."""
    return [int(line.split()[0]) for line in (folder / "calls").read_text(encoding="utf-8").splitlines()]


def die_at_first(folder: Path, fatal: int, number: int) -> int:
    """The first time the fatal number is called, its process is killed."""
    mark = folder / "died"
    if number == fatal and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return note(folder, number)


def die_always(folder: Path, fatal: int, number: int) -> int:
    note(folder, number)
    if number == fatal:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def fail(fatal: int, number: int) -> int:
    if number == fatal:
        raise ValueError("not a\nnumber")
    return number


def die_or_fail(folder: Path, fatal: int, wrong: int, number: int) -> int:
    return fail(wrong, die_at_first(folder, fatal, number))


def slow(folder: Path, number: int) -> int:
    note(folder, number)
    time.sleep(100.0)
    return number


class Sweep:
    """Has what a report asks for."""

    gains, masses, suffix_rounds = 0.0, 0.0, 1

    def __init__(self, name: str, source: str, seed: int):
        self.scenario, self.seed = SimpleNamespace(name=name, source=source), seed


def carried_out(sweep: Sweep, number: int) -> SatisfiedLater:
    """In place of a whole run: waits from run 2 on, unless a file `go` is there; tells all in $SWEEP_FOLDER."""
    folder = Path(os.environ["SWEEP_FOLDER"])
    note(folder, number)
    while number >= 2 and not (folder / "go").exists():
        time.sleep(0.02)
    return SatisfiedLater(number)


class SatisfiedLater:
    """An outcome in the process that gets it."""

    def __init__(self, number: int):
        self.number = number

    def __reduce__(self) -> tuple:
        return satisfied, (self.number,)


def satisfied(number: int) -> object:
    from drake_ltl.sweep.outcome import Outcome

    return Outcome(number, "satisfied", simulated_seconds=1.0 + number)
