"""Agents that do not move as their torques should move them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from pydrake.systems.framework import Context, InputPort

from drake_ltl.faults.losses import MOTION
from drake_ltl.monitoring.violation import Violation
from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS
from drake_ltl.multibody.crew import CrewModel
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.fault_monitors.fault_monitor import SMOOTHING, Durations, FaultMonitor
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
class _Residual:
    """Progress, state, torques (n,) and smoothed residual (n,) of the last look."""

    progress: Progress
    x: np.ndarray
    torques: tuple[np.ndarray, ...]
    """Of the last look, and before it those of looks back to when `x` was measured; oldest first."""
    smooth: np.ndarray
    still: Durations = field(default_factory=Durations)
    large: Durations = field(default_factory=Durations)


class MotionMonitor(FaultMonitor):
    """Agents that do not move as their torques should move them. Also takes `torque`, and `age` of the state.

    The residual is B qdd + N qd + g - tau, with qdd from two measurements and tau of when they were made: what acts on
    the joints besides drives. Of a differential drive, which stands on the floor, it is that of (U1), at its joints x
    and yaw. Of agents that hold an object, whose load is not known, it is not formed; they are watched for joints that
    stand still while they should carry.
    """

    def __init__(self, places: StatePlaces, scenario: Scenario, models: MeasuredModels, **rest):
        super().__init__(MOTION, places, scenario, **rest)
        self._crew, self._dt = CrewModel(scenario.agents), scenario.simulation.time_step
        self._limits = np.concatenate([model.effort_limits for model in models.agents.values()])
        ranges = [
            (model.plant.GetPositionLowerLimits(), model.plant.GetPositionUpperLimits())
            for model in models.agents.values()
        ]
        self._lower, self._upper = (np.concatenate(ends) for ends in zip(*ranges, strict=True))
        bases = [np.arange(n) < NUM_BASE_JOINTS for n in places.sizes]
        self._least = np.where(np.concatenate(bases), LEAST_RESIDUAL, LEAST_ARM_RESIDUAL)
        self._wheeled = {name: model for name, model in models.agents.items() if not model.has_arm}
        self._torque = self.DeclareVectorInputPort("torque", len(self._limits))
        self._age = self.DeclareVectorInputPort("age", 1)

    def get_age_input_port(self) -> InputPort:
        return self._age

    def get_torque_input_port(self) -> InputPort:
        return self._torque

    def _observe(self, context: Context, memory: Memory) -> Iterable[Violation]:
        x = self._state.Eval(context).copy()
        torque = np.clip(self._torque.Eval(context), -self._limits, self._limits)
        progress: Progress = self._progress.Eval(context)
        before: _Residual | None = memory.notes
        if before is None:
            memory.notes = _Residual(progress, x, (torque,), np.zeros(len(torque)))
            return
        late = round(float(self._age.Eval(context)[0]) / self._dt)
        held = {name for name, told in zip(self._places.agents, progress.agents, strict=True) if told.grasp != NO_GRASP}
        # once the supervisor has changed its mind other torques act than were seen before
        known = progress is before.progress and len(before.torques) > late
        smooth = self._smoothed(before, x, held) if known else before.smooth
        torques = (*before.torques, torque)[-1 - late :]
        memory.notes = _Residual(progress, x, torques, smooth, before.still, before.large)
        for name, told in zip(self._places.agents, progress.agents, strict=True):
            if name in self._ignored:
                continue
            rows = self._crew.rows[name]
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
            fastest = float(np.abs(x[self._places.qd][rows]).max())
            driven = float(np.hypot(*torque[rows][:NUM_BASE_JOINTS])) > STANDSTILL_FORCE
            stands = told.mode >= Mode.TRANSPORT and driven and fastest < STANDSTILL
            if before.still.lasts(name, stands, context.get_time()) >= STANDSTILL_TIME:
                what = f"{name} stands still though it should carry: its fastest joint (m/s or rad/s)"
                yield self._says(context, progress, (name,), what, value=fastest, limit=STANDSTILL, unit="")

    def _smoothed(self, before: _Residual, x: np.ndarray, held: set[str]) -> np.ndarray:
        q, qd = before.x[self._places.q], before.x[self._places.qd]
        qdd = (x[self._places.qd] - qd) / self._dt
        self._crew.set_state(q, qd)
        residual = self._crew.inverse_dynamics(qdd) - before.torques[0]
        for name, model in self._wheeled.items():
            rows = self._crew.rows[name]
            residual[rows] = model.unexplained(q[rows], qdd[rows], before.torques[0][rows])
        smooth = before.smooth + self._dt / SMOOTHING * (residual - before.smooth)
        smooth[(q < self._lower + STOP) | (q > self._upper - STOP)] = 0.0
        for name in held:
            smooth[self._crew.rows[name]] = 0.0
        return smooth
