"""Which samples belong to which step, and to which interval of V."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drake_ltl.execution.recording import IntervalRecord, Recording


@dataclass(frozen=True)
class Span:
    """The samples of one step, from its start to its end."""

    number: int
    """From 0."""
    actions: tuple[dict, ...]
    """As recorded; none for the rest after the last step."""
    first: int
    """Index of the step's first sample: the state in which it starts."""
    last: int
    """Index of the last sample at which the step goes on."""
    end: int
    """Index of the sample that shows the step's end. Poses there are the step's outcome, while grasps, phase and V
    already belong to the next step. Equal to `last` if the step has not finished."""
    finished: bool
    halted: bool = False
    """Whether a fault ended it: its movers may then stand anywhere."""
    faulty: tuple[str, ...] = ()
    """Whom the fault befell."""

    @property
    def samples(self) -> slice:
        """From the start to the end, both included."""
        return slice(self.first, self.end + 1)

    @property
    def own(self) -> slice:
        """Without the sample that the next step starts with."""
        return slice(self.first, self.last + 1)


def interval_samples(recording: Recording, interval: IntervalRecord) -> np.ndarray:
    """(T,) whether a sample belongs to an interval of V."""
    return (recording.step == interval.step) & (recording.phase == interval.phase)


def step_spans(recording: Recording) -> tuple[Span, ...]:
    """One span for each recorded step and, if all have finished, one in which everybody idles.

    Requires a sound recording (see `soundness`) with at least one sample.
    """
    step = recording.step
    firsts = np.searchsorted(step, np.arange(len(recording.steps) + 1), side="left")
    spans = []
    for record, first, after in zip(recording.steps, firsts[:-1], firsts[1:], strict=True):
        finished = bool(after < len(step))
        last = max(first, after - 1)  # a step shorter than the sampling has one sample, that of the next
        spans.append(
            Span(
                record.number,
                record.actions,
                int(first),
                int(last),
                int(after if finished else last),
                finished,
                bool(record.halted),
                record.faulty,
            )
        )
    first, last = int(firsts[-1]), len(step) - 1
    if first <= last:
        spans.append(Span(len(recording.steps), (), first, last, last, False))
    return tuple(spans)


def state_samples(spans: Sequence[Span]) -> list[int]:
    """Index of the sample of each state of the run: its start, then the end of each finished step."""
    return [0, *(span.end for span in spans if span.finished)]
