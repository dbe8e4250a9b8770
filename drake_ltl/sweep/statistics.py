"""What all outcomes of a sweep show together, with intervals of confidence."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from drake_ltl.sweep.outcome import SATISFIED, STATUSES, Outcome
from drake_ltl.verification.clearances import KINDS

CONFIDENCE = 0.95
RESAMPLES = 9999
"""Of a bootstrap."""


@dataclass(frozen=True)
class Share:
    """How many of some runs, and the interval in which the probability lies."""

    count: int
    of: int
    low: float
    high: float


@dataclass(frozen=True)
class Quantity:
    """Numbers of several runs, all in the same unit."""

    name: str
    unit: str
    count: int
    least: float
    least_run: int
    """The first run that has it."""
    median: float
    mean: float
    mean_low: float | None
    """The mean's interval; None for one run."""
    mean_high: float | None
    greatest: float
    greatest_run: int


@dataclass(frozen=True)
class Summary:
    """Of a sweep's runs in the order of their numbers, whatever the order in which they ended."""

    outcomes: tuple[Outcome, ...]
    statuses: dict[str, int]
    """Status -> how many, every status in the order of `STATUSES`."""
    satisfied: Share
    """Of all runs; Wilson's interval."""
    collided: Share
    """Of the runs that were simulated; Clopper's and Pearson's interval, which is never too narrow."""
    quantities: tuple[Quantity, ...]

    @property
    def unsatisfied(self) -> tuple[Outcome, ...]:
        return tuple(outcome for outcome in self.outcomes if outcome.status != SATISFIED)


def summarize(outcomes: Iterable[Outcome]) -> Summary:
    """Durations are those of satisfied runs, all other quantities those of all runs that were simulated."""
    ordered = tuple(sorted(outcomes, key=lambda outcome: outcome.run))
    simulated = [outcome for outcome in ordered if outcome.simulated_seconds is not None]
    good = [outcome for outcome in ordered if outcome.status == SATISFIED]
    return Summary(
        outcomes=ordered,
        statuses={status: sum(outcome.status == status for outcome in ordered) for status in STATUSES},
        satisfied=share(len(good), len(ordered), "wilson"),
        collided=share(sum(outcome.collided for outcome in simulated), len(simulated), "exact"),
        quantities=tuple(_quantities(good, simulated)),
    )


def share(count: int, of: int, method: str) -> Share:
    """The share with its interval, of the methods of `scipy.stats.binomtest`; of nothing all is possible."""
    if of == 0:
        return Share(0, 0, 0.0, 1.0)
    interval = stats.binomtest(count, of).proportion_ci(CONFIDENCE, method=method)
    return Share(count, of, float(interval.low), float(interval.high))


def quantity(name: str, unit: str, values: Sequence[float], runs: Sequence[int]) -> Quantity:
    """Of at least one value; the mean's interval by bootstrap (percentiles), the same for the same values."""
    array = np.asarray(values, dtype=float)
    low, high = _mean_interval(array)
    least, greatest = int(np.argmin(array)), int(np.argmax(array))
    return Quantity(
        name=name,
        unit=unit,
        count=len(array),
        least=float(array[least]),
        least_run=runs[least],
        median=float(np.median(array)),
        mean=float(array.mean()),
        mean_low=low,
        mean_high=high,
        greatest=float(array[greatest]),
        greatest_run=runs[greatest],
    )


def _mean_interval(array: np.ndarray) -> tuple[float, float] | tuple[None, None]:
    if len(array) < 2:
        return None, None
    interval = stats.bootstrap(
        (array,),
        np.mean,
        n_resamples=RESAMPLES,
        batch=max(1, 1_000_000 // len(array)),
        confidence_level=CONFIDENCE,
        method="percentile",
        random_state=0,
    ).confidence_interval
    return float(interval.low), float(interval.high)


def _quantities(good: Sequence[Outcome], simulated: Sequence[Outcome]) -> Iterable[Quantity]:
    yield from _over(good, "simulated time", "s", lambda outcome: outcome.simulated_seconds)
    yield from _over(good, "longest step", "s", lambda outcome: max(outcome.durations, default=None))
    for kind in KINDS:
        yield from _over(simulated, kind, "m", lambda outcome, kind=kind: outcome.min_clearance.get(kind))
    carrying = [outcome for outcome in simulated if outcome.drawn is None or outcome.drawn.masses]
    yield from _over(carrying, "gap of a weld", "m", lambda outcome: outcome.max_weld_error)
    yield from _over(carrying, "tilt of an object", "rad", lambda outcome: outcome.max_tilt)
    yield from _over(simulated, "rise of V", "", lambda outcome: outcome.max_lyapunov_increase)


def _over(
    outcomes: Sequence[Outcome], name: str, unit: str, value: Callable[[Outcome], float | None]
) -> Iterable[Quantity]:
    known = [(number, outcome.run) for outcome in outcomes if (number := value(outcome)) is not None]
    if known:
        values, runs = zip(*known, strict=True)
        yield quantity(name, unit, values, runs)
