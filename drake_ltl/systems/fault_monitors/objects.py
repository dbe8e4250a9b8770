"""Objects that move though nobody holds them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from pydrake.systems.framework import Context

from drake_ltl.faults.losses import OBJECT
from drake_ltl.monitoring.violation import Violation
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.fault_monitors.fault_monitor import Durations, FaultMonitor
from drake_ltl.systems.monitors.monitor import Memory
from drake_ltl.systems.program import Weld
from drake_ltl.systems.signals import NO_GRASP
from drake_ltl.systems.state_places import StatePlaces

MOVES = 0.05
"""An object that nobody holds is not as fast as this [m/s] ..."""
MOVES_TIME = 0.1
"""... for so long [s]: let go, it may rock."""


class ObjectMonitor(FaultMonitor):
    """Objects that move though nobody holds them."""

    def __init__(self, places: StatePlaces, scenario: Scenario, welds: tuple[Weld, ...], **rest):
        super().__init__(OBJECT, places, scenario, **rest)
        self._welds = welds

    def _observe(self, context: Context, memory: Memory) -> Iterable[Violation]:
        x, progress, now = self._state.Eval(context), self._progress.Eval(context), context.get_time()
        memory.notes = moving = memory.notes or Durations()
        held = {self._welds[told.grasp].object for told in progress.agents if told.grasp != NO_GRASP}
        for name, rows in self._places.velocity.items():
            speed = float(np.linalg.norm(x[rows][3:5]))
            if moving.lasts(name, name not in held and speed > MOVES, now) >= MOVES_TIME and name not in self._ignored:
                what = f"{name} moves though nobody holds it"
                yield self._says(context, progress, (name,), what, value=speed, limit=MOVES, unit="m/s")
