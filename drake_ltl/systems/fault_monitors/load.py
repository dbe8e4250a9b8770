"""Loads that are not as heavy as is believed: weighed, while they are carried, by virtual work.

Let all who carry an object move it straight up, in thought, at 1 m/s: at joint rates u_i with J_i u_i = e_z. Nothing
turns, so that grasps do no work whatever grippers push against each other. With r_i = tau_i - (B_i qdd_i + N_i qd_i +
g_i), what the torques do beyond moving the carriers themselves,

    sum_i u_i . r_i + N = m (g + a_z),

N >= 0 what the floor bears. Off the floor this is the mass; on it, where it is a bound from below, it tells what is too
heavy to be lifted.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix
from pydrake.systems.framework import Context, InputPort

from drake_ltl.dynamics import GRAVITY
from drake_ltl.faults.losses import LOAD
from drake_ltl.monitoring.violation import Violation
from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.multibody.object_model import ObjectModel
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.fault_monitors.fault_monitor import Durations, FaultMonitor
from drake_ltl.systems.fault_monitors.motion import STANDSTILL
from drake_ltl.systems.fault_monitors.residual import Look, Residuals
from drake_ltl.systems.monitors.monitor import Memory
from drake_ltl.systems.progress import Progress
from drake_ltl.systems.signals import Mode
from drake_ltl.systems.state_places import StatePlaces

OFF = 0.15
"""A load weighs more or less than is believed by this share of it ..."""
OFF_TIME = 0.25
"""... for so long [s]: a fault of a carrier is noticed sooner ..."""
WINDOW = 0.25
"""... in the mean over so long [s]."""
ALOFT = 0.01
"""What is so far above the floor [m] is borne by its carriers alone."""
STUCK_TIME = 1.0
"""What is not off the floor though its carriers' arms have given all their torque for so long [s] is too heavy."""
STRAIGHT = 1e-6
"""How far u_i may be from moving the gripper straight up [-]."""
STOP = 0.05
"""A joint this near to one of its limits may be held by its stop [rad]: arms that carry keep twice as far away."""


@dataclass(frozen=True)
class _Weight:
    """What was seen of a load between two looks."""

    lift: float
    """sum_i u_i . r_i [N]"""
    acceleration: float
    """a_z [m/s^2]"""
    aloft: bool


@dataclass
class _Notes:
    """The last look, the latest weights of each object, and for how long they have been off or it has not risen."""

    look: Look
    weights: dict[str, deque[_Weight]] = field(default_factory=dict)
    off: Durations = field(default_factory=Durations)
    stuck: Durations = field(default_factory=Durations)


class LoadMonitor(FaultMonitor):
    """Loads that are not as heavy as is believed. Also takes `delivered`, the torques of all drives as their current
    sensors have them, and `age` of the state."""

    def __init__(self, places: StatePlaces, scenario: Scenario, models: MeasuredModels, **rest):
        super().__init__(LOAD, places, scenario, **rest)
        self._objects: Mapping[str, ObjectModel] = models.objects
        self._residuals = Residuals(places, scenario, models)
        self._delivered = self.DeclareVectorInputPort("delivered", places.q.size)
        self._age = self.DeclareVectorInputPort("age", 1)

    def get_delivered_input_port(self) -> InputPort:
        return self._delivered

    def get_age_input_port(self) -> InputPort:
        return self._age

    def _observe(self, context: Context, memory: Memory) -> Iterable[Violation]:
        progress, notes = self._progress.Eval(context), memory.notes
        torque, age = self._delivered.Eval(context), float(self._age.Eval(context)[0])
        before: Look | None = None if notes is None else notes.look
        look = self._residuals.look(before, progress, self._state.Eval(context), torque, age)
        if before is None:
            memory.notes = _Notes(look)
            return
        notes.look = look
        yield from self._stuck(context, notes.stuck, look)
        if look.acted is None:
            return
        seen = dict(self._weights(before, look))
        for name, model in self._objects.items():
            weights = notes.weights.setdefault(name, deque(maxlen=round(WINDOW / self.period)))
            if name not in seen:
                weights.clear()
            else:
                weights.append(seen[name])
            mass = _mass(weights, model.borne_mass)
            off = mass is not None and abs(mass - model.borne_mass) > OFF * model.borne_mass
            if notes.off.lasts(name, off, context.get_time()) >= OFF_TIME and name not in self._ignored:
                what = f"{name} does not weigh {model.borne_mass:.3g} kg, as is believed"
                yield self._says(context, progress, (name,), what, value=mass, unit="kg")

    def _stuck(self, context: Context, stuck: Durations, look: Look) -> Iterator[Violation]:
        """With a torque at its limit an arm may lean on the load instead of lifting it, and weigh too little."""
        full = np.abs(look.torques[-1]) >= self._residuals.limits
        for index, name in enumerate(self._objects):
            arms = [
                full[self._residuals.crew.rows[a]][NUM_BASE_JOINTS:]
                for a in _team(look.progress, self._places.agents, index)
            ]
            grounded = any(arm.any() for arm in arms) and not self._is_aloft(name, look)
            if stuck.lasts(name, grounded, context.get_time()) >= STUCK_TIME and name not in self._ignored:
                what = f"{name} is not lifted by all the torque that its carriers have"
                yield self._says(context, look.progress, (name,), what)

    def _is_aloft(self, name: str, look: Look) -> bool:
        return _lowest(self._objects[name], look.x[self._places.pose[name]]) > ALOFT

    def _weights(self, before: Look, look: Look) -> Iterator[tuple[str, _Weight]]:
        """Of every object that is carried by agents whose torques are all that moves them."""
        teams = {name: _team(look.progress, self._places.agents, i) for i, name in enumerate(self._objects)}
        if not any(teams.values()):
            return
        residual, near_stops = self._residuals.between(before, look), self._residuals.near_stops(before, STOP)
        for name, team in teams.items():
            lifts = [self._lift(agent, before, residual, near_stops) for agent in team]
            if team and None not in lifts:
                vz = [x[self._places.velocity[name]][5] for x in (before.x, look.x)]
                acceleration = float(vz[1] - vz[0]) / self.period
                yield name, _Weight(sum(lifts), acceleration, self._is_aloft(name, before))

    def _lift(self, agent: str, before: Look, residual: np.ndarray, near_stops: np.ndarray) -> float | None:
        """u_i . r_i [N]; None if there is no u_i, or something else than torques may act on the joints it moves."""
        rows, J = self._residuals.crew.rows[agent], self._residuals.crew.grasp_jacobian(agent)
        up = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        u = np.linalg.lstsq(J, up, rcond=1e-9)[0]
        still = np.abs(before.x[self._places.qd][rows]).max() < STANDSTILL
        held = still or bool((near_stops[rows] & (np.abs(u) > STRAIGHT)).any())
        return None if held or np.abs(J @ u - up).max() > STRAIGHT else -float(u @ residual[rows])


def _mass(weights: deque[_Weight], believed: float) -> float | None:
    """[kg]; None if nothing is known yet. Of what touches the floor only that it is heavier can be known, and that
    something else draws at it of what weighs nothing."""
    if len(weights) < weights.maxlen:
        return None
    lift = float(np.mean([weight.lift for weight in weights]))
    mass = lift / (GRAVITY + float(np.mean([weight.acceleration for weight in weights])))
    return mass if mass > believed or (mass > 0.0 and all(weight.aloft for weight in weights)) else None


def _team(progress: Progress, agents: Iterable[str], obj: int) -> list[str]:
    """Who carries object number `obj`."""
    return [name for name, told in zip(agents, progress.agents, strict=True) if told.mode == Mode.TRANSPORT + obj]


def _lowest(model: ObjectModel, pose: np.ndarray) -> float:
    """z of the lowest point of an object [m]; its quaternion may have grown."""
    R_WO = RotationMatrix(Quaternion(pose[:4] / np.linalg.norm(pose[:4]))).matrix()
    return float((pose[6] + model.balls_O[:, :3] @ R_WO[2] - model.balls_O[:, 3]).min())
