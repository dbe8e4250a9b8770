"""Grasps that come open."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context

from drake_ltl.faults.losses import GRIP
from drake_ltl.monitoring.violation import Violation
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.multibody.postures import pose_error
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.fault_monitors.fault_monitor import SMOOTHING, Durations, FaultMonitor
from drake_ltl.systems.monitors.monitor import Memory
from drake_ltl.systems.program import Weld
from drake_ltl.systems.signals import NO_GRASP
from drake_ltl.systems.state_places import StatePlaces

TO_BE_MADE = 0.1
"""A weld is made so long after its command at the latest [s]."""
OPEN = 4e-3
"""A grasp that gapes by more is lost [m]: those that hold gape by tenths of a millimetre ..."""
OPEN_ANGLE = np.deg2rad(1.0)
"""... or is turned by more [rad]."""


@dataclass
class _Grips:
    """How long agents have been holding, and how far their grippers are off, smoothed (6,) [rad, m]."""

    held: Durations = field(default_factory=Durations)
    error: dict[str, np.ndarray] = field(default_factory=dict)


class GripMonitor(FaultMonitor):
    """Grasps that come open."""

    def __init__(
        self, places: StatePlaces, scenario: Scenario, models: MeasuredModels, welds: tuple[Weld, ...], **rest
    ):
        super().__init__(GRIP, places, scenario, **rest)
        self._models, self._welds = models, welds

    def _observe(self, context: Context, memory: Memory) -> Iterable[Violation]:
        x, progress, now = self._state.Eval(context), self._progress.Eval(context), context.get_time()
        memory.notes = notes = memory.notes or _Grips()
        q = dict(zip(self._places.agents, np.split(x[self._places.q], np.cumsum(self._places.sizes)[:-1]), strict=True))
        for name, told in zip(self._places.agents, progress.agents, strict=True):
            if notes.held.lasts(name, told.grasp != NO_GRASP, now) <= TO_BE_MADE or name in self._ignored:
                notes.error.pop(name, None)
                continue
            weld = self._welds[told.grasp]
            X_WG = _pose(x[self._places.pose[weld.object]]) @ self._models.grasp(*_key(weld)).X_OE
            error = pose_error(self._models.agents[name].grasp_pose(q[name]), X_WG)
            before = notes.error.get(name, np.zeros(6))
            notes.error[name] = smooth = before + self.period / SMOOTHING * (error - before)
            angle, gap = float(np.linalg.norm(smooth[:3])), float(np.linalg.norm(smooth[3:]))
            what, who = f"{name} has lost its grasp of {weld.object}", (name, weld.object)
            if gap > OPEN:
                yield self._says(context, progress, who, what, value=gap, limit=OPEN, unit="m")
            elif angle > OPEN_ANGLE:
                yield self._says(context, progress, who, what, value=angle, limit=OPEN_ANGLE, unit="rad")


def _key(weld: Weld) -> tuple[str, str, str]:
    return weld.agent, weld.object, weld.option


def _pose(numbers: np.ndarray) -> RigidTransform:
    """X_WO of a quaternion, which may have grown, and an origin (7,)."""
    return RigidTransform(Quaternion(numbers[:4] / np.linalg.norm(numbers[:4])), numbers[4:])
