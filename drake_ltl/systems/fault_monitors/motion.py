"""Agents that do not move as their torques should move them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from pydrake.systems.framework import Context, InputPort

from drake_ltl.faults.losses import MOTION
from drake_ltl.monitoring.violation import Violation
from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.fault_monitors.fault_monitor import SMOOTHING, Durations, FaultMonitor
from drake_ltl.systems.fault_monitors.residual import Look, Residuals
from drake_ltl.systems.monitors.monitor import Memory
from drake_ltl.systems.progress import Progress
from drake_ltl.systems.signals import NO_GRASP, Mode
from drake_ltl.systems.state_places import StatePlaces

LEAST_RESIDUAL = 3.0
"""Of a base's joint [N] ..."""
LEAST_ARM_RESIDUAL = 1.0
"""... and of an arm's [N m]: smoothed, smaller ones are noise."""
RESIDUAL_TIME = 0.15
"""Residuals that last for less are those of measurements that come late [s]."""
STOP = 0.2
"""A joint this near to one of its limits may be held by its stop [m, rad]."""
STANDSTILL = 1e-5
"""No joint of an agent that carries is ever slower than this [m/s, rad/s] unless it is held fast ..."""
STANDSTILL_TIME = 0.1
"""... for so long [s] ..."""
STANDSTILL_FORCE = 0.1
"""... while its base is driven by more than this [N]: a team that has arrived before others rests as well."""


@dataclass
class _Notes:
    """The last look, the smoothed residual (n,), and for how long joints stand still or residuals are large."""

    look: Look
    smooth: np.ndarray
    still: Durations = field(default_factory=Durations)
    large: Durations = field(default_factory=Durations)


class MotionMonitor(FaultMonitor):
    """Agents that do not move as their torques should move them. Also takes `torque`, and `age` of the state.

    By their `Residuals`. Those of agents that hold an object, whose load is not known, are left out; they are watched
    for joints that stand still while they should carry.
    """

    def __init__(self, places: StatePlaces, scenario: Scenario, models: MeasuredModels, **rest):
        super().__init__(MOTION, places, scenario, **rest)
        self._dt, self._residuals = scenario.simulation.time_step, Residuals(places, scenario, models)
        self._rows = self._residuals.crew.rows
        bases = [np.arange(n) < NUM_BASE_JOINTS for n in places.sizes]
        self._least = np.where(np.concatenate(bases), LEAST_RESIDUAL, LEAST_ARM_RESIDUAL)
        self._torque = self.DeclareVectorInputPort("torque", places.q.size)
        self._age = self.DeclareVectorInputPort("age", 1)

    def get_age_input_port(self) -> InputPort:
        return self._age

    def get_torque_input_port(self) -> InputPort:
        return self._torque

    def _observe(self, context: Context, memory: Memory) -> Iterable[Violation]:
        progress: Progress = self._progress.Eval(context)
        before: _Notes | None = memory.notes
        looked = None if before is None else before.look
        torque, age = self._torque.Eval(context), float(self._age.Eval(context)[0])
        look = self._residuals.look(looked, progress, self._state.Eval(context), torque, age)
        if before is None:
            memory.notes = _Notes(look, np.zeros(len(torque)))
            return
        smooth = before.smooth if look.acted is None else self._smoothed(before, look)
        memory.notes = _Notes(look, smooth, before.still, before.large)
        for name, told in zip(self._places.agents, progress.agents, strict=True):
            if name in self._ignored:
                continue
            rows = self._rows[name]
            worst = rows.start + int(np.argmax(np.abs(smooth[rows]) / self._least[rows]))
            large = bool(abs(smooth[worst]) > self._least[worst])
            if before.large.lasts(name, large, context.get_time()) >= RESIDUAL_TIME:
                what = f"{name} does not move as its torques should move it: unexplained (N or N m)"
                yield self._says(
                    context,
                    progress,
                    (name,),
                    what,
                    value=abs(float(smooth[worst])),
                    limit=float(self._least[worst]),
                    unit="",
                )
            fastest = float(np.abs(look.x[self._places.qd][rows]).max())
            driven = float(np.hypot(*look.torques[-1][rows][:NUM_BASE_JOINTS])) > STANDSTILL_FORCE
            stands = told.mode >= Mode.TRANSPORT and driven and fastest < STANDSTILL
            if before.still.lasts(name, stands, context.get_time()) >= STANDSTILL_TIME:
                what = f"{name} stands still though it should carry: its fastest joint (m/s or rad/s)"
                yield self._says(context, progress, (name,), what, value=fastest, limit=STANDSTILL, unit="")

    def _smoothed(self, before: _Notes, look: Look) -> np.ndarray:
        residual = self._residuals.between(before.look, look)
        smooth = before.smooth + self._dt / SMOOTHING * (residual - before.smooth)
        smooth[self._residuals.near_stops(before.look, STOP)] = 0.0
        for name, told in zip(self._places.agents, look.progress.agents, strict=True):
            if told.grasp != NO_GRASP:
                smooth[self._rows[name]] = 0.0
        return smooth
