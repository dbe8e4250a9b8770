"""What was violated: what, by whom, by how much, when and in which step."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from drake_ltl.quantities import quantity


@dataclass(frozen=True)
class Violation:
    """One thing that does not hold, at its first occurrence and its worst. Printed as one line."""

    kind: str
    """`data`, `run`, `monitor`, `start`, `motion`, `body`, `action`, `region`, `clearance`, `forbidden_region`,
    `workspace`, `grasp`, `weld`, `object`, `heading`, `lyapunov`, `rest`, `loop` or `formula`."""
    who: tuple[str, ...]
    """Names of members and regions."""
    what: str
    time: float | None = None
    """First occurrence [s]; None where the whole run is meant."""
    step: int | None = None
    """Number of the step, from 0 (printed from 1)."""
    worst: float | None = None
    """Largest amount, in `unit`; None where nothing is measured."""
    worst_time: float | None = None
    """[s]"""
    unit: str = ""
    """`m`, `rad`, `m/s` ..; amounts without one are ratios."""

    def __str__(self) -> str:
        place = [] if self.step is None else [f"step {self.step + 1}"]
        place += [] if self.time is None else [f"{self.time:.3f} s"]
        text = f"{', '.join(place) or 'whole run'}: {self.what}"
        if self.worst is None:
            return text
        text += f": {quantity(self.worst, self.unit)}"
        later = self.worst_time is not None and self.worst_time != self.time
        return f"{text} (at {self.worst_time:.3f} s)" if later else text


def where_bad(violation: Violation, bad: np.ndarray, amount: np.ndarray, time: np.ndarray) -> list[Violation]:
    """The violation with its times and its worst amount, or nothing.

    Args:
        violation: all but times and amount.
        bad: (n,) whether a sample violates.
        amount: (n,) by how much.
        time: (n,) [s].
    """
    if not bad.any():
        return []
    first = int(np.argmax(bad))
    worst = int(np.argmax(np.where(bad, amount, -np.inf)))
    return [
        replace(violation, time=float(time[first]), worst=float(amount[worst]), worst_time=float(time[worst])),
    ]


def merged(violations: Iterable[Violation]) -> tuple[Violation, ...]:
    """One violation for each (kind, who, what): the first, with the worst amount of all. In order of time."""
    found: dict[tuple, Violation] = {}
    for violation in violations:
        key = (violation.kind, violation.who, violation.what)
        found[key] = _joined(found[key], violation) if key in found else violation
    return tuple(sorted(found.values(), key=lambda v: (v.time is None, v.time or 0.0)))


def _joined(a: Violation, b: Violation) -> Violation:
    first, other = (b, a) if _time(b) < _time(a) else (a, b)
    if other.worst is None or (first.worst is not None and first.worst >= other.worst):
        return first
    return replace(first, worst=other.worst, worst_time=other.worst_time)


def _time(violation: Violation) -> float:
    return np.inf if violation.time is None else violation.time
