"""One recording of a run that was carried out in parts, one after another, each by a diagram of its own."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from drake_ltl.execution.recording import IntervalRecord, Recording, StepRecord
from drake_ltl.monitoring.violation import Violation

_ARRAYS = ("time", "phase", "mode", "grasp", "lyapunov", "effort", "manipulability")
_GROUPS = ("q", "qd", "centre", "pose", "velocity")


@dataclass(frozen=True)
class Part:
    """What one diagram carried out. It begins in the state in which the part before it ends."""

    recording: Recording
    """Its own, which counts steps from 0."""
    halted: str = ""
    """The fault that ended it; empty if none did."""
    faulty: tuple[str, ...] = ()
    """Whom the fault befell."""
    is_mission: bool = True
    """Whether it carries out a plan's steps, with a suffix that repeats."""

    @property
    def num_steps(self) -> int:
        """Steps that it counts for when another part follows: one that was halted is over then, too."""
        return len(self.recording.steps)


def joined(parts: Sequence[Part], reason: str = "") -> Recording:
    """The whole run; `reason` says why it ended early, empty if it did not."""
    parts = [*map(_ended, parts[:-1]), parts[-1]]
    kept = [slice(None, -1)] * (len(parts) - 1) + [slice(None)]  # the last sample is the next part's first
    offsets = np.cumsum([0, *(part.num_steps for part in parts)]).tolist()
    recordings, pairs = [part.recording for part in parts], list(zip(parts, kept, strict=True))
    first = recordings[0]
    arrays = {name: np.concatenate([getattr(p.recording, name)[rows] for p, rows in pairs]) for name in _ARRAYS}
    arrays["step"] = np.concatenate([p.recording.step[k] + at for (p, k), at in zip(pairs, offsets, strict=False)])
    groups = {
        name: {
            member: np.concatenate([getattr(p.recording, name)[member][rows] for p, rows in pairs])
            for member in getattr(first, name)
        }
        for name in _GROUPS
    }
    planned = max(number for number, part in enumerate(parts) if part.is_mission)
    return dataclasses.replace(
        first,
        steps=tuple(_steps(parts, offsets, arrays["time"], arrays["step"])),
        intervals=tuple(_intervals(recordings, offsets)),
        prefix_length=offsets[planned] + recordings[planned].prefix_length,
        suffix_length=recordings[planned].suffix_length,
        completed=not reason,
        reason=reason,
        monitored=tuple(_monitored(recordings, offsets)),
        **arrays,
        **groups,
    )


def _ended(part: Part) -> Part:
    """What comes after its last step counts as the end of that step: the next one begins with the next part."""
    recording = part.recording
    over = recording.step >= part.num_steps
    phase = np.where(over, recording.phase[~over].max(initial=0) + 1, recording.phase)
    return dataclasses.replace(
        part, recording=dataclasses.replace(recording, step=np.minimum(recording.step, part.num_steps - 1), phase=phase)
    )


def _steps(parts: Sequence[Part], offsets: Sequence[int], time: np.ndarray, step: np.ndarray) -> Iterator[StepRecord]:
    """Those of all parts, each as long as the samples say."""
    for part, offset in zip(parts, offsets, strict=False):
        for record in part.recording.steps:
            number = offset + record.number
            first, after = np.searchsorted(step, [number, number + 1])
            finished, halted = bool(after < len(step)), part.halted if not record.finished else ""
            start, end = float(time[first]), float(time[after if finished else -1])
            yield dataclasses.replace(
                record,
                number=number,
                start=start,
                duration=end - start,
                finished=finished,
                halted=halted,
                faulty=part.faulty if halted else (),
            )


def _monitored(recordings: Sequence[Recording], offsets: Sequence[int]) -> Iterator[Violation]:
    for recording, offset in zip(recordings, offsets, strict=False):
        for seen in recording.monitored:
            yield dataclasses.replace(seen, step=seen.step + offset)


def _intervals(recordings: Sequence[Recording], offsets: Sequence[int]) -> Iterator[IntervalRecord]:
    for recording, offset in zip(recordings, offsets, strict=False):
        for record in recording.intervals:
            yield dataclasses.replace(record, step=record.step + offset)
