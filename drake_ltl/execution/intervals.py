"""The intervals of one navigation function each, read off the logs of the supervisor's signals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from drake_ltl.diagrams.mission_diagram import MissionDiagram
from drake_ltl.execution.recording import IntervalRecord
from drake_ltl.systems.exchange import exchanged
from drake_ltl.systems.legs import Moving, moving_tasks
from drake_ltl.systems.signals import Phase, reach_ends, unpack_step


@dataclass(frozen=True)
class Interval:
    """One navigation function's time, and who moves under it."""

    step: int
    phase: int
    """Number of the interval within the step."""
    rows: slice
    """Its samples."""
    moving: Moving
    reaches: Mapping[str, tuple[np.ndarray, np.ndarray]]
    """agent that approaches or backs off meanwhile -> q at both ends of its way."""

    @property
    def record(self) -> IntervalRecord:
        """As a recording has it."""
        return IntervalRecord(
            step=self.step,
            phase=self.phase,
            travels={task.agent: tuple(task.q_goal.tolist()) for task in self.moving.travels},
            transports={task.object: tuple(map(float, task.p_goal)) for task in self.moving.transports},
            waiting=tuple(task.object for task in self.moving.waiting),
            reaches={name: tuple(tuple(q.tolist()) for q in ends) for name, ends in self.reaches.items()},
        )


def read_intervals(
    mission: MissionDiagram, step: np.ndarray, phase: np.ndarray, signal: np.ndarray, reaches: Mapping[str, np.ndarray]
) -> Iterator[Interval]:
    """One for each interval in which something moves under a navigation function, in order of time.

    Args:
        step: (T,) number of the step.
        phase: (T,) number of the interval within the step.
        signal: (T, 7) packed by `signals.pack_step`.
        reaches: agent -> (T, 2 + 2 n_i) packed by `signals.pack_reach`.
    """
    begins = np.flatnonzero(np.diff(step, prepend=-1) | np.diff(phase, prepend=-1)).tolist()
    for row, after in pairwise([*begins, len(step)]):
        index, kind, leg = unpack_step(signal[row])
        program = exchanged(mission.program.steps[index], leg.exchange, mission.models)
        if kind is not Phase.NAVIGATE or not (program.travels or program.transports):
            continue
        reaching = [task.weld.agent for task in (*program.grasps, *program.releases)]
        yield Interval(
            step=int(step[row]),
            phase=int(phase[row]),
            rows=slice(row, after),
            moving=moving_tasks(program, leg, mission.models),
            reaches={name: reach_ends(reaches[name][row]) for name in reaching},
        )
