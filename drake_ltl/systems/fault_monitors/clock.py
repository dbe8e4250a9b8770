"""Measurements that come late."""

from __future__ import annotations

from collections.abc import Iterable

from pydrake.systems.framework import Context, InputPort

from drake_ltl.faults.lateness import bearable
from drake_ltl.faults.losses import CLOCK
from drake_ltl.monitoring.violation import Violation
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.fault_monitors.fault_monitor import Durations, FaultMonitor
from drake_ltl.systems.monitors.monitor import Memory
from drake_ltl.systems.state_places import StatePlaces

LATE_TIME = 0.01
"""A single sample may be late [s]."""


class ClockMonitor(FaultMonitor):
    """Measurements that are older than the controllers' gains bear, by their stamps. Also takes `age`."""

    def __init__(self, places: StatePlaces, scenario: Scenario, models: MeasuredModels, **rest):
        super().__init__(CLOCK, places, scenario, **rest)
        self._most = bearable(models.agents, scenario.controller, scenario.simulation.time_step)
        self._age = self.DeclareVectorInputPort("age", 1)

    def get_age_input_port(self) -> InputPort:
        return self._age

    def _observe(self, context: Context, memory: Memory) -> Iterable[Violation]:
        age, now = float(self._age.Eval(context)[0]), context.get_time()
        memory.notes = late = memory.notes or Durations()
        if late.lasts("", age > self._most, now) >= LATE_TIME:
            what = "measurements come later than damping bears"
            progress = self._progress.Eval(context)
            yield self._says(context, progress, (), what, value=age, limit=self._most, unit="s")
