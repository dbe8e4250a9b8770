"""Monitors of bounding spheres: clearances, forbidden regions, workspace."""

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
    """Holds all centres against the rule of the step.

    .. pydrake_system::

        name: SphereMonitor
        input_ports:
        - centres
        - progress

    `centres` (3 (N + M),) as of `MemberCentres`.
    """

    def __init__(
        self,
        name: str,
        period: float,
        program: MissionProgram,
        duties: Sequence[Duty],
        size: int,
        rule: Callable[[Duty], Rule],
    ):
        """
        Args:
            duties: of each step of the program.
            size: of `centres`.
            rule: what must hold in a step.
        """
        super().__init__(name, period, program, "centres", size)
        self._rule = _rules(duties, rule)

    def _findings(self, look: Look, memory: Memory) -> Iterator[Finding]:
        return self._rule(look.index, look.done).findings(look.signal.reshape(-1, 3))


def _rules(duties: Sequence[Duty], rule: Callable[[Duty], Rule]) -> Callable[[int, bool], Rule]:
    """(index of a step, whether all are done before it) -> the rule, worked out once."""
    return cache(lambda index, done: rule(duties[index].rest if done else duties[index]))


class RegionMonitor(MissionMonitor):
    """Who does not move stays in its region, and who moved is in its goal region when the step ends.

    .. pydrake_system::

        name: RegionMonitor
        input_ports:
        - centres
        - progress
    """

    def __init__(
        self,
        name: str,
        period: float,
        program: MissionProgram,
        duties: Sequence[Duty],
        size: int,
        *,
        staying: Callable[[Duty], Rule],
        arrived: Callable[[Duty], Rule],
        end_centres: Callable[[Look], np.ndarray],
    ):
        """
        Args:
            staying: what must hold while a step goes on.
            arrived: what must hold when it has ended.
            end_centres: centres (3 (N + M),) when the step before this one ended.
        """
        super().__init__(name, period, program, "centres", size)
        self._staying, self._arrived = _rules(duties, staying), _rules(duties, arrived)
        self._end_centres = end_centres

    def _findings(self, look: Look, memory: Memory) -> Iterator[Finding]:
        before: int | None = memory.notes
        memory.notes = look.step
        if before is not None and before != look.step:
            centres = self._end_centres(look).reshape(-1, 3)
            for number in range(before, look.step):  # several only if they took no time
                yield from self._arrived(self._program.index(number), False).findings(centres)
        yield from self._staying(look.index, look.done).findings(look.signal.reshape(-1, 3))
