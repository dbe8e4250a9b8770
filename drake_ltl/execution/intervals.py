"""The intervals of one navigation function each, read off the logs of the supervisor's signals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from drake_ltl.diagrams.mission_diagram import MissionDiagram
from drake_ltl.execution.recording import IntervalRecord
from drake_ltl.systems.legs import moving_tasks
from drake_ltl.systems.signals import Phase, reach_ends, unpack_step


def read_intervals(
    mission: MissionDiagram, step: np.ndarray, phase: np.ndarray, signal: np.ndarray, reaches: Mapping[str, np.ndarray]
) -> Iterator[IntervalRecord]:
    """One for each interval in which something moves under a navigation function, in order of time.

    Args:
        step: (T,) number of the step.
        phase: (T,) number of the interval within the step.
        signal: (T, 6) packed by `signals.pack_step`.
        reaches: agent -> (T, 2 + 2 n_i) packed by `signals.pack_reach`.
    """
    begins = np.flatnonzero(np.diff(step, prepend=-1) | np.diff(phase, prepend=-1))
    for row in begins.tolist():
        index, kind, leg = unpack_step(signal[row])
        program = mission.program.steps[index]
        if kind is not Phase.NAVIGATE or not (program.travels or program.transports):
            continue
        moving = moving_tasks(program, leg, mission.models)
        reaching = [task.weld.agent for task in (*program.grasps, *program.releases)]
        yield IntervalRecord(
            step=int(step[row]),
            phase=int(phase[row]),
            travels={task.agent: tuple(task.q_goal.tolist()) for task in moving.travels},
            transports={task.object: tuple(map(float, task.p_goal)) for task in moving.transports},
            waiting=tuple(task.object for task in moving.waiting),
            reaches={name: tuple(tuple(q.tolist()) for q in reach_ends(reaches[name][row])) for name in reaching},
        )
