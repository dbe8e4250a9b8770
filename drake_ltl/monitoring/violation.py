"""What a monitor saw go wrong: when, in which step, who, by how much."""

from __future__ import annotations

from dataclasses import dataclass

from drake_ltl.quantities import quantity


@dataclass(frozen=True)
class Violation:
    """One thing that did not hold when a monitor looked: plain data, printed as one line."""

    monitor: str
    """Name of the monitor, such as `clearance` or `weld`."""
    time: float
    """Of the look [s]."""
    step: int
    """Number of the plan step being carried out, from 0 (printed from 1)."""
    who: tuple[str, ...]
    """Names of agents, objects and regions."""
    what: str
    """What is wrong, as a clause."""
    value: float | None = None
    """What was measured, in `unit`; None where nothing is measured."""
    limit: float | None = None
    """What it should not have gone beyond."""
    unit: str = ""
    """`m`, `rad`, `J`; ratios have none."""

    @property
    def key(self) -> tuple[int, tuple[str, ...], str]:
        """What is reported once: the same thing in the same step."""
        return self.step, self.who, self.what

    def __str__(self) -> str:
        text = f"step {self.step + 1}, {self.time:.3f} s: {self.what}"
        if self.value is None:
            return text
        text += f": {quantity(self.value, self.unit)}"
        return text if self.limit is None else f"{text} (limit {quantity(self.limit, self.unit)})"


@dataclass(frozen=True)
class Finding:
    """What a rule finds wrong, without who looked and when: see the same fields of Violation."""

    who: tuple[str, ...]
    what: str
    value: float | None = None
    limit: float | None = None
    unit: str = ""
    monitor: str = ""
    """Name of the rule; empty if that of the monitor will do."""
