"""What all runs of a sweep share, as immutable data that goes to every worker."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drake_ltl.planning.geometry import Geometry
from drake_ltl.planning.plan import Plan
from drake_ltl.scenario.model import Scenario

GAINS = 5.0
"""Default of `Sweep.gains` [per cent]."""
MASSES = 1.0
"""Default of `Sweep.masses` [per cent]: an object that is 5 % lighter than its carriers believe already floats when
they let go of it, 3 mm above the floor, and verdicts count that as a violation."""


@dataclass(frozen=True)
class Sweep:
    """A scenario with its own plan, and how much is drawn anew in each run."""

    scenario: Scenario
    geometry: Geometry
    """Measured from the scenario's models."""
    plan: Plan
    """From the scenario's own start: drawn starts are those from which it can be placed too."""
    seed: int
    gains: float = GAINS
    """Largest change of a gain [per cent]."""
    masses: float = MASSES
    """Largest change of an object's mass and inertia [per cent]."""
    suffix_rounds: int = 1

    def random(self, number: int) -> np.random.Generator:
        """The source of all that is drawn in one run, that is, child `number` of the seed."""
        return np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(number,)))
