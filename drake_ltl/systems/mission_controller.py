"""LeafSystem of all control laws at once: the torques of every agent in one evaluation, and V.

The laws are those of `HoldController`, `ReachController`, `TransitionController` and `TransportController` with their
`NavigationField`, by the same functions of `drake_ltl.dynamics` and `field_value`. What each of those systems asks of a
model for itself, this one asks once for all, of one plant: a simulation takes a fraction of the time.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import hypot, isfinite
from typing import NamedTuple

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, Context, InputPort, LeafSystem, OutputPort

from drake_ltl.dynamics import (
    body_gravity,
    check_load_shares,
    growing_damping,
    quintic,
    team_wrench,
    tracking_acceleration,
    transition_torque,
    transport_torque,
)
from drake_ltl.dynamics.null_space import PostureSpring
from drake_ltl.errors import ExecutionError
from drake_ltl.multibody.crew import CrewModel
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.drive_law import DriveLaw
from drake_ltl.systems.field_value import REST, FieldValue, evaluate_field
from drake_ltl.systems.hold_controller import TRACKING_FREQUENCY
from drake_ltl.systems.latest_field import LatestField
from drake_ltl.systems.posture_springs import PostureSprings
from drake_ltl.systems.program import MissionProgram
from drake_ltl.systems.progress import AgentSignals, Progress
from drake_ltl.systems.signals import Mode, Stage, pack_step, reach_ends
from drake_ltl.systems.state_places import StatePlaces, span
from drake_ltl.systems.step_field import StepField


@dataclass(frozen=True)
class Carrier:
    """An agent of a team under way."""

    object: str
    share: float
    """c_tau."""
    spring: PostureSpring | None
    """Of a redundant agent."""


@dataclass(frozen=True)
class Drive:
    """A differential drive."""

    rows: slice
    law: DriveLaw
    hold: np.ndarray
    """Where it holds (8,)."""
    goal: np.ndarray | None = None
    """Where it travels to (8,), if it does."""
    stage: int = Stage.PARKED

    def torques(self, q: np.ndarray, qd: np.ndarray, gradient: np.ndarray | None) -> np.ndarray:
        """(8,) while k dPhi/dq is `gradient` (8,), None if it does not travel."""
        if gradient is None or self.goal is None:
            return self.law.hold(q, qd, self.hold)
        return self.law.travel(q, qd, gradient, self.stage, self.goal)


@dataclass(frozen=True)
class Orders:
    """All that is constant of the control laws while the supervisor's Progress stays. Arrays are stacked (n,)."""

    field: StepField | None
    travels: dict[str, slice]
    """Travellers, with their rows."""
    carried: tuple[str, ...]
    """Objects."""
    carriers: dict[str, Carrier]
    damping: np.ndarray
    """Diagonal of K of travellers' joints, else 0."""
    frequency: np.ndarray
    """Of joints of agents that hold [rad/s], else 0."""
    hold: np.ndarray
    """Where these joints are to stay."""
    reaches: dict[str, np.ndarray]
    """agent -> signals.pack_reach."""
    tracking: np.ndarray
    """1 for joints of agents that hold or reach, else 0."""
    moving: np.ndarray
    """1 for joints whose kinetic energy counts in V, else 0."""
    drives: dict[str, Drive]
    """Differential drives."""


class MissionController(LeafSystem):
    """All control laws of a mission, and the Lyapunov function V of what moves under phi.

    .. pydrake_system::

        name: MissionController
        input_ports:
        - state
        - progress
        output_ports:
        - torque
        - lyapunov
        - controls

    `state` is the plant's whole state (positions and velocities of everything), `progress` the supervisor's Progress;
    `torque` stacks tau_i (n_i,) [N, N m] of all agents, `lyapunov` is V [J], see `NavigationField`; `controls` is
    both in one vector, for monitors. V is worked out when it is asked for, which no step of a plant does.
    """

    def __init__(self, places: StatePlaces, program: MissionProgram, scenario: Scenario, models: MeasuredModels):
        """`places` says what is where in the signal `state`."""
        super().__init__()
        self.set_name("mission_controller")
        self._places, self._crew = places, CrewModel(scenario.agents)
        self._q, self._qd = span(places.q), span(places.qd)
        self._program, self._models, self._settings = program, models, scenario.controller
        self._latest, self._springs = LatestField(program, scenario, models), PostureSprings(models.agents)
        settings = scenario.controller
        self._damping = {
            name: model.damping(settings.base_damping, settings.arm_damping) for name, model in models.agents.items()
        }
        self._drive_laws = {
            name: DriveLaw(model, TRACKING_FREQUENCY, settings.speed_limit)
            for name, model in models.agents.items()
            if not model.has_arm
        }
        self._team_damping = np.repeat([settings.team_rotation_damping, settings.team_damping], 3)
        self._object_gravity = {name: body_gravity(model.mass) for name, model in models.objects.items()}
        self._latest_orders: tuple[Progress | None, Orders | None] = (None, None)
        self._state = self.DeclareVectorInputPort("state", places.size)
        self._progress = self.DeclareAbstractInputPort("progress", Value[object]())
        inputs, n = {self.all_input_ports_ticket(), self.time_ticket()}, self._crew.n
        self._torque = self.DeclareVectorOutputPort("torque", n, self._calc_torque, inputs)
        self._lyapunov = self.DeclareVectorOutputPort("lyapunov", 1, self._calc_lyapunov, inputs)
        self._controls = self.DeclareVectorOutputPort("controls", n + 1, self._calc_controls, inputs)

    def get_state_input_port(self) -> InputPort:
        return self._state

    def get_progress_input_port(self) -> InputPort:
        return self._progress

    def get_torque_output_port(self) -> OutputPort:
        return self._torque

    def get_lyapunov_output_port(self) -> OutputPort:
        return self._lyapunov

    def get_controls_output_port(self) -> OutputPort:
        return self._controls

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        x, orders, time = self._state.Eval(context), self._orders_of(self._progress.Eval(context)), context.get_time()
        if not isfinite(sum(x.tolist())) and (names := self._places.not_finite(x)):
            # a plant's own check would end the process
            raise ExecutionError(f"the state of {', '.join(names)} is not finite at t = {time:.3f} s")
        q, qd = x[self._q], x[self._qd]
        torque, field = self._torques(time, orders, q, qd, x)
        for name, drive in orders.drives.items():
            torque[drive.rows] = drive.torques(q[drive.rows], qd[drive.rows], field.agents.get(name))
        output.SetFromVector(torque)

    def _calc_lyapunov(self, context: Context, output: BasicVector) -> None:
        x, orders = self._state.Eval(context), self._orders_of(self._progress.Eval(context))
        output.SetAtIndex(0, self._energy(orders, x[self._q], x[self._qd], x))

    def _calc_controls(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(np.append(self._torque.Eval(context), self._lyapunov.Eval(context)))

    def _torques(
        self, time: float, orders: Orders, q: np.ndarray, qd: np.ndarray, x: np.ndarray
    ) -> tuple[np.ndarray, FieldValue]:
        """(n,) of all agents but differential drives, and what moves them all."""
        crew = self._crew
        torque = self._tracking_torque(time, orders, q, qd)
        if orders.field is None:
            return torque, REST
        world = self._world(orders, q, x)
        field = evaluate_field(orders.field, self._settings.force, self._models.agents, world)
        if orders.travels:
            torque = self._transition(orders, torque, field, qd)
        V_WO = {name: x[self._places.velocity[name]] for name in field.objects}
        wrenches = {name: self._wrench(name, gradient, V_WO[name]) for name, gradient in field.objects.items()}
        for name, carrier in orders.carriers.items():
            rows, J = crew.rows[name], crew.grasp_jacobian(name)
            p_OoEo_W = crew.grasp_position(name) - world.poses[carrier.object][4:]
            tau = transport_torque(carrier.share, wrenches[carrier.object], p_OoEo_W, J, torque[rows])
            if carrier.spring is not None:
                tau += carrier.spring.torque(q[rows], qd[rows], J)
            torque[rows] = tau
        return torque, field

    def _energy(self, orders: Orders, q: np.ndarray, qd: np.ndarray, x: np.ndarray) -> float:
        """V [J]."""
        if orders.field is None:
            return 0.0
        self._crew.set_state(q, qd * orders.moving)
        world = self._world(orders, q, x)
        energy = evaluate_field(orders.field, self._settings.force, self._models.agents, world).potential
        for name, carrier in orders.carriers.items():
            if carrier.spring is not None:
                energy += carrier.spring.energy(q[self._crew.rows[name]], self._crew.grasp_jacobian(name))
        for name, pose in world.poses.items():
            V_WO = x[self._places.velocity[name]]
            energy += self._models.objects[name].kinetic_energy(pose[:4], V_WO)
        for name, drive in orders.drives.items():
            if drive.goal is not None:
                energy += self._models.agents[name].energy(q[drive.rows], qd[drive.rows])
        return energy + self._crew.kinetic_energy()

    def _world(self, orders: Orders, q: np.ndarray, x: np.ndarray) -> _World:
        return _World(self._crew, q, {name: x[self._places.pose[name]] for name in orders.carried})

    def _transition(self, orders: Orders, gravity: np.ndarray, field: FieldValue, qd: np.ndarray) -> np.ndarray:
        """(10a) of all travellers at once; what others have instead of gravity stays as it is."""
        gradient, damping, limit = np.zeros(len(qd)), orders.damping, self._settings.speed_limit
        for name, rows in orders.travels.items():
            gradient[rows] = field.agents[name]
            vx, vy, *_ = qd[rows].tolist()
            if (speed := hypot(vx, vy)) > limit:
                damping = damping.copy()
                damping[rows] = growing_damping(damping[rows], speed, limit)
        return transition_torque(gravity, gradient, damping, qd)

    def _wrench(self, name: str, gradient: np.ndarray, V_WO: np.ndarray) -> np.ndarray:
        """What a team shares of (10b)."""
        damping = growing_damping(self._team_damping, hypot(*V_WO[3:].tolist()), self._settings.speed_limit)
        return team_wrench(self._object_gravity[name], gradient, damping, V_WO)

    def _tracking_torque(self, time: float, orders: Orders, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
        """Computed torques of those who hold or reach, g_q of all others. Leaves the crew at q."""
        self._crew.set_state(q, qd * orders.tracking)
        qdd = tracking_acceleration(q, qd, orders.hold, 0.0, 0.0, orders.frequency)
        for name, reach in orders.reaches.items():
            rows, reference = self._crew.rows[name], quintic(time - reach[0], reach[1], *reach_ends(reach))
            qdd[rows] = tracking_acceleration(q[rows], qd[rows], *reference, TRACKING_FREQUENCY)
        return self._crew.inverse_dynamics(qdd)

    def _orders_of(self, progress: Progress) -> Orders:
        """A pure function of the progress, kept for as long as this stays."""
        if self._latest_orders[0] is not progress:
            self._latest_orders = (progress, self._form_orders(progress))
        return self._latest_orders[1]

    def _form_orders(self, progress: Progress) -> Orders:
        signals = dict(zip(self._models.agents, progress.agents, strict=True))
        step = pack_step(self._program.index(progress.count), progress.phase, progress.interval, progress.leg)
        reaches = {name: signals[name].reach for name in self._latest.reaching(step)}
        field = self._latest.of(step, progress.anchor, reaches)
        travels = {task.agent: self._crew.rows[task.agent] for task in field.travels} if field is not None else {}
        carriers = self._carriers(field, self._latest.snapshot(progress.anchor).q)
        drives = {name: self._drive(name, told, field) for name, told in signals.items() if name in self._drive_laws}
        travels = {name: rows for name, rows in travels.items() if name not in drives}
        with_arms = {name: told for name, told in signals.items() if name not in drives}
        in_mode = {mode: [n for n, told in with_arms.items() if told.mode == mode] for mode in (Mode.HOLD, Mode.REACH)}
        return Orders(
            field=field,
            travels=travels,
            carried=tuple(task.object for task in field.transports) if field is not None else (),
            carriers=carriers,
            damping=self._mask(travels) * np.concatenate([*self._damping.values()]),
            frequency=TRACKING_FREQUENCY * self._mask(in_mode[Mode.HOLD]),
            hold=np.concatenate([told.hold for told in signals.values()]),
            reaches={name: signals[name].reach for name in in_mode[Mode.REACH]},
            tracking=self._mask([*in_mode[Mode.HOLD], *in_mode[Mode.REACH]]),
            moving=self._mask([*travels, *carriers]),
            drives=drives,
        )

    def _drive(self, name: str, told: AgentSignals, field: StepField | None) -> Drive:
        rows, law = self._crew.rows[name], self._drive_laws[name]
        goals = [task.q_goal for task in field.travels if task.agent == name] if field is not None else []
        return Drive(rows, law, told.hold, *((goals[0], told.stage) if goals else ()))

    def _carriers(self, field: StepField | None, anchor: Mapping[str, np.ndarray]) -> dict[str, Carrier]:
        carriers = {}
        for task in field.transports if field is not None else ():
            check_load_shares(task.shares)
            shares = dict(zip(self._models.agents, task.shares.tolist(), strict=True))
            for name in task.team:
                springy = self._models.agents[name].is_redundant
                spring = self._springs.of(name, anchor[name]) if springy else None
                carriers[name] = Carrier(task.object, shares[name], spring)
        return carriers

    def _mask(self, agents: Iterable[str]) -> np.ndarray:
        mask = np.zeros(self._crew.n)
        for name in agents:
            mask[self._crew.rows[name]] = 1.0
        return mask


class _World(NamedTuple):
    """Kinematics of the crew and its loads."""

    crew: CrewModel
    stacked: np.ndarray
    poses: Mapping[str, np.ndarray]

    def q(self, name: str) -> np.ndarray:
        return self.poses[name] if name in self.poses else self.stacked[self.crew.rows[name]]

    def centre(self, agent: str) -> np.ndarray:
        return self.crew.centre(agent)

    def centre_jacobian(self, agent: str) -> np.ndarray:
        return self.crew.centre_jacobian(agent)
