"""LeafSystem that grasps and releases: the straight way between a stand-off and a grasp."""

from __future__ import annotations

from pydrake.systems.framework import BasicVector, Context, InputPort, LeafSystem, OutputPort

from drake_ltl.dynamics import quintic, tracking_acceleration
from drake_ltl.multibody.agent_model import AgentModel
from drake_ltl.systems.hold_controller import TRACKING_FREQUENCY
from drake_ltl.systems.signals import reach_ends


class ReachController(LeafSystem):
    """Follows a rest-to-rest quintic in joint space by computed torque.

    .. pydrake_system::

        name: ReachController
        input_ports:
        - state
        - reach
        output_ports:
        - torque

    `state` is (q, qd) (2n,); `reach` is (start time, duration, q at the start, q at the goal), see
    `signals.pack_reach`; `torque` (n,) [N, N m]. The error decays as exp(-w t), w = `frequency` [rad/s].
    """

    def __init__(self, model: AgentModel, frequency: float = TRACKING_FREQUENCY):
        super().__init__()
        self.set_name(f"reach_{model.agent.name}")
        self._model, self._frequency = model, frequency
        self._state = self.DeclareVectorInputPort("state", 2 * model.n)
        self._reach = self.DeclareVectorInputPort("reach", 2 + 2 * model.n)
        self._torque = self.DeclareVectorOutputPort("torque", model.n, self._calc_torque)

    def get_state_input_port(self) -> InputPort:
        return self._state

    def get_reach_input_port(self) -> InputPort:
        return self._reach

    def get_torque_output_port(self) -> OutputPort:
        return self._torque

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        n = self._model.n
        x, reach = self._state.Eval(context), self._reach.Eval(context)
        reference = quintic(context.get_time() - reach[0], reach[1], *reach_ends(reach))
        qdd = tracking_acceleration(x[:n], x[n:], *reference, self._frequency)
        output.SetFromVector(self._model.inverse_dynamics(x[:n], x[n:], qdd))
