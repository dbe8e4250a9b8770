"""Drives that give less torque than they are asked for."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from pydrake.systems.framework import Context, InputPort

from drake_ltl.faults.losses import DRIVE
from drake_ltl.monitoring.violation import Violation
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.fault_monitors.fault_monitor import FaultMonitor
from drake_ltl.systems.monitors.monitor import Memory
from drake_ltl.systems.state_places import StatePlaces

SHARE_MISSING = 0.02
"""Of its effort limit that a drive may give less than asked for."""


class DriveMonitor(FaultMonitor):
    """Drives that give less torque than they are asked for and could give. Also takes `torque` and `delivered`."""

    def __init__(self, places: StatePlaces, scenario: Scenario, models: MeasuredModels, **rest):
        super().__init__(DRIVE, places, scenario, **rest)
        self._limits = np.concatenate([model.effort_limits for model in models.agents.values()])
        n = len(self._limits)
        self._torque = self.DeclareVectorInputPort("torque", n)
        self._delivered = self.DeclareVectorInputPort("delivered", n)

    def get_torque_input_port(self) -> InputPort:
        return self._torque

    def get_delivered_input_port(self) -> InputPort:
        return self._delivered

    def _observe(self, context: Context, memory: Memory) -> Iterable[Violation]:
        asked = np.clip(self._torque.Eval(context), -self._limits, self._limits)
        missing = np.abs(asked - self._delivered.Eval(context)) / self._limits
        progress, ends = self._progress.Eval(context), np.cumsum(self._places.sizes)[:-1]
        for name, shares in zip(self._places.agents, np.split(missing, ends), strict=True):
            share = float(shares.max())
            if share > SHARE_MISSING and name not in self._ignored:
                what = f"the drives of {name} give less torque than asked for, as a share of their limit"
                yield self._says(context, progress, (name,), what, value=share, limit=SHARE_MISSING, unit="")
