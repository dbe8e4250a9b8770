"""V must not increase: the proof of convergence, seen on the recording."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.verification.potential import TOUCHING
from drake_ltl.verification.roles import Roles
from drake_ltl.verification.spans import Span
from drake_ltl.verification.violations import Violation, where_bad

RISE = 1e-6
"""Rise of V that counts as none, relative to V at the begin of its interval: what rounding explains."""


AGREEMENT = 1e-6
"""Difference between the recorded V and V worked out anew that rounding explains, relative to the larger."""
UNNOTICED = 1.0
"""Of the last so many seconds before a fault halts a step V is not judged: the fault moves bodies as well [s]."""
LEAST_V = 1e-3
"""... or to this, where both are smaller [J]."""
NO_VALUE = "V has no value: a goal or a mover touches something, or an arm is singular"


def lyapunov_rises(recording: Recording, V: np.ndarray, spans: Sequence[Span], moved_since: float = 0.0) -> np.ndarray:
    """(T,) how far V (T,) is above its lowest value so far, relative to V at the begin of its (step, phase).

    V is one function within each (step, phase), in which the movers and their goals stay the same. A slow rise
    over many samples counts in full; from V = 0 any rise is infinite. From shortly before a fault of somebody halts a
    step nothing is said of it: 0.

    Args:
        moved_since: since when faults may have moved bodies [s]. A door that closes and late measurements do not.
    """
    V, rises = _with_values(V), np.zeros(len(recording.time))
    for interval in _intervals(recording):
        here = V[interval]
        above = here - np.minimum.accumulate(here)
        rises[interval] = above / here[0] if here[0] > 0.0 else np.where(above > 0.0, np.inf, 0.0)
    for span in spans:
        if span.halted and span.faulty:
            time = recording.time[span.own]
            late = time >= max(_end_of_motion(V[span.own], time) - UNNOTICED, moved_since)
            rises[span.own] = np.where(late, 0.0, rises[span.own])
    return rises


def lyapunov_violations(
    recording: Recording,
    V: np.ndarray,
    spans: Sequence[Span],
    roles: Sequence[Roles],
    rises: np.ndarray,
    *,
    exact: bool = True,
) -> Iterator[Violation]:
    """Steps in which V rises, in which something moves without a V that could fall, or whose recorded V is none.

    Args:
        exact: whether the controllers saw the motion as it is recorded; else the V that they recorded is another one.
    """
    V = _with_values(V)
    off = np.abs(recording.lyapunov - V) / np.maximum(np.maximum(np.abs(V), np.abs(recording.lyapunov)), LEAST_V)
    for span, step in zip(spans, roles, strict=True):
        time = recording.time[span.own]
        violation = Violation("lyapunov", (), "V rises, relative to its start", step=span.number)
        yield from where_bad(violation, rises[span.own] > RISE, rises[span.own], time)
        touching = V[span.own] >= TOUCHING
        violation = Violation("lyapunov", (), NO_VALUE, step=span.number)
        yield from where_bad(violation, touching, touching.astype(float), time)
        violation = Violation("lyapunov", (), "the recorded V is not that of the motion", step=span.number)
        yield from where_bad(violation, exact & (off[span.own] > AGREEMENT), off[span.own], time)
        if step.movers and not V[span.first] > 0.0:
            names = tuple(str(mover) for mover in step.movers)
            what = f"{', '.join(names)} should move, but V is not positive"
            yield Violation("lyapunov", names, what, float(time[0]), span.number)


def _with_values(V: np.ndarray) -> np.ndarray:
    """V, with what is no number as where spheres touch: no comparison would see it, nor what rises after it."""
    return np.where(np.isfinite(V), V, TOUCHING)


def _end_of_motion(V: np.ndarray, time: np.ndarray) -> float:
    """When V is positive for the last time [s]; the begin if it never is."""
    moving = np.flatnonzero(V > 0.0)
    return float(time[moving[-1] if len(moving) else 0])


def _intervals(recording: Recording) -> Iterator[slice]:
    changes = (np.diff(recording.step) != 0) | (np.diff(recording.phase) != 0)
    bounds = [0, *(np.flatnonzero(changes) + 1).tolist(), len(recording.time)]
    for first, after in pairwise(bounds):
        yield slice(first, after)
