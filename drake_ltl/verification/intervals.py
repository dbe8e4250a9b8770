"""Intervals of V: whoever moves does so under a navigation function, and keeps to it until it arrives or rests.

Without this V could be made to fall by leaving out who moves, or by beginning it anew whenever it is about to rise.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from drake_ltl.execution.recording import IntervalRecord, Recording
from drake_ltl.verification.regions import centres
from drake_ltl.verification.roles import Roles
from drake_ltl.verification.spans import Span
from drake_ltl.verification.violations import Violation, where_bad

STAND = 0.06
"""How far a mover goes while no navigation function moves it: it brakes, and is let go or held [m]."""
BRAKING = 0.5
"""... and if a fault halts its step: at 2 m/s a hold brakes within 20 cm, a fault can be noticed late [m]."""
AT_REST = 0.1
"""Speed at which a mover counts as having come to rest [m/s, rad/s]."""
ARRIVED = 0.25
"""Distance from the goal of its interval at which a mover may go on to the next way point [m]."""


def interval_violations(
    recording: Recording, spans: Sequence[Span], roles: Sequence[Roles], goals: Sequence[dict[str, np.ndarray]]
) -> Iterator[Violation]:
    """Movers that move without a navigation function, and functions that change while somebody is on the way.

    Args:
        goals: for each recorded interval, mover -> centre of its sphere at the goal (3,) [m].
    """
    for span, step in zip(spans, roles, strict=True):
        records = [(i, record) for i, record in enumerate(recording.intervals) if record.step == span.number]
        for mover in step.movers:
            yield from _left_alone(recording, span, mover.name, [record for _, record in records])
        for (index, record), (_, after) in pairwise(records):
            yield from _broken_off(recording, record, after, goals[index])


def _rows(recording: Recording, record: IntervalRecord) -> np.ndarray:
    return (recording.step == record.step) & (recording.phase == record.phase)


def _left_alone(recording: Recording, span: Span, name: str, records: Sequence[IntervalRecord]) -> Iterator[Violation]:
    """A mover may not move in samples in which it is in no interval."""
    driven = np.zeros(len(recording.time), dtype=bool)
    for record in records:
        if name in record.travels or name in record.transports:
            driven |= _rows(recording, record)
    driven, time = driven[span.own], recording.time[span.own]
    where = centres(recording, name)[span.own]
    last = np.maximum.accumulate(np.where(driven, np.arange(len(driven)), 0))  # when it was last driven
    way = np.linalg.norm(where - where[last], axis=1)
    most = BRAKING if span.halted else STAND
    what = f"{name} moves by more than {100 * most:.3g} cm under no navigation function"
    violation = Violation("lyapunov", (name,), what, step=span.number, unit="m")
    yield from where_bad(violation, way > most, way, time)


def _broken_off(
    recording: Recording, record: IntervalRecord, after: IntervalRecord, goals: dict[str, np.ndarray]
) -> Iterator[Violation]:
    """At the first sample of the next interval each mover has arrived, or rests."""
    begin = int(np.argmax(_rows(recording, after)))
    for name, goal in goals.items():
        away = float(np.linalg.norm((centres(recording, name)[begin] - goal)[:2]))
        velocity = recording.qd[name] if name in recording.agents else recording.velocity[name]
        if away > ARRIVED and np.abs(velocity[begin]).max() > AT_REST:
            what = f"V begins anew while {name} is on its way, short of its goal"
            time = float(recording.time[begin])
            yield Violation("lyapunov", (name,), what, time, record.step, away, time, "m")
