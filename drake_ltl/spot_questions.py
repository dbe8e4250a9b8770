"""Questions to Spot about a formula, asked so that signals and time limits are obeyed while it thinks.

Spot holds up Python until it is done, and the time for a formula can grow doubly exponentially with its length. So
anything but a small formula is given to a child process, which is ended when a signal's handler raises or time is over.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, TypeVar

from drake_ltl.processes import apart
from drake_ltl.spot_support import require_spot

T = TypeVar("T")

OPTIONS = "simul-max=128"
"""Reductions by simulation take exponential time in the number of states and are left out of larger automata. Smaller
than that, all automata of the usual missions are."""

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
        seconds: time for it; None: any.

    Raises:
        TimeoutError: time is over.
        SearchLimitError: memory was short.
    """
    return question(formula, *more) if is_quick(formula) else apart(question, formula, *more, seconds=seconds)


def automaton(formula: str, *kind: str, options: str = OPTIONS) -> Any:
    """The `spot.twa_graph` of a formula; `kind` and `options` as for `spot.translate`."""
    if is_quick(formula):
        return _translated(formula, kind, options)
    return require_spot().automaton(apart(_in_hoa, formula, kind, options))


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
