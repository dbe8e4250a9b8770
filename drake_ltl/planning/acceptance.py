"""Ways to accept: which marks must recur and which must not, for ever."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Clause:
    """One way to accept: of the marks that recur, all of `often` are there and none of `never`."""

    often: frozenset[int]
    never: frozenset[int]


def clauses(automaton: Any) -> tuple[Clause, ...]:
    """The ways to accept of a `spot.twa_graph`; none if it accepts nothing."""
    return read(str(automaton.get_acceptance().to_dnf()))


def read(acceptance: str) -> tuple[Clause, ...]:
    """A disjunctive normal form such as `(Fin(0) & Inf(1)) | (Inf(2)&Inf(3))`; `t` and `f` are constants."""
    if acceptance == "f":
        return ()
    found = []
    for part in acceptance.split("|"):
        atoms = re.findall(r"(Inf|Fin)\((\d+)\)", part)
        often, never = (frozenset(int(mark) for kind, mark in atoms if kind == wanted) for wanted in ("Inf", "Fin"))
        found.append(Clause(often, never))
    return tuple(found)


def renumbered(masks: NDArray[np.int64], kept: Iterable[int]) -> NDArray[np.int64]:
    """Sets of marks without all but some, which are numbered from 0 in the order given."""
    result = np.zeros_like(masks)
    for number, mark in enumerate(kept):
        result |= (masks >> mark & 1) << number
    return result


def mask(marks: Iterable[int]) -> int:
    """Marks as bits of a number."""
    return sum(1 << mark for mark in marks)
