"""Intervals of V: whoever moves under a navigation function keeps to it until it arrives or rests.

Without this V could be made to fall by beginning it anew whenever it is about to rise.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from drake_ltl.execution.recording import IntervalRecord, Recording
from drake_ltl.verification.regions import centres
from drake_ltl.verification.spans import Span, interval_samples
from drake_ltl.verification.violations import Violation

AT_REST = 0.1
"""Speed at which a mover counts as having come to rest [m/s, rad/s]."""
ARRIVED = 0.25
"""Distance from the goal of its interval at which a mover may go on to the next way point [m]."""


def interval_violations(
    recording: Recording, spans: Sequence[Span], goals: Sequence[dict[str, np.ndarray]]
) -> Iterator[Violation]:
    """Navigation functions that change while somebody is on the way.

    Args:
        goals: for each recorded interval, mover -> centre of its sphere at the goal (3,) [m].
    """
    for span in spans:
        records = [(i, record) for i, record in enumerate(recording.intervals) if record.step == span.number]
        for (index, record), (_, after) in pairwise(records):
            yield from _broken_off(recording, record, after, goals[index])


def _broken_off(
    recording: Recording, record: IntervalRecord, after: IntervalRecord, goals: dict[str, np.ndarray]
) -> Iterator[Violation]:
    """At the first sample of the next interval each mover has arrived, or rests."""
    begin = int(np.argmax(interval_samples(recording, after)))
    for name, goal in goals.items():
        away = float(np.linalg.norm((centres(recording, name)[begin] - goal)[:2]))
        velocity = recording.qd[name] if name in recording.agents else recording.velocity[name]
        if away > ARRIVED and np.abs(velocity[begin]).max() > AT_REST:
            what = f"V begins anew while {name} is on its way, short of its goal"
            time = float(recording.time[begin])
            yield Violation("lyapunov", (name,), what, time, record.step, away, time, "m")
