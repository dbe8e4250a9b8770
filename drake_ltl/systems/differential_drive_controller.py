"""LeafSystem of the control law (U2) to (U4): a differential drive goes to its goal pose."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    EventStatus,
    InputPort,
    LeafSystem,
    OutputPort,
)

from drake_ltl.multibody.differential_drive_model import DifferentialDriveModel, PlanarState
from drake_ltl.navigation.dipole import Dipole, heading_vector
from drake_ltl.navigation.unicycle import (
    UnicycleGains,
    direction_of_force,
    drive_force,
    is_at_rest,
    is_parked,
    sense_of_travel,
    steering_torque,
    wheel_torques,
)

PERIOD = 0.01
"""Between looks at whether the drive has come near enough to park [s]."""


class DifferentialDriveController(LeafSystem):
    """Wheel torques that drive along f and turn to it, or to the goal's heading once there.

    .. pydrake_system::

        name: DifferentialDriveController
        input_ports:
        - state
        - force
        output_ports:
        - torque
        - stage

    `state` is the model instance's (q, v), `force` is f = -k dPhi/dp (2,) [N] in W, `torque` (2,) [N m] is in the order
    of the file's actuators and never above their effort limit. `stage` (2,) is (sense, parked), the system's discrete
    state: 1 forwards or -1 backwards, chosen whenever the drive sets out, and 1 or 0.
    """

    def __init__(self, model: DifferentialDriveModel, goal: Dipole, gains: UnicycleGains):
        super().__init__()
        self.set_name(f"drive_{model.name}")
        self._model, self._goal, self._gains = model, goal, gains
        self._state = self.DeclareVectorInputPort("state", model.num_states)
        self._force = self.DeclareVectorInputPort("force", 2)
        stage = self.DeclareDiscreteState(2)
        self.DeclareInitializationDiscreteUpdateEvent(self._set_out)
        self.DeclarePeriodicDiscreteUpdateEvent(period_sec=PERIOD, offset_sec=0.0, update=self._look)
        self._torque = self.DeclareVectorOutputPort("torque", 2, self._calc_torque)
        self._stage = self.DeclareStateOutputPort("stage", stage)

    def get_state_input_port(self) -> InputPort:
        return self._state

    def get_force_input_port(self) -> InputPort:
        return self._force

    def get_torque_output_port(self) -> OutputPort:
        return self._torque

    def get_stage_output_port(self) -> OutputPort:
        return self._stage

    def _planar(self, context: Context) -> PlanarState:
        return self._model.planar_state(self._state.Eval(context))

    def _set_out(self, context: Context, discrete: DiscreteValues) -> EventStatus:
        at, goal = self._planar(context), self._goal
        sense = sense_of_travel(at.theta, at.p, np.array(goal.p_goal), goal.heading)
        discrete.set_value([float(sense), 0.0])
        return EventStatus.Succeeded()

    def _look(self, context: Context, discrete: DiscreteValues) -> EventStatus:
        sense, was_parked = context.get_discrete_state_vector().value()
        at, goal, gains = self._planar(context), self._goal, self._gains
        at_rest = is_at_rest(at.theta, at.v, at.omega, goal.heading, gains)
        parked = is_parked(was_parked, at_rest, goal.value(at.p), gains)
        if was_parked and not parked:
            return self._set_out(context, discrete)
        discrete.set_value([sense, float(parked)])
        return EventStatus.Succeeded()

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        at, f, gains, model = self._planar(context), self._force.Eval(context), self._gains, self._model
        sense, parked = context.get_discrete_state_vector().value()
        u = heading_vector(self._goal.heading) if parked else direction_of_force(f, sense, gains.softness)
        F = drive_force(at.theta, at.v, f, gains.drive_damping)
        tau = steering_torque(at.theta, at.omega, u, gains)
        output.SetFromVector(
            model.actuation(*wheel_torques(float(F), float(tau), model.wheel_radius, model.half_track, model.effort))
        )
