"""Regions that a fault has blocked: once that had to be noticed nobody enters them.

Since when is read off the scenario and the recorded times alone, whatever the run's own record says of faults. How
deep a sphere is in a region is r + r_k - |c - c_k|: not positive outside, 2 r or more within.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.scenario.model import Scenario
from drake_ltl.verification.befallen import since
from drake_ltl.verification.left_alone import BRAKING
from drake_ltl.verification.regions import ROUNDING, excess, radius
from drake_ltl.verification.spans import Span
from drake_ltl.verification.violations import Violation, where_bad

NOTICED_WITHIN = 0.15
"""After so long it has to be known that a region is blocked [s]."""


def blocked_violations(recording: Recording, scenario: Scenario, spans: Sequence[Span]) -> Iterator[Violation]:
    """Members that come into a blocked region, or farther into it.

    Who is in it may move and leave; who is on its border may leave. In steps that a fault has halted, movers may come
    farther by the way on which they brake: in all of them together, for once it is noticed nobody goes there.
    """
    for fault in scenario.faults:
        if fault.kind != "blocked_region" or since(fault, recording) == math.inf:
            continue
        region = scenario.region(fault.who)
        first = int(np.searchsorted(recording.time, since(fault, recording) + NOTICED_WITHIN))
        for member in (*recording.agents, *recording.objects):
            out, size, way = excess(recording, member, region), 2.0 * radius(recording, member), BRAKING
            for span in spans:
                rows = slice(max(span.first, first), span.end + 1)
                entered = _entered(out[rows], size, way if span.halted else 0.0)
                way = max(way - _deeper(out[rows], size), 0.0) if span.halted else way
                what = f"{member} enters {region.name}, which is blocked"
                violation = Violation("region", (member, region.name), what, step=span.number, unit="m")
                yield from where_bad(violation, entered, size - out[rows], recording.time[rows])


def _deeper(out: np.ndarray, size: float) -> float:
    """By how much a sphere comes farther into the region [m]."""
    depth = size - np.clip(out, 0.0, size)
    return float(depth.max() - depth[0]) if len(depth) else 0.0


def _entered(out: np.ndarray, size: float, way: float) -> np.ndarray:
    """(n,) where a sphere has entered since the first sample.

    Args:
        out: (n,) how far it reaches out of the region [m].
        size: its diameter [m].
        way: by which it may come farther into the region [m]; 0 in steps that no fault has halted.
    """
    if not len(out):
        return np.zeros(0, dtype=bool)
    if way:
        return (out[0] > ROUNDING) & (out < min(out[0], size) - way - ROUNDING)
    was_outside = np.maximum.accumulate(out >= size)
    was_not_within = np.maximum.accumulate(out > ROUNDING)
    return (was_outside & (out < size - ROUNDING)) | (was_not_within & (out <= ROUNDING))
