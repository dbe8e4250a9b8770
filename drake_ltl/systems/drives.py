"""LeafSystem that gives the torques that are asked for, as far as the drives can."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import BasicVector, Context, InputPort, LeafSystem, OutputPort


class Drives(LeafSystem):
    """The motors of all agents, with a limit that can fall.

    .. pydrake_system::

        name: Drives
        input_ports:
        - torque
        output_ports:
        - delivered

    `torque` (n,) are the torques asked for, all agents stacked; `delivered` (n,)
    [N, N m] is each torque, cut off at its effort limit times the agent's share. Shares are parameters, 1 at first.
    Current sensors of real motors measure what is delivered.
    """

    def __init__(self, effort_limits: Mapping[str, np.ndarray]):
        """`effort_limits`: agent -> (n_i,) [N, N m]."""
        super().__init__()
        self.set_name("drives")
        self._names = list(effort_limits)
        limits = np.concatenate(list(effort_limits.values()))
        self._limits = np.minimum(limits, np.finfo(float).max)  # inf times a share of 0 would be no number
        self._rows = np.repeat(np.arange(len(self._names)), [len(limits) for limits in effort_limits.values()])
        n = len(self._limits)
        self._shares = self.DeclareNumericParameter(BasicVector(np.ones(len(self._names))))
        self._torque = self.DeclareVectorInputPort("torque", n)
        self._delivered = self.DeclareVectorOutputPort("delivered", n, self._calc_delivered)

    def get_torque_input_port(self) -> InputPort:
        return self._torque

    def get_delivered_output_port(self) -> OutputPort:
        return self._delivered

    def SetShare(self, context: Context, agent: str, share: float) -> None:
        """From now on the agent's drives give at most this share of their effort limits."""
        context.get_mutable_numeric_parameter(self._shares).SetAtIndex(self._names.index(agent), share)

    def _calc_delivered(self, context: Context, output: BasicVector) -> None:
        most = self._limits * context.get_numeric_parameter(self._shares).value()[self._rows]
        output.SetFromVector(np.clip(self._torque.Eval(context), -most, most))
