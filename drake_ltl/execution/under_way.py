"""What all parts of a run have in common while things go wrong in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from drake_ltl.execution.joined import Part
from drake_ltl.execution.runner import RunProgress
from drake_ltl.faults.injection import Injector
from drake_ltl.faults.losses import CLOCK, DOOR, LOAD, Losses
from drake_ltl.faults.weights import too_heavy, weighed
from drake_ltl.monitoring.violation import Violation
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.planning.fits import Fits
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.fault_monitors.load import OFF


@dataclass(frozen=True)
class Noticed:
    """One fault that was noticed."""

    seen: Violation
    lost: str
    """What is lost by then."""
    went_on: str
    """How the run went on."""

    def __str__(self) -> str:
        return f"{self.seen}; {self.lost}; {self.went_on}"


@dataclass
class UnderWay:
    """A run under way."""

    scenario: Scenario
    models: MeasuredModels
    fits: Fits
    suffix_rounds: int
    report: Callable[[RunProgress], None] | None
    injector: Injector
    keep_going: bool = False
    """What the monitors that watch every run see is recorded, but does not end it."""
    losses: Losses = field(default_factory=Losses)
    seen: list[Violation] = field(default_factory=list)
    noticed: list[Noticed] = field(default_factory=list)
    parts: list[Part] = field(default_factory=list)
    ways: dict[str, tuple[str, str]] = field(default_factory=dict)
    """agent -> the regions between which it was when it was halted last."""

    @property
    def first_step(self) -> int:
        """Number of the run's step with which the next part begins."""
        return sum(part.num_steps for part in self.parts)

    def see(self, seen: Violation) -> None:
        """Something new: what is lost, and with which weights the next part begins."""
        self.seen.append(seen)
        losses = self.losses.after(seen)
        self.models = weighed(self.models, losses.masses)
        self.losses = replace(losses, objects=losses.objects | too_heavy(losses.masses, self.scenario, self.models))

    def knows(self, seen: Violation) -> bool:
        """Whether this is nothing new."""
        if seen.monitor == CLOCK:
            return (seen.value or 0.0) <= self.losses.delay
        if seen.monitor == LOAD and seen.value is not None and (mass := self.losses.masses.get(seen.who[0])):
            return abs(seen.value - mass) <= OFF * mass
        return seen.who[0] in (self.losses.regions if seen.monitor == DOOR else self.ignored)

    @property
    def ignored(self) -> frozenset[str]:
        """Members of whose faults is known."""
        return self.losses.agents | self.losses.grippers | self.losses.objects
