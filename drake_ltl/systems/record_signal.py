"""The supervisor's signal `record`: all that it decides, as numbers for a log."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from drake_ltl.systems.progress import Progress
from drake_ltl.systems.signals import STEP_SIGNAL_SIZE


def status_signal(progress: Progress) -> np.ndarray:
    """(2 + 2 N): count, interval, modes and commanded welds of all agents."""
    modes = [signals.mode for signals in progress.agents]
    grasps = [signals.grasp for signals in progress.agents]
    return np.array([progress.count, progress.interval, *modes, *grasps], dtype=float)


def record_size(sizes: Iterable[int]) -> int:
    """Of the signal `record` of agents with so many joints."""
    return STEP_SIGNAL_SIZE + sum(2 + 2 + 2 * n for n in sizes) + 2


def split_record(record: np.ndarray, sizes: Mapping[str, int]) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Signals `record` (T, ..) as status, step and agent -> reach, one row each."""
    ends = np.cumsum([2 + 2 * len(sizes), STEP_SIGNAL_SIZE, *(2 + 2 * n for n in sizes.values())])
    status, step, *reaches = np.split(record, ends[:-1], axis=1)
    return status, step, dict(zip(sizes, reaches, strict=True))
