"""LeafSystem of the control law (10b): a team carries one object and shares its load."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydrake.autodiffutils import AutoDiffXd
from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, Context, InputPort, LeafSystem_, OutputPort, ValueProducer
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_ltl.dynamics import (
    body_gravity,
    check_load_shares,
    growing_damping,
    speed_of,
    team_damping,
    team_wrench,
    transport_torque,
)
from drake_ltl.multibody.agent_model import AgentModel
from drake_ltl.multibody.autodiff_agent import agent_for
from drake_ltl.multibody.object_model import ObjectModel
from drake_ltl.systems.posture_springs import PostureSprings


@TemplateSystem.define("TransportController_", T_list=[float, AutoDiffXd])
def TransportController_(T):
    class Impl(LeafSystem_[T]):
        """tau_i = J_i^T J_O^{-T} c_i (g_O - grad_x psi - K_O v_O) + g_q,i (+ tau_0,i) for every agent i of the team.

        .. pydrake_system::

            name: TransportController
            input_ports:
            - state_<object>
            - gradient
            - shares
            - state_<agent>
            - anchor_<agent>
            output_ports:
            - torque_<agent>

        `state_<object>` is Drake's state (13,) of a free body: quaternion, position, angular and linear velocity in W.
        `gradient` is k dPhi/dx (6,) (rotational; translational); `shares` c_tau (N,), of sum 1, zero for agents
        outside the team, whose torque output is then gravity alone. Redundant agents have a port `anchor_<agent>`: the
        configuration (n,) in which they began to carry, where the spring of `dynamics.null_space` rests that adds tau_0
        to the torque of those in the team. It may be converted to AutoDiffXd.
        """

        def _construct(
            self,
            obj: ObjectModel,
            agents: Mapping[str, AgentModel],
            damping: np.ndarray,
            speed_limit: float = np.inf,
            *,
            converter=None,
        ):
            """`damping` is the diagonal (6,) of K_O (rotational; translational) [N m s, N s/m] of light teams, all
            positive; it grows with their mass, see `dynamics.team_damping`, and beyond `speed_limit` of the object
            [m/s], see `dynamics.growing_damping`."""
            LeafSystem_[T].__init__(self, converter)
            name = obj.object.name
            self.set_name(f"transport_{name}")
            if damping.shape != (6,) or not np.all(damping > 0.0):
                raise ValueError(f"damping must be 6 positive numbers, not {damping!r}")
            self._object_model, self._agents = obj, dict(agents)
            self._damping, self._speed_limit = damping, speed_limit
            self._gravity, self._springs = body_gravity(obj.borne_mass), PostureSprings(self._agents)
            self._object = self.DeclareVectorInputPort(f"state_{name}", 13)
            self._gradient = self.DeclareVectorInputPort("gradient", 6)
            self._shares = self.DeclareVectorInputPort("shares", len(self._agents))
            self._checked_shares = self.DeclareCacheEntry(
                "checked_shares",
                ValueProducer(allocate=Value[object], calc=self._calc_shares),
                prerequisites_of_calc={self._shares.ticket()},
            )
            self._wrench = self.DeclareCacheEntry(
                "team_wrench",
                ValueProducer(allocate=Value[object], calc=self._calc_wrench),
                prerequisites_of_calc={self._object.ticket(), self._gradient.ticket(), self._checked_shares.ticket()},
            )
            self._state, self._torque, self._anchor = {}, {}, {}
            with_arms = [(i, *item) for i, item in enumerate(self._agents.items()) if item[1].has_arm]
            for index, agent, model in with_arms:
                self._state[agent] = self.DeclareVectorInputPort(f"state_{agent}", 2 * model.n)
                prerequisites = {self._wrench.ticket(), self._checked_shares.ticket(), self._state[agent].ticket()}
                if model.is_redundant:
                    self._anchor[agent] = self.DeclareVectorInputPort(f"anchor_{agent}", model.n)
                    prerequisites.add(self._anchor[agent].ticket())
                self._torque[agent] = self.DeclareVectorOutputPort(
                    f"torque_{agent}",
                    model.n,
                    self._calc_torque(index, agent, agent_for(T, model), model.n),
                    prerequisites,
                )

        def _construct_copy(self, other, converter=None):
            Impl._construct(
                self, other._object_model, other._agents, other._damping, other._speed_limit, converter=converter
            )

        def get_object_state_input_port(self) -> InputPort:
            return self._object

        def get_gradient_input_port(self) -> InputPort:
            return self._gradient

        def get_shares_input_port(self) -> InputPort:
            return self._shares

        def get_agent_state_input_port(self, agent: str) -> InputPort:
            return self._state[agent]

        def get_anchor_input_port(self, agent: str) -> InputPort:
            """Of a redundant agent."""
            return self._anchor[agent]

        def get_torque_output_port(self, agent: str) -> OutputPort:
            return self._torque[agent]

        def _calc_wrench(self, context: Context, value) -> None:
            V_WO = self._object.Eval(context)[7:]
            damping = growing_damping(self._team_damping(context), speed_of(V_WO[3:]), self._speed_limit)
            value.set_value(team_wrench(self._gravity, self._gradient.Eval(context), damping, V_WO))

        def _team_damping(self, context: Context) -> np.ndarray:
            shares = self._checked_shares.Eval(context)
            team = (model.mass for model, share in zip(self._agents.values(), shares, strict=True) if share > 0.0)
            return team_damping(self._damping, self._object_model.borne_mass + sum(team))

        def _calc_shares(self, context: Context, value) -> None:
            shares = self._shares.Eval(context)
            check_load_shares(shares)
            value.set_value(shares)

        def _calc_torque(self, index: int, agent: str, model, n: int):
            def calc(context: Context, output: BasicVector) -> None:
                x = self._state[agent].Eval(context)
                q = x[:n]
                p_WO = self._object.Eval(context)[4:7]
                p_OoEo_W = model.grasp_pose(q).translation() - p_WO
                share, J = self._checked_shares.Eval(context)[index], model.grasp_jacobian(q)
                tau = transport_torque(share, self._wrench.Eval(context), p_OoEo_W, J, model.gravity(q))
                if agent in self._anchor and share > 0.0:
                    reference = _values(self._anchor[agent].Eval(context))
                    tau = tau + self._springs.of(agent, reference).torque(q, x[n:], J)
                output.SetFromVector(tau)

            return calc

    return Impl


def _values(array: np.ndarray) -> np.ndarray:
    """As floats."""
    return array if array.dtype == float else np.array([x.value() for x in array])


TransportController = TransportController_[None]
TransportController.__name__ = TransportController.__qualname__ = "TransportController"  # as diagrams show it
