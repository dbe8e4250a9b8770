"""LeafSystem of the control law (10a): an agent travels under the navigation function."""

from __future__ import annotations

import numpy as np
from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import BasicVector, Context, InputPort, LeafSystem_, OutputPort
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_ltl.dynamics import HeldDamping, transition_torque
from drake_ltl.multibody.agent_model import AgentModel
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
            time_step: float = 0.0,
            *,
            converter=None,
        ):
            """`damping` is the diagonal (n,) of K_z [N s/m, N m s/rad], all positive; it grows beyond `speed_limit`
            of the base [m/s], see `dynamics.growing_damping`. If torques stay for a `time_step` [s], what is fast is
            damped as `dynamics.HeldDamping` says."""
            LeafSystem_[T].__init__(self, converter)
            self.set_name(f"transition_{model.agent.name}")
            if damping.shape != (model.n,) or not np.all(damping > 0.0):
                raise ValueError(f"damping must be {model.n} positive numbers, not {damping!r}")
            self._model, self._damping = model, HeldDamping.of(model, damping, speed_limit, time_step)
            self._agent = agent_for(T, model)
            self._state = self.DeclareVectorInputPort("state", 2 * model.n)
            self._gradient = self.DeclareVectorInputPort("gradient", model.n)
            self._torque = self.DeclareVectorOutputPort("torque", model.n, self._calc_torque)

        def _construct_copy(self, other, converter=None):
            law = other._damping
            Impl._construct(self, other._model, law.K, law.speed_limit, law.time_step, converter=converter)

        def get_state_input_port(self) -> InputPort:
            return self._state

        def get_gradient_input_port(self) -> InputPort:
            return self._gradient

        def get_torque_output_port(self) -> OutputPort:
            return self._torque

        def _calc_torque(self, context: Context, output: BasicVector) -> None:
            q, qd = np.split(self._state.Eval(context), 2)
            gradient = self._gradient.Eval(context)
            K, velocity = self._damping.at(gradient, qd, lambda: self._agent.inertia(q))
            output.SetFromVector(transition_torque(self._agent.gravity(q), gradient, K, velocity))

    return Impl


TransitionController = TransitionController_[None]
TransitionController.__name__ = TransitionController.__qualname__ = "TransitionController"  # as diagrams show it
