"""LeafSystem that keeps an agent where it stands, with or without an object in its gripper."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import BasicVector, Context, InputPort, LeafSystem, OutputPort

from drake_ltl.dynamics import tracking_acceleration
from drake_ltl.multibody.agent_model import AgentModel

TRACKING_FREQUENCY = 10.0
"""At which agents that hold or reach return to where they should be [rad/s]."""


class HoldController(LeafSystem):
    """Computed torque towards a configuration at rest.

    .. pydrake_system::

        name: HoldController
        input_ports:
        - state
        - hold
        output_ports:
        - torque

    `state` is (q, qd) (2n,), `hold` the configuration (n,) to keep, `torque` (n,) [N, N m]. The error decays as
    exp(-w t), w = `frequency` [rad/s].
    """

    def __init__(self, model: AgentModel, frequency: float = TRACKING_FREQUENCY):
        super().__init__()
        self.set_name(f"hold_{model.agent.name}")
        self._model, self._frequency = model, frequency
        self._zero = np.zeros(model.n)
        self._state = self.DeclareVectorInputPort("state", 2 * model.n)
        self._hold = self.DeclareVectorInputPort("hold", model.n)
        self._torque = self.DeclareVectorOutputPort("torque", model.n, self._calc_torque)

    def get_state_input_port(self) -> InputPort:
        return self._state

    def get_hold_input_port(self) -> InputPort:
        return self._hold

    def get_torque_output_port(self) -> OutputPort:
        return self._torque

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        n = self._model.n
        x, hold = self._state.Eval(context), self._hold.Eval(context)
        qdd = tracking_acceleration(x[:n], x[n:], hold, self._zero, self._zero, self._frequency)
        output.SetFromVector(self._model.inverse_dynamics(x[:n], x[n:], qdd))
