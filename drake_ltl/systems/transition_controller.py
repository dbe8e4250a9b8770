"""LeafSystem of the control law (10a): an agent travels under the navigation function."""

from __future__ import annotations

import numpy as np
from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import BasicVector, Context, InputPort, LeafSystem_, OutputPort
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_ltl.dynamics import MAX_GROWTH, growing_damping, speed_of, transition_torque
from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS, AgentModel
from drake_ltl.multibody.autodiff_agent import agent_for


@TemplateSystem.define("TransitionController_", T_list=[float, AutoDiffXd])
def TransitionController_(T):
    class Impl(LeafSystem_[T]):
        """tau_z = g_q(q) - grad_q psi - K_z qd.

        .. pydrake_system::

            name: TransitionController
            input_ports:
            - state
            - gradient
            output_ports:
            - torque

        `state` is (q, qd) (2n,), `gradient` k dPhi/dq (n,), `torque` (n,) [N, N m]. It may be converted to
        AutoDiffXd.
        """

        def _construct(
            self,
            model: AgentModel,
            damping: np.ndarray,
            speed_limit: float = np.inf,
            most_growth: float = MAX_GROWTH,
            *,
            converter=None,
        ):
            """`damping` is the diagonal (n,) of K_z [N s/m, N m s/rad], all positive; it grows beyond `speed_limit`
            of the base [m/s], at most `most_growth` times, see `dynamics.growing_damping`."""
            LeafSystem_[T].__init__(self, converter)
            self.set_name(f"transition_{model.agent.name}")
            if damping.shape != (model.n,) or not np.all(damping > 0.0):
                raise ValueError(f"damping must be {model.n} positive numbers, not {damping!r}")
            self._model, self._damping = model, damping
            self._speed_limit, self._most_growth = speed_limit, most_growth
            self._agent = agent_for(T, model)
            self._state = self.DeclareVectorInputPort("state", 2 * model.n)
            self._gradient = self.DeclareVectorInputPort("gradient", model.n)
            self._torque = self.DeclareVectorOutputPort("torque", model.n, self._calc_torque)

        def _construct_copy(self, other, converter=None):
            Impl._construct(
                self, other._model, other._damping, other._speed_limit, other._most_growth, converter=converter
            )

        def get_state_input_port(self) -> InputPort:
            return self._state

        def get_gradient_input_port(self) -> InputPort:
            return self._gradient

        def get_torque_output_port(self) -> OutputPort:
            return self._torque

        def _calc_torque(self, context: Context, output: BasicVector) -> None:
            n = self._model.n
            x = self._state.Eval(context)
            gradient = self._gradient.Eval(context)
            speed = speed_of(x[n : n + NUM_BASE_JOINTS])
            damping = growing_damping(self._damping, speed, self._speed_limit, self._most_growth)
            output.SetFromVector(transition_torque(self._agent.gravity(x[:n]), gradient, damping, x[n:]))

    return Impl


TransitionController = TransitionController_[None]
TransitionController.__name__ = TransitionController.__qualname__ = "TransitionController"  # as diagrams show it
