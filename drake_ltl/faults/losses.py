"""What a team can no longer do after what monitors have seen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from drake_ltl.monitoring.violation import Violation

DRIVE, MOTION, GRIP, OBJECT, LOAD, DOOR, CLOCK = "drive", "motion", "grip", "object", "load", "door", "clock"
"""Names of the monitors of faults."""


@dataclass(frozen=True)
class Losses:
    """Capabilities that are gone for the rest of a run."""

    agents: frozenset[str] = frozenset()
    """Out of service: they stay where they are."""
    grippers: frozenset[str] = frozenset()
    """Agents that can drive, but grasp nothing any more."""
    objects: frozenset[str] = frozenset()
    """That nobody can carry any more: their weight is too much."""
    regions: frozenset[str] = frozenset()
    """That nobody may enter any more; who is there may stay or leave."""
    delay: float = 0.0
    """By how much measurements come late [s], if that is more than damping bears."""
    masses: Mapping[str, float] = field(default_factory=dict)
    """object -> what it was found to weigh [kg], if that is not what was believed."""

    def after(self, seen: Violation) -> Losses:
        """With what the violation takes away. An object that was pushed is somewhere else, and nothing is lost; one
        that was weighed is carried as heavy as it is."""
        if seen.monitor in (DRIVE, MOTION):
            return replace(self, agents=self.agents | {seen.who[0]})
        if seen.monitor == GRIP:
            return replace(self, grippers=self.grippers | {seen.who[0]})
        if seen.monitor == LOAD and seen.value is None:
            return replace(self, objects=self.objects | {seen.who[0]})
        if seen.monitor == LOAD:
            return replace(self, masses={**self.masses, seen.who[0]: seen.value})
        if seen.monitor == DOOR:
            return replace(self, regions=self.regions | {seen.who[0]})
        if seen.monitor == CLOCK:
            return replace(self, delay=max(self.delay, seen.value or 0.0))
        return self

    def __str__(self) -> str:
        parts = [f"{name} is out of service" for name in sorted(self.agents)]
        parts += [f"{name} cannot grasp any more" for name in sorted(self.grippers - self.agents)]
        parts += [f"{name} weighs {mass:.3g} kg" for name, mass in sorted(self.masses.items())]
        parts += [f"{name} cannot be carried any more" for name in sorted(self.objects)]
        parts += [f"nobody may enter {name} any more" for name in sorted(self.regions)]
        parts += [f"measurements come {1e3 * self.delay:.3g} ms late"] * (self.delay > 0.0)
        return "; ".join(parts) or "nothing is lost"
