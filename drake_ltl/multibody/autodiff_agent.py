"""One agent alone, for scalars that carry their derivatives: what the control laws ask of an AgentModel."""

from __future__ import annotations

import numpy as np
from pydrake.autodiffutils import AutoDiffXd

from drake_ltl.dynamics.joint_space import frame_jacobian, gravity_torque, inertia_matrix
from drake_ltl.multibody.agent_model import AgentModel
from drake_ltl.multibody.parsing import GRASP_FRAME


class AutoDiffAgent:
    """The methods of AgentModel that controllers use, for q_i (n,) of AutoDiffXd."""

    def __init__(self, model: AgentModel):
        self._plant = model.plant.ToAutoDiffXd()
        self._context = self._plant.CreateDefaultContext()
        self._grasp = self._plant.GetFrameByName(GRASP_FRAME)

    def gravity(self, q: np.ndarray) -> np.ndarray:
        """g_q(q) (n,) [N, N m] of (1a)."""
        self._plant.SetPositions(self._context, q)
        return gravity_torque(self._plant, self._context)

    def inertia(self, q: np.ndarray) -> np.ndarray:
        """B(q) (n, n) of (1a)."""
        self._plant.SetPositions(self._context, q)
        return inertia_matrix(self._plant, self._context)

    def grasp_pose(self, q: np.ndarray):
        """X_WE(q), a RigidTransform_[AutoDiffXd]."""
        self._plant.SetPositions(self._context, q)
        return self._grasp.CalcPoseInWorld(self._context)

    def grasp_jacobian(self, q: np.ndarray) -> np.ndarray:
        """J_i(q) (6, n) in W."""
        self._plant.SetPositions(self._context, q)
        return frame_jacobian(self._plant, self._context, self._grasp)


def agent_for(T: type, model: AgentModel) -> AgentModel | AutoDiffAgent:
    """The model itself for float, its twin for AutoDiffXd."""
    return AutoDiffAgent(model) if T is AutoDiffXd else model
