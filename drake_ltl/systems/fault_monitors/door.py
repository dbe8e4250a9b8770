"""Regions whose doors are closed."""

from __future__ import annotations

from collections.abc import Iterable

from pydrake.systems.framework import Context, InputPort

from drake_ltl.faults.losses import DOOR
from drake_ltl.monitoring.violation import Violation
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.fault_monitors.fault_monitor import Durations, FaultMonitor
from drake_ltl.systems.monitors.monitor import Memory
from drake_ltl.systems.state_places import StatePlaces

CLOSED_TIME = 0.05
"""Contacts bounce: a door that is closed for less may not be [s]."""


class DoorMonitor(FaultMonitor):
    """Regions whose doors are closed. Also takes `closed`.

    `ignored` are regions here.
    """

    def __init__(self, places: StatePlaces, scenario: Scenario, **rest):
        super().__init__(DOOR, places, scenario, **rest)
        self._regions = scenario.region_names
        self._closed = self.DeclareVectorInputPort("closed", len(self._regions))

    def get_closed_input_port(self) -> InputPort:
        return self._closed

    def _observe(self, context: Context, memory: Memory) -> Iterable[Violation]:
        progress, now = self._progress.Eval(context), context.get_time()
        memory.notes = closed = memory.notes or Durations()
        for name, contact in zip(self._regions, self._closed.Eval(context), strict=True):
            if closed.lasts(name, contact > 0.5, now) >= CLOSED_TIME and name not in self._ignored:
                what = f"the door of {name} has closed"
                yield Violation(self.kind, now, self._first_step + progress.count, (name,), what)
