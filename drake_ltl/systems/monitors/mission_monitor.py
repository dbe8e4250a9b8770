"""A monitor that knows the plan: it reads off the supervisor's Progress which step is being carried out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import Context, InputPort

from drake_ltl.monitoring.violation import Finding, Violation
from drake_ltl.systems.monitors.monitor import Memory, Monitor
from drake_ltl.systems.program import MissionProgram
from drake_ltl.systems.progress import Progress
from drake_ltl.systems.signals import Phase

LARGEST = 1e9
"""Magnitude of a value."""


@dataclass(frozen=True)
class Look:
    """What a mission's monitor sees at one instant."""

    context: Context
    port: InputPort
    """Of the one signal that it reads."""
    progress: Progress
    index: int
    """Of the step in the program."""

    @property
    def time(self) -> float:
        """[s]"""
        return self.context.get_time()

    @property
    def signal(self) -> np.ndarray:
        """Worked out when it is asked for, which not every look does."""
        return self.port.Eval(self.context)

    @property
    def step(self) -> int:
        """Number of the step, from 0."""
        return self.progress.count

    @property
    def done(self) -> bool:
        """Whether all steps are done and everything rests."""
        return self.progress.phase is Phase.DONE


class MissionMonitor(Monitor):
    """Base of monitors of one signal.

    .. pydrake_system::

        name: MissionMonitor
        input_ports:
        - <signal>
        - progress

    `progress` is the supervisor's Progress.
    """

    def __init__(self, name: str, period: float, program: MissionProgram, signal: str, size: int):
        """`signal` is the name of the other input port (size,)."""
        super().__init__(name, period)
        self._program = program
        self._signal = self.DeclareVectorInputPort(signal, size)
        self._progress = self.DeclareAbstractInputPort("progress", Value[object]())

    def get_signal_input_port(self) -> InputPort:
        return self._signal

    def get_progress_input_port(self) -> InputPort:
        return self._progress

    def _look(self, context: Context) -> Look:
        progress = self._progress.Eval(context)
        return Look(context, self._signal, progress, self._program.index(progress.count))

    def _observe(self, context: Context, memory: Memory) -> Iterator[Violation]:
        look = self._look(context)
        for finding in self._findings(look, memory):
            yield _violation(self.kind, look, finding)

    def _findings(self, look: Look, memory: Memory) -> Iterator[Finding]:
        raise NotImplementedError


def _violation(kind: str, look: Look, finding: Finding) -> Violation:
    found = vars(finding) | {"value": _bounded(finding.value), "monitor": finding.monitor or kind}
    return Violation(time=look.time, step=look.step, **found)


def _bounded(value: float | None) -> float | None:
    """A number that a recording can have; V can rise from nothing, or beyond all bounds."""
    return None if value is None or np.isnan(value) else float(np.clip(value, -LARGEST, LARGEST))
