"""Steps in which movers had stalled, on a saddle or in a crowd, and how they went on."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from itertools import combinations

from drake_ltl.execution.recording import Recording

WORDS = "stalled, then led around one by one"
EXCHANGED = "stalled, then exchanged places"

Goals = Mapping[str, tuple[float, ...]]
"""Mover -> where it goes."""


def detoured_steps(recording: Recording) -> tuple[int, ...]:
    """Numbers of the steps with intervals that differ in who moves, or in where a lone mover goes."""
    return _steps(recording, lambda one, other: one.keys() != other.keys() or (len(one) == 1 and one != other))


def exchanged_steps(recording: Recording) -> tuple[int, ...]:
    """Numbers of the steps with intervals in which the same movers, two or more, go to different places."""
    return _steps(recording, lambda one, other: one.keys() == other.keys() and len(one) > 1 and one != other)


def _steps(recording: Recording, differ: Callable[[Goals, Goals], bool]) -> tuple[int, ...]:
    intervals: dict[int, list[Goals]] = defaultdict(list)
    for interval in recording.intervals:
        if interval.travels or interval.transports:
            intervals[interval.step].append({**interval.travels, **interval.transports})
    found = (step for step, goals in intervals.items() if any(differ(*pair) for pair in combinations(goals, 2)))
    return tuple(sorted(found))
