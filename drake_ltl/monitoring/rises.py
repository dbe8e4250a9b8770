"""How far V is above the lowest value that it has had in its interval."""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Fall:
    """V of one interval so far."""

    interval: tuple[int, int]
    """(step, number of the interval within the step): V is one function in it."""
    first: float
    """[J]"""
    least: float
    """[J]"""

    def to(self, V: float) -> Fall:
        """When V has been seen once more."""
        return self if self.least <= V else replace(self, least=V)

    def rise(self, V: float) -> float:
        """Of V above its least value, relative to the first one; infinite where that is 0."""
        above = V - self.least
        if above <= 0.0:
            return 0.0
        return above / self.first if self.first > 0.0 else float("inf")
