"""Monitors that notice faults: what is measured is not what should follow from what was commanded.

They see commands, measured joints and poses, and measured torques; none of them knows which faults a scenario has.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, InputPort

from drake_ltl.faults.losses import DOOR, DRIVE, GRIP, LOAD, MOTION, OBJECT
from drake_ltl.monitoring.violation import Violation
from drake_ltl.multibody.crew import CrewModel
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.multibody.postures import pose_error
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.monitors import Monitor
from drake_ltl.systems.monitors.monitor import Memory
from drake_ltl.systems.program import Weld
from drake_ltl.systems.progress import Progress
from drake_ltl.systems.signals import NO_GRASP, Mode
from drake_ltl.systems.state_places import StatePlaces

SMOOTHING = 0.1
"""Time constant with which residuals are smoothed [s]."""
LEAST_RESIDUAL = 3.0
"""Of a base's joint [N] ..."""
LEAST_ARM_RESIDUAL = 1.0
"""... and of an arm's [N m]: smoothed, smaller ones are noise."""
RESIDUAL_TIME = 0.15
"""Residuals that last for less are those of measurements that come late [s]."""
STOP = 0.2
"""A joint this near to one of its limits may be held by its stop [m, rad]."""
SHARE_MISSING = 0.02
"""Of its effort limit that a drive may give less than asked for."""
STANDSTILL = 1e-5
"""No joint of an agent that carries is ever slower than this [m/s, rad/s] unless it is held fast ..."""
STANDSTILL_TIME = 0.1
"""... for so long [s]."""
TO_BE_MADE = 0.1
"""A weld is made so long after its command at the latest [s]."""
OPEN = 4e-3
"""A grasp that gapes by more is lost [m]: those that hold gape by tenths of a millimetre ..."""
OPEN_ANGLE = np.deg2rad(1.0)
"""... or is turned by more [rad]."""
MOVES = 0.05
"""An object that nobody holds is not as fast as this [m/s] ..."""
MOVES_TIME = 0.1
"""... for so long [s]: let go, it may rock."""
LIFTED = 0.05
"""What is carried neither rises nor sinks by more [m]: loads of the weight believed do by less than 3 cm."""

CLOSED_TIME = 0.05
"""Contacts bounce: a door that is closed for less may not be [s]."""


@dataclass
class _Durations:
    """Since when something has been so, by name."""

    since: dict[str, float] = field(default_factory=dict)

    def lasts(self, name: str, is_so: bool, now: float) -> float:
        """For how long by now [s]; 0 if it is not."""
        if not is_so:
            self.since.pop(name, None)
            return 0.0
        return now - self.since.setdefault(name, now)


@dataclass
class _Residual:
    """Progress, state, torques and smoothed residual (n,) of the last look."""

    progress: Progress
    x: np.ndarray
    torque: np.ndarray
    smooth: np.ndarray
    still: _Durations = field(default_factory=_Durations)
    large: _Durations = field(default_factory=_Durations)


@dataclass
class _Grips:
    """How long agents have been holding, and how far their grippers are off, smoothed (6,) [rad, m]."""

    held: _Durations = field(default_factory=_Durations)
    error: dict[str, np.ndarray] = field(default_factory=dict)


class FaultMonitor(Monitor):
    """What the monitors of faults have in common.

    .. pydrake_system::

        name: FaultMonitor
        input_ports:
        - state
        - progress
    """

    def __init__(self, name: str, places: StatePlaces, scenario: Scenario, first_step: int, ignored: frozenset[str]):
        """
        Args:
            places: what is where in `state`.
            first_step: number of the run's step with which this diagram begins.
            ignored: members of whose faults is known.
        """
        super().__init__(name, scenario.simulation.time_step)
        self._places, self._first_step, self._ignored = places, first_step, ignored
        self._state = self.DeclareVectorInputPort("state", places.size)
        self._progress = self.DeclareAbstractInputPort("progress", Value[object]())

    def get_state_input_port(self) -> InputPort:
        return self._state

    def get_progress_input_port(self) -> InputPort:
        return self._progress

    def Restart(self, context: Context) -> None:
        """Looks anew from now on: commands have changed between two looks."""
        self._remembered(context).notes = None

    def _says(
        self,
        context: Context,
        progress: Progress,
        who: tuple[str, ...],
        what: str,
        *,
        value: float,
        limit: float,
        unit: str,
    ) -> Violation:
        step = self._first_step + progress.count
        return Violation(self.kind, context.get_time(), step, who, what, value, limit, unit)


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


class MotionMonitor(FaultMonitor):
    """Agents that do not move as their torques should move them. Also takes `torque`.

    The residual is B qdd + N qd + g - tau, with qdd from two measurements: what acts on the joints besides drives. Of
    agents that hold an object, whose load is not known, it is not formed; they are watched for joints that stand
    still while they should carry.
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
        bases = [np.arange(n) < 2 for n in places.sizes]
        self._least = np.where(np.concatenate(bases), LEAST_RESIDUAL, LEAST_ARM_RESIDUAL)
        self._torque = self.DeclareVectorInputPort("torque", len(self._limits))

    def get_torque_input_port(self) -> InputPort:
        return self._torque

    def _observe(self, context: Context, memory: Memory) -> Iterable[Violation]:
        x = self._state.Eval(context).copy()
        torque = np.clip(self._torque.Eval(context), -self._limits, self._limits)
        progress: Progress = self._progress.Eval(context)
        before: _Residual | None = memory.notes
        if before is None:
            memory.notes = _Residual(progress, x, torque, np.zeros(len(torque)))
            return
        held = {name for name, told in zip(self._places.agents, progress.agents, strict=True) if told.grasp != NO_GRASP}
        # once the supervisor has changed its mind other torques act than were seen before
        smooth = self._smoothed(before, x, held) if progress is before.progress else before.smooth
        memory.notes = _Residual(progress, x, torque, smooth, before.still, before.large)
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
            stands = told.mode >= Mode.TRANSPORT and fastest < STANDSTILL
            if before.still.lasts(name, stands, context.get_time()) >= STANDSTILL_TIME:
                what = f"{name} stands still though it should carry: its fastest joint (m/s or rad/s)"
                yield self._says(context, progress, (name,), what, value=fastest, limit=STANDSTILL, unit="")

    def _smoothed(self, before: _Residual, x: np.ndarray, held: set[str]) -> np.ndarray:
        q, qd = before.x[self._places.q], before.x[self._places.qd]
        self._crew.set_state(q, qd)
        residual = self._crew.inverse_dynamics((x[self._places.qd] - qd) / self._dt) - before.torque
        smooth = before.smooth + self._dt / SMOOTHING * (residual - before.smooth)
        smooth[(q < self._lower + STOP) | (q > self._upper - STOP)] = 0.0
        for name in held:
            smooth[self._crew.rows[name]] = 0.0
        return smooth


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


class ObjectMonitor(FaultMonitor):
    """Objects that move though nobody holds them."""

    def __init__(self, places: StatePlaces, scenario: Scenario, welds: tuple[Weld, ...], **rest):
        super().__init__(OBJECT, places, scenario, **rest)
        self._welds = welds

    def _observe(self, context: Context, memory: Memory) -> Iterable[Violation]:
        x, progress, now = self._state.Eval(context), self._progress.Eval(context), context.get_time()
        memory.notes = moving = memory.notes or _Durations()
        held = {self._welds[told.grasp].object for told in progress.agents if told.grasp != NO_GRASP}
        for name, rows in self._places.velocity.items():
            speed = float(np.linalg.norm(x[rows][3:5]))
            if moving.lasts(name, name not in held and speed > MOVES, now) >= MOVES_TIME and name not in self._ignored:
                what = f"{name} moves though nobody holds it"
                yield self._says(context, progress, (name,), what, value=speed, limit=MOVES, unit="m/s")


class LoadMonitor(FaultMonitor):
    """Objects that rise or sink while they are carried: they are not as heavy as is believed."""

    def __init__(self, places: StatePlaces, scenario: Scenario, models: MeasuredModels, **rest):
        super().__init__(LOAD, places, scenario, **rest)
        self._heights: Mapping[str, float] = {name: model.height for name, model in models.objects.items()}

    def _observe(self, context: Context, memory: Memory) -> Iterable[Violation]:
        x, progress = self._state.Eval(context), self._progress.Eval(context)
        for name in _carried(progress, tuple(self._heights)):
            off = abs(float(x[self._places.pose[name]][6]) - self._heights[name])
            if off > LIFTED and name not in self._ignored:
                what = f"{name} does not stay at the height at which it is carried"
                yield self._says(context, progress, (name,), what, value=off, limit=LIFTED, unit="m")


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
        memory.notes = closed = memory.notes or _Durations()
        for name, contact in zip(self._regions, self._closed.Eval(context), strict=True):
            if closed.lasts(name, contact > 0.5, now) >= CLOSED_TIME and name not in self._ignored:
                what = f"the door of {name} has closed"
                yield Violation(self.kind, now, self._first_step + progress.count, (name,), what)


def _carried(progress: Progress, objects: tuple[str, ...]) -> Iterator[str]:
    for index, name in enumerate(objects):
        if any(told.mode == Mode.TRANSPORT + index for told in progress.agents):
            yield name


def _key(weld: Weld) -> tuple[str, str, str]:
    return weld.agent, weld.object, weld.option


def _pose(numbers: np.ndarray) -> RigidTransform:
    """X_WO of a quaternion, which may have grown, and an origin (7,)."""
    return RigidTransform(Quaternion(numbers[:4] / np.linalg.norm(numbers[:4])), numbers[4:])
