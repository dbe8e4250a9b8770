"""Steps in which movers had stalled, on a saddle or in a crowd, and were then led around, one by one."""

from __future__ import annotations

from collections import defaultdict

from drake_ltl.execution.recording import Recording

WORDS = "stalled, then led around one by one"


def detoured_steps(recording: Recording) -> tuple[int, ...]:
    """Numbers of the steps with intervals that differ in what moves, or in where to."""
    ways = defaultdict(set)
    for interval in recording.intervals:
        if interval.travels or interval.transports:
            ways[interval.step].add((frozenset(interval.travels.items()), frozenset(interval.transports.items())))
    return tuple(sorted(step for step, different in ways.items() if len(different) > 1))
