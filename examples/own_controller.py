"""Puts a control law of one's own into a mission: a LeafSystem in the place of the robot's transition controller.

    python examples/own_controller.py

The law is (10a) with drag: damping of the base that grows with its speed, so that the robot hurries less. The mission
is judged like any other: V must not rise, whoever computes the torques.
"""

from __future__ import annotations

import sys

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

import drake_ltl
from drake_ltl.multibody import AgentModel

DRAG = 15.0
"""[N s^2/m^2]"""


class DragController(LeafSystem):
    """tau = g_q(q) - grad psi - K qd - DRAG |v| v, v the base's velocity.

    .. pydrake_system::

        name: DragController
        input_ports:
        - state
        - gradient
        output_ports:
        - torque

    The ports are those of `TransitionController`: `state` is (q, qd) (2n,), `gradient` (n,) that of the navigation
    function's potential, `torque` (n,) [N, N m].
    """

    def __init__(self, model: AgentModel, damping: np.ndarray):
        super().__init__()
        self._model, self._damping = model, damping
        self._state = self.DeclareVectorInputPort("state", 2 * model.n)
        self._gradient = self.DeclareVectorInputPort("gradient", model.n)
        self.DeclareVectorOutputPort("torque", model.n, self._calc_torque)

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        q, qd = np.split(self._state.Eval(context), 2)
        damping = self._damping.copy()
        damping[:2] += DRAG * np.linalg.norm(qd[:2])
        output.SetFromVector(self._model.gravity(q) - self._gradient.Eval(context) - damping * qd)


def main() -> int:
    scenario = drake_ltl.load("patrol")
    (robot,) = scenario.agents
    model, gains = AgentModel(robot), scenario.controller
    drag = DragController(model, model.damping(gains.base_damping, gains.arm_damping))
    satisfied = True
    for name, own in (("usual law", {}), ("with drag", {f"transition_{robot.name}": drag})):
        run = drake_ltl.simulate(scenario, own_controllers=own)
        speeds = np.linalg.norm(run.recording.qd[robot.name][:, :2], axis=1)
        verdict = drake_ltl.verify(run)
        satisfied = satisfied and verdict.satisfied
        print(f"{name}: at most {speeds.max():.2f} m/s, {verdict!r}", *verdict.violations, sep="\n  ")
    return 0 if satisfied else 1


if __name__ == "__main__":
    sys.exit(main())
