"""Monitors of bounding spheres: who is where, and how far from what."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache

import numpy as np

from drake_ltl.monitoring.duties import Duty
from drake_ltl.monitoring.spheres import Rule
from drake_ltl.monitoring.violation import Finding
from drake_ltl.systems.monitors.mission_monitor import Look, MissionMonitor
from drake_ltl.systems.monitors.monitor import Memory
from drake_ltl.systems.program import MissionProgram


class SphereMonitor(MissionMonitor):
    """Holds all centres against the rules of the step: clearances, forbidden regions, workspace, regions of who stays.

    .. pydrake_system::

        name: SphereMonitor
        input_ports:
        - centres
        - progress

    `centres` (3 (N + M),) as of `MemberCentres`.
    """

    def __init__(
        self, period: float, program: MissionProgram, duties: Sequence[Duty], size: int, rule: Callable[[Duty], Rule]
    ):
        """
        Args:
            duties: of each step of the program.
            size: of `centres`.
            rule: all that must hold in a step.
        """
        super().__init__("spheres", period, program, "centres", size)
        self._rule = cache(lambda index, done: rule(duties[index].rest if done else duties[index]))

    def _findings(self, look: Look, memory: Memory) -> Iterator[Finding]:
        return self._rule(look.index, look.done).findings(look.signal.reshape(-1, 3))


class ArrivalMonitor(MissionMonitor):
    """Who moved is in its goal region when the step ends.

    .. pydrake_system::

        name: ArrivalMonitor
        input_ports:
        - centres
        - progress
    """

    def __init__(
        self,
        period: float,
        program: MissionProgram,
        duties: Sequence[Duty],
        size: int,
        *,
        arrived: Callable[[Duty], Rule],
        end_centres: Callable[[Look], np.ndarray],
    ):
        """
        Args:
            arrived: what must hold when a step has ended.
            end_centres: centres (3 (N + M),) when the step before this one ended.
        """
        super().__init__("arrival", period, program, "centres", size)
        self._duties, self._arrived, self._end_centres = tuple(duties), arrived, end_centres

    def _findings(self, look: Look, memory: Memory) -> Iterator[Finding]:
        before: int | None = memory.notes
        memory.notes = look.step
        if before is not None and before != look.step:
            centres = self._end_centres(look).reshape(-1, 3)
            for number in range(before, look.step):  # several only if they took no time
                yield from self._arrived(self._duties[self._program.index(number)]).findings(centres)
