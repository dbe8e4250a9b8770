"""LeafSystem of all control laws at once: the torques of every agent in one evaluation, and V.

The laws are those of `HoldController`, `ReachController`, `TransitionController` and `TransportController` with their
`NavigationField`, by the same functions of `drake_ltl.dynamics` and `field_value`. What each of those systems asks of a
model for itself, this one asks once for all, of one plant: a simulation takes a fraction of the time. Of
safe mode those systems know nothing: there who holds an object has its share of the load in its computed torque.
"""

from __future__ import annotations

from functools import partial
from math import hypot, isfinite
from typing import NamedTuple

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, Context, InputPort, LeafSystem, OutputPort

from drake_ltl.dynamics import (
    body_gravity,
    growing_damping,
    quintic,
    team_wrench,
    tracking_acceleration,
    transition_torque,
    transport_torque,
)
from drake_ltl.errors import ExecutionError
from drake_ltl.multibody.crew import CrewModel
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.field_value import REST, FieldValue, evaluate_field
from drake_ltl.systems.hold_controller import TRACKING_FREQUENCY
from drake_ltl.systems.orders import Bearer, LatestOrders, Load, Orders
from drake_ltl.systems.program import MissionProgram
from drake_ltl.systems.signals import reach_ends
from drake_ltl.systems.state_places import StatePlaces, span


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
        self._models, self._settings = models, scenario.controller
        self._orders = LatestOrders(program, scenario, models, self._crew.rows)
        self._object_gravity = {name: body_gravity(model.borne_mass) for name, model in models.objects.items()}
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
        x, orders = self._state.Eval(context), self._orders.of(self._progress.Eval(context))
        if not isfinite(sum(x.tolist())) and (names := self._places.not_finite(x)):
            # a plant's own check would end the process
            raise ExecutionError(f"the state of {', '.join(names)} is not finite at t = {context.get_time():.3f} s")
        q, qd = x[self._q], x[self._qd]
        torque, field = self._torques(context, orders, q, qd, x)
        for name, drive in orders.drives.items():
            torque[drive.rows] = drive.torques(q[drive.rows], qd[drive.rows], field.agents.get(name))
        output.SetFromVector(torque)

    def _calc_lyapunov(self, context: Context, output: BasicVector) -> None:
        x, orders = self._state.Eval(context), self._orders.of(self._progress.Eval(context))
        output.SetAtIndex(0, self._energy(orders, x[self._q], x[self._qd], x))

    def _calc_controls(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(np.append(self._torque.Eval(context), self._lyapunov.Eval(context)))

    def _torques(
        self, context: Context, orders: Orders, q: np.ndarray, qd: np.ndarray, x: np.ndarray
    ) -> tuple[np.ndarray, FieldValue]:
        """(n,) of all agents but differential drives, and what moves them all."""
        torque = self._tracking_torque(context, orders, q, qd, x)
        if orders.field is None:
            return torque, REST
        world = _World(self._crew, self._places, q, x)
        field = evaluate_field(orders.field, self._settings.force, self._models.agents, world)
        if orders.travels:
            torque = self._transition(orders, torque, field, qd)
        for load in orders.loads:
            self._carry(load, field.objects[load.object], torque, q, qd, x)
        return torque, field

    def _carry(
        self, load: Load, gradient: np.ndarray, torque: np.ndarray, q: np.ndarray, qd: np.ndarray, x: np.ndarray
    ) -> None:
        """(10b): adds what carries the load to the team's torques (n,)."""
        crew, places, name = self._crew, self._places, load.object
        F_O, p_WO = self._wrench(load, gradient, x[places.velocity[name]]), x[places.pose[name]][4:]
        for carrier in load.carriers:
            rows, J = carrier.rows, crew.grasp_jacobian(carrier.agent)
            p_OoEo_W = crew.grasp_position(carrier.agent) - p_WO
            tau = transport_torque(carrier.share, F_O, p_OoEo_W, J, torque[rows])
            if carrier.spring is not None:
                tau += carrier.spring.torque(q[rows], qd[rows], J)
            torque[rows] = tau

    def _bear(self, bearer: Bearer, qdd: np.ndarray, torque: np.ndarray, x: np.ndarray) -> None:
        """Computed torque of what is held: adds a share of what lets the object move as its gripper is to."""
        rows, J = bearer.rows, self._crew.grasp_jacobian(bearer.agent)
        pose = x[self._places.pose[bearer.object]]
        p_OoEo_W, A_WE = self._crew.grasp_position(bearer.agent) - pose[4:], J @ qdd[rows]
        A_WO = np.concatenate([A_WE[:3], A_WE[3:] + np.cross(p_OoEo_W, A_WE[:3])])
        F_O = self._object_gravity[bearer.object] + self._models.objects[bearer.object].inertial_wrench(pose[:4], A_WO)
        torque[rows] = transport_torque(bearer.share, F_O, p_OoEo_W, J, torque[rows])

    def _energy(self, orders: Orders, q: np.ndarray, qd: np.ndarray, x: np.ndarray) -> float:
        """V [J]."""
        if orders.field is None:
            return 0.0
        self._crew.set_state(q, qd * orders.moving)
        world = _World(self._crew, self._places, q, x)
        energy = evaluate_field(orders.field, self._settings.force, self._models.agents, world).potential
        for load in orders.loads:
            pose, V_WO = x[self._places.pose[load.object]], x[self._places.velocity[load.object]]
            energy += self._models.objects[load.object].kinetic_energy(pose[:4], V_WO)
            for carrier in load.carriers:
                if carrier.spring is not None:
                    energy += carrier.spring.energy(q[carrier.rows], self._crew.grasp_jacobian(carrier.agent))
        for name, drive in orders.drives.items():
            if drive.goal is not None:
                energy += self._models.agents[name].energy(q[drive.rows], qd[drive.rows])
        return energy + self._crew.kinetic_energy()

    def _transition(self, orders: Orders, gravity: np.ndarray, field: FieldValue, qd: np.ndarray) -> np.ndarray:
        """(10a) of all travellers at once; what others have instead of gravity stays as it is."""
        gradient, damping, velocity = np.zeros((3, len(qd)))
        for traveller in orders.travels:
            name, rows = traveller.agent, traveller.rows
            gradient[rows] = slope = field.agents[name]
            damping[rows], velocity[rows] = traveller.damping.at(slope, qd[rows], partial(self._crew.inertia, name))
        return transition_torque(gravity, gradient, damping, velocity)

    def _wrench(self, load: Load, gradient: np.ndarray, V_WO: np.ndarray) -> np.ndarray:
        """What a team shares of (10b)."""
        damping = growing_damping(load.damping, hypot(*V_WO[3:].tolist()), self._settings.speed_limit)
        return team_wrench(self._object_gravity[load.object], gradient, damping, V_WO)

    def _tracking_torque(
        self, context: Context, orders: Orders, q: np.ndarray, qd: np.ndarray, x: np.ndarray
    ) -> np.ndarray:
        """Computed torques of those who hold or reach, g_q of all others. Leaves the crew at q."""
        self._crew.set_state(q, qd * orders.tracking)
        qdd = tracking_acceleration(q, qd, orders.hold, 0.0, 0.0, orders.frequency)
        for name, reach in orders.reaches.items():
            rows, since = self._crew.rows[name], context.get_time() - reach[0]
            reference = quintic(since, reach[1], *reach_ends(reach))
            qdd[rows] = tracking_acceleration(q[rows], qd[rows], *reference, TRACKING_FREQUENCY)
        torque = self._crew.inverse_dynamics(qdd)
        for bearer in orders.bearers:
            self._bear(bearer, qdd, torque, x)
        return torque


class _World(NamedTuple):
    """Kinematics of the crew and its loads."""

    crew: CrewModel
    places: StatePlaces
    stacked: np.ndarray
    x: np.ndarray

    def q(self, name: str) -> np.ndarray:
        rows = self.crew.rows.get(name)
        return self.x[self.places.pose[name]] if rows is None else self.stacked[rows]

    def centre(self, agent: str) -> np.ndarray:
        return self.crew.centre(agent)

    def centre_jacobian(self, agent: str) -> np.ndarray:
        return self.crew.centre_jacobian(agent)
