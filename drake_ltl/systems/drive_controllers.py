"""LeafSystems of a differential drive among other agents: one that travels, one that holds."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import BasicVector, Context, InputPort, LeafSystem, OutputPort

from drake_ltl.multibody.drive_agent import DriveAgent
from drake_ltl.systems.drive_law import DriveLaw
from drake_ltl.systems.hold_controller import TRACKING_FREQUENCY, HoldController


class DriveController(LeafSystem):
    """(U2) to (U4): along the force of the navigation function, or on the spot.

    .. pydrake_system::

        name: DriveController
        input_ports:
        - state
        - gradient
        - course
        output_ports:
        - torque

    `state` is (q, qd) (16,), `gradient` k dPhi/dq (8,), `course` (9,) the stage and the configuration of the goal, see
    `signals.pack_course`; `torque` (8,) [N m] is zero but for the wheels.
    """

    def __init__(self, model: DriveAgent, speed_limit: float = np.inf):
        """Damping grows beyond `speed_limit` [m/s]."""
        super().__init__()
        self.set_name(f"transition_{model.agent.name}")
        self._law, self._n = DriveLaw(model, TRACKING_FREQUENCY, speed_limit), model.n
        self._state = self.DeclareVectorInputPort("state", 2 * model.n)
        self._gradient = self.DeclareVectorInputPort("gradient", model.n)
        self._course = self.DeclareVectorInputPort("course", 1 + model.n)
        self._torque = self.DeclareVectorOutputPort("torque", model.n, self._calc_torque)

    def get_state_input_port(self) -> InputPort:
        return self._state

    def get_gradient_input_port(self) -> InputPort:
        return self._gradient

    def get_course_input_port(self) -> InputPort:
        return self._course

    def get_torque_output_port(self) -> OutputPort:
        return self._torque

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        x, course, n = self._state.Eval(context), self._course.Eval(context), self._n
        gradient = self._gradient.Eval(context)
        output.SetFromVector(self._law.travel(x[:n], x[n:], gradient, int(course[0]), course[1:]))


class DriveHoldController(HoldController):
    """Keeps a differential drive where it stands.

    .. pydrake_system::

        name: DriveHoldController
        input_ports:
        - state
        - hold
        output_ports:
        - torque

    `state` is (q, qd) (16,), `hold` the configuration (8,) to keep, `torque` (8,) [N m] is zero but for the wheels.
    """

    def __init__(self, model: DriveAgent):
        super().__init__(model)
        self._law = DriveLaw(model, TRACKING_FREQUENCY, np.inf)

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        x, n = self.get_state_input_port().Eval(context), self._model.n
        output.SetFromVector(self._law.hold(x[:n], x[n:], self.get_hold_input_port().Eval(context)))
