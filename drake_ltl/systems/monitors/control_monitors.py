"""Monitors of what the controllers say: V, which must not rise, and torques beyond what motors give."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from drake_ltl.monitoring.rises import Fall
from drake_ltl.monitoring.violation import Finding
from drake_ltl.systems.monitors.mission_monitor import Look, MissionMonitor
from drake_ltl.systems.monitors.monitor import Memory
from drake_ltl.systems.program import MissionProgram
from drake_ltl.verification.lyapunov import RISE

SATURATED_LOOKS = 3
"""Torques may be beyond their limits at fewer looks in a row than this: when an interval begins they are for some
20 ms, which V does not notice."""


class LyapunovMonitor(MissionMonitor):
    """V does not rise while one navigation function moves everybody.

    .. pydrake_system::

        name: LyapunovMonitor
        input_ports:
        - controls
        - progress

    `controls` stacks the torques of all agents (n,) and V [J].
    """

    def __init__(self, name: str, period: float, program: MissionProgram, n: int):
        super().__init__(name, period, program, "controls", n + 1)

    def _findings(self, look: Look, memory: Memory) -> Iterator[Finding]:
        interval, V = (look.step, look.progress.interval), float(look.signal[-1])
        fall: Fall | None = memory.notes
        memory.notes = fall = Fall(interval, V, V) if fall is None or fall.interval != interval else fall.to(V)
        if fall.rise(V) > RISE:
            yield Finding((), "V rises, relative to its start", fall.rise(V), RISE, "")


class TorqueMonitor(MissionMonitor):
    """No motor is asked for more than it gives, look after look.

    .. pydrake_system::

        name: TorqueMonitor
        input_ports:
        - torque
        - progress
    """

    def __init__(
        self,
        name: str,
        period: float,
        program: MissionProgram,
        joints: Sequence[tuple[str, str]],
        limits: np.ndarray,
        *,
        size: int,
    ):
        """
        Args:
            joints: (agent, joint) of each of the first torques in `torque` (n).
            limits: what their motors give (n,) [N, N m]; inf without one.
            size: of `torque`; what stands behind the torques is not looked at.
        """
        super().__init__(name, period, program, "torque", size)
        self._joints, self._limits = tuple(joints), np.asarray(limits, dtype=float)

    def _findings(self, look: Look, memory: Memory) -> Iterator[Finding]:
        asked = np.abs(look.signal[: len(self._joints)])
        beyond = asked > self._limits
        if not beyond.any():
            memory.notes = None
            return
        counts = beyond * ((0 if memory.notes is None else memory.notes) + 1)
        memory.notes = counts
        for row in np.flatnonzero(counts >= SATURATED_LOOKS).tolist():
            agent, joint = self._joints[row]
            what = f"joint {joint} of {agent} is asked for more torque than its motor gives, time and again"
            yield Finding((agent,), what, float(asked[row] / self._limits[row]), 1.0, "")
