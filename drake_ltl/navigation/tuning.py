"""Raises kappa until no start that was tried ends in a minimum other than the goal.

That the navigation function has one minimum only holds for every kappa above some bound, which nobody can compute for
a crowded step. So kappa is tried: movers slide down the field from sampled starts, and the report says from how many.
It is evidence for these starts, no proof for all. Where space is tight no kappa may do for every start: two agents that
cannot pass each other do not change sides. What becomes of the step's own start is therefore said apart.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.integrate import solve_ivp

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.navigation.planar import CriticalPoint, PlanarField, sampled_starts
from drake_ltl.navigation.relations import Array
from drake_ltl.navigation.step import StepRelations

ARRIVED = 0.05
"""A descent this near to the goal, in the norm of all movers' errors [m], has reached it."""
AT_REST = 1e-6
"""A descent has come to rest where the gradient of log w is smaller [1/m]."""
SLOW = 1e-3
"""Slopes of log w below this no longer are descended at a metre per second [1/m]."""
NUDGE = 0.02
"""A descent that rests on a saddle goes on this far from it [m], as any disturbance would have it."""
MOST_SADDLES = 6
GROWTH = 1.5


@dataclass(frozen=True)
class Descent:
    """Where one start leads to."""

    start: Array
    end: Array
    """(2 n_movers,) [m]."""
    outcome: str
    """`goal`, `minimum` (a spurious one), or `unfinished` in the time given."""
    saddles: int = 0
    """On how many it came to rest on the way."""
    path: Array | None = None
    """(n, 2 n_movers) [m], in order."""


@dataclass(frozen=True)
class Trial:
    """All starts at one kappa."""

    kappa: float
    descents: tuple[Descent, ...]
    """The step's own start first, then the sampled ones."""

    def count(self, outcome: str) -> int:
        """How many of them ended so."""
        return sum(descent.outcome == outcome for descent in self.descents)

    @property
    def clean(self) -> bool:
        """Whether no start ended in a spurious minimum, and at least one at the goal."""
        return not self.count("minimum") and self.count("goal") > 0

    def __str__(self) -> str:
        saddles = sum(descent.saddles > 0 for descent in self.descents)
        text = f"kappa {self.kappa:.3g}: {self.count('goal')} of {len(self.descents)} starts reach the goal"
        text += f", {self.count('minimum')} end in other minima, {self.count('unfinished')} are still on their way"
        text += f"; {saddles} rested on a saddle" if saddles else ""
        text += f"; the step's own start: {self.descents[0].outcome}"
        stops = [descent.end for descent in self.descents if descent.outcome == "minimum"]
        return "\n".join([text, *(f"    minimum at {_places(x)}" for x in stops[:3])])


@dataclass(frozen=True)
class Tuning:
    """What was tried, and the first kappa without a spurious minimum."""

    kappa: float | None
    """None if there was one for every kappa tried."""
    trials: tuple[Trial, ...]

    def __str__(self) -> str:
        result = "no kappa tried is free of other minima" if self.kappa is None else f"kappa = {self.kappa:.4g}"
        return "\n".join([*map(str, self.trials), result])


def tune_kappa(
    step: StepRelations,
    *,
    kappas: Sequence[float] | None = None,
    n_starts: int = 20,
    seed: int = 0,
    lambda_: float = 0.0,
    h: float = 1.0,
) -> Tuning:
    """The first of `kappas` with which the step's start and sampled ones lead to no minimum but the goal.

    Args:
        step: who moves where among what.
        kappas: in the order of trial; None means 2, times GROWTH each, up to 100.
        n_starts: sampled starts, besides the step's own. All kappas have the same.

    Raises:
        InvalidInputError: something touches at the start, or as `NavigationFunction.for_goal`.
    """
    if touching := step.relations.violated(step.start):
        raise InvalidInputError([Mistake("start", f"violates {label}", "place the bodies apart") for label in touching])
    starts = [PlanarField.of(step, kappa=1.0).start, *sampled_starts(step, n_starts, seed)]
    trials = []
    for kappa in default_kappas() if kappas is None else kappas:
        field = PlanarField.of(step, kappa=kappa, lambda_=lambda_, h=h)
        trials.append(Trial(kappa, tuple(descend(field, start) for start in starts)))
        if trials[-1].clean:
            return Tuning(kappa, tuple(trials))
    return Tuning(None, tuple(trials))


def default_kappas() -> Iterable[float]:
    """2, 3, 4.5, ... up to 100."""
    kappa = 2.0
    while kappa <= 100.0:
        yield kappa
        kappa *= GROWTH


def descend(field: PlanarField, start: Array) -> Descent:
    """Slides down from x = `start` (2 n_movers,) to where the gradient vanishes; saddles on the way are left again."""
    x, saddles, paths = start, 0, []
    horizon = 20.0 * float(np.linalg.norm(start - field.goal)) + 100.0
    while True:
        flow = solve_ivp(
            partial(_downhill, field),
            (0.0, horizon),
            x,
            method="LSODA",
            rtol=1e-6,
            atol=1e-7,
            events=[_event(partial(_to_goal, field)), _event(partial(_slope, field))],
        )
        paths.append(flow.y.T)
        x = flow.y[:, -1]
        if np.linalg.norm(x - field.goal) <= 1.01 * ARRIVED:
            return Descent(start, x, "goal", saddles, np.vstack(paths))
        point = field.critical_near(x)
        if point is None or np.linalg.norm(point.x - x) > 0.05:
            return Descent(start, x, "unfinished", saddles, np.vstack(paths))
        if point.kind == "minimum":
            return Descent(start, point.x, "minimum", saddles, np.vstack(paths))
        if saddles == MOST_SADDLES:
            return Descent(start, x, "unfinished", saddles, np.vstack(paths))
        x, saddles = _nudged(field, point), saddles + 1


def _downhill(field: PlanarField, _time: float, x: Array) -> Array:
    """At a metre per second, slower where it is nearly flat; back where the solver tried too far a step."""
    gradient = field.gradient(x)
    length = float(np.sqrt(gradient @ gradient))
    return -gradient / np.hypot(length, SLOW) if np.isfinite(length) else field.goal - x


def _to_goal(field: PlanarField, _time: float, x: Array) -> float:
    return float(np.linalg.norm(x - field.goal)) - ARRIVED


def _slope(field: PlanarField, _time: float, x: Array) -> float:
    length = float(np.linalg.norm(field.gradient(x)))
    return length - AT_REST if np.isfinite(length) else 1.0


def _event(function):
    function.terminal = True
    return function


def _nudged(field: PlanarField, point: CriticalPoint) -> Array:
    """Off the saddle along its steepest way down, to the side that is lower."""
    sides = [point.x + side * NUDGE * point.directions[:, 0] for side in (1.0, -1.0)]
    return min(sides, key=lambda x: float(field.value(x)))


def _places(x: Array) -> str:
    return ", ".join(f"({a:.2f}, {b:.2f})" for a, b in x.reshape(-1, 2))
