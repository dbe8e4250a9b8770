"""All agents of a scenario in one plant of their own: what `AgentModel` has of one, in one call for all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable, MultibodyForces

from drake_ltl.multibody.parsing import CENTRE_FRAME, GRASP_FRAME, AddAgentModel
from drake_ltl.scenario.model import Agent

_ORIGIN = np.zeros(3)


class CrewModel:
    """Kinematics and dynamics of all agents in the state that was set last.

    Configurations, velocities and torques are stacked, agent after agent in the order given (n,); `rows` says which are
    whose. It is not safe to share between threads.
    """

    def __init__(self, agents: Sequence[Agent]):
        """Of models that `AgentModel` takes."""
        self._plant = plant = MultibodyPlant(time_step=0.0)
        instances = {agent.name: AddAgentModel(plant, agent) for agent in agents}
        plant.Finalize()
        self._context, self._world = plant.CreateDefaultContext(), plant.world_frame()
        self._forces = MultibodyForces(plant)
        self._centre = {name: plant.GetFrameByName(CENTRE_FRAME, instance) for name, instance in instances.items()}
        self._gripper = {
            name: plant.GetFrameByName(GRASP_FRAME, instance)
            for name, instance in instances.items()
            if plant.HasFrameNamed(GRASP_FRAME, instance)
        }
        self.n = plant.num_velocities()
        self._state = np.zeros(2 * self.n)
        ends = np.cumsum([0, *(plant.num_velocities(instance) for instance in instances.values())]).tolist()
        self.rows: Mapping[str, slice] = {
            name: slice(start, end) for name, start, end in zip(instances, ends, ends[1:], strict=False)
        }
        """agent -> its rows."""
        numbers = np.arange(self.n, dtype=float)
        stacked = np.concatenate([plant.GetVelocitiesFromArray(instance, numbers) for instance in instances.values()])
        assert np.array_equal(stacked, numbers)  # Drake orders trees of bodies as they were added

    @property
    def with_arms(self) -> tuple[str, ...]:
        """Agents that have a gripper."""
        return tuple(self._gripper)

    def set_state(self, q: np.ndarray, qd: np.ndarray) -> None:
        """To configurations and velocities (n,)."""
        self._state[: self.n] = q
        self._state[self.n :] = qd
        self._plant.SetPositionsAndVelocities(self._context, self._state)

    def centre(self, agent: str) -> np.ndarray:
        """c_i (3,) [m] in W, the centre of the bounding sphere."""
        return self._centre[agent].CalcPoseInWorld(self._context).translation()

    def inverse_dynamics(self, qdd: np.ndarray) -> np.ndarray:
        """B qdd + N qd + g_q (n,): the torques of (1a) that yield qdd (n,) with no contact; g_q at rest."""
        self._plant.CalcForceElementsContribution(self._context, self._forces)  # gravity
        return self._plant.CalcInverseDynamics(self._context, qdd, self._forces)

    def inertia(self, agent: str) -> np.ndarray:
        """B_i(q_i) (n_i, n_i) of (1a)."""
        rows = self.rows[agent]
        return self._plant.CalcMassMatrix(self._context)[rows, rows]

    def kinetic_energy(self) -> float:
        """qd^T B qd / 2 [J]."""
        return self._plant.CalcKineticEnergy(self._context)

    def centre_jacobian(self, agent: str) -> np.ndarray:
        """d c_i / d q_i (3, n_i) in W."""
        J = self._plant.CalcJacobianTranslationalVelocity(
            self._context, JacobianWrtVariable.kV, self._centre[agent], _ORIGIN, self._world, self._world
        )
        return J[:, self.rows[agent]]

    def grasp_position(self, agent: str) -> np.ndarray:
        """p_WE (3,) [m] of the end-effector frame."""
        return self._gripper[agent].CalcPoseInWorld(self._context).translation()

    def grasp_jacobian(self, agent: str) -> np.ndarray:
        """J_i (6, n_i) in W, rows (rotational; translational): V_WE = J_i qd_i."""
        J = self._plant.CalcJacobianSpatialVelocity(
            self._context, JacobianWrtVariable.kV, self._gripper[agent], _ORIGIN, self._world, self._world
        )
        return J[:, self.rows[agent]]
