"""Questions to Spot about a formula, asked so that signals and time limits are obeyed while it thinks.

Spot holds up Python until it is done, and the time for a formula can grow doubly exponentially with its length. So
anything but a small formula is given to a child process, which is ended when a signal's handler raises or time is over.
"""

from __future__ import annotations

import os
import re
import resource
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from drake_ltl.errors import SearchLimitError
from drake_ltl.processes import apart
from drake_ltl.spot_support import require_spot

T = TypeVar("T")

OPTIONS = "simul-max=128"
"""Reductions by simulation take exponential time in the number of states and are left out of larger automata. Smaller
than that, all automata of the usual missions are."""

MOST_TIME = 10.0
"""For one question, unless whoever asks says how long [s]. Automata that can be searched are made much sooner."""
LEAST_TIME = 0.5
"""For one question after many that were given up [s]."""
RECOVERY = 60.0
"""Time after which a question that was given up is forgiven [s]."""
MOST_MEMORY = 4 * 2**30
"""That the answer to one question may take [bytes]."""

_hopeless: dict[tuple[object, ...], SearchLimitError] = {}
"""Questions for which time was over: whoever asks again is told at once."""

_given_up: list[float] = []
"""When [s]."""

_MOST_OPERATORS = 6
_MOST_CHARACTERS = 400
"""Of small formulas: of ten thousand random ones none took 0.2 s."""
_OPERATORS = re.compile("GF|FG|[XFGUWRM]|<->|xor")  # names of propositions are in lower case


def is_quick(formula: str) -> bool:
    """Whether Spot answers at once, sooner than a child process could (some 5 ms): few operators make automata grow."""
    text = str(require_spot().formula(formula))  # spells out abbreviations such as X[9]
    return len(text) <= _MOST_CHARACTERS and len(_OPERATORS.findall(text)) <= _MOST_OPERATORS


def ask(question: Callable[..., T], formula: str, *more: object, seconds: float | None = None) -> T:
    """question(formula, *more), in a child process unless the formula is small.

    Args:
        question: returns something that can be pickled, not an object of Spot's.
        seconds: time for it; None: MOST_TIME.

    Raises:
        TimeoutError: the given time is over.
        SearchLimitError: MOST_TIME is over, or the answer is beyond MOST_MEMORY or Spot itself.
    """
    try:
        if is_quick(formula):
            return question(formula, *more)
        return _ask_apart(question, formula, *more, seconds=seconds)
    except (RuntimeError, MemoryError, OverflowError) as error:  # of too many sets of acceptance, for instance
        raise _too_large(formula, "beyond what Spot can do") from error


def automaton(formula: str, *kind: str, options: str = OPTIONS) -> Any:
    """The `spot.twa_graph` of a formula; `kind` and `options` as for `spot.translate`.

    Raises:
        SearchLimitError: as `ask`.
    """
    if is_quick(formula):
        return _translated(formula, kind, options)
    return require_spot().automaton(ask(_in_hoa, formula, kind, options))


def _ask_apart(question: Callable[..., T], formula: str, *more: object, seconds: float | None) -> T:
    if seconds is not None:
        return apart(_modestly, question, formula, *more, seconds=seconds)
    case = (question, formula, repr(more))
    if case in _hopeless:
        raise _hopeless[case]
    patience = _patience()
    try:
        return apart(_modestly, question, formula, *more, seconds=patience)
    except TimeoutError as error:
        _given_up.append(time.monotonic())
        _hopeless[case] = _too_large(formula, f"not made within {patience:g} s")
        raise _hopeless[case] from error


def _patience() -> float:
    """Time for the next question [s]: half as much for each that was given up within the last minute.

    A formula of many parts that are all too much would else take that many times MOST_TIME.
    """
    lately = sum(time.monotonic() - end < RECOVERY for end in _given_up)
    return max(LEAST_TIME, MOST_TIME / 2**lately)


def _modestly(question: Callable[..., T], *arguments: object) -> T:
    """In the child: libraries that run out of memory end the process, with words of their own."""
    with suppress(OSError, ValueError):
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + MOST_MEMORY,) * 2)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    return question(*arguments)


def _too_large(formula: str, why: str) -> SearchLimitError:
    start = formula if len(formula) <= 60 else f"{formula[:57]}..."
    return SearchLimitError(f"the automaton of {start!r} ({len(formula)} characters) is {why}; write a shorter formula")


def is_contradiction(formula: str) -> bool:
    """Whether no word satisfies a formula. The automaton itself stays where it is made: one over many propositions
    can be far larger when it is written down than as decision diagrams."""
    return ask(_is_contradiction, formula)


def _is_contradiction(formula: str) -> bool:
    return bool(_translated(formula, ("small",), OPTIONS).is_empty())


def _translated(formula: str, kind: tuple[str, ...], options: str) -> Any:
    return require_spot().formula(formula).translate(*kind, xargs=options)


def _in_hoa(formula: str, kind: tuple[str, ...], options: str) -> str:
    """In the Hanoi Omega-Automata format, which keeps the order of states and edges."""
    return _translated(formula, kind, options).to_str("hoa")
