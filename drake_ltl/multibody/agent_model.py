"""One agent alone, as a controller sees it: its dynamics (1a) and the kinematics of its two frames."""

from __future__ import annotations

import numpy as np
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import JacobianWrtVariable, JointIndex, RigidBody
from pydrake.systems.framework import DiagramBuilder

from drake_ltl.multibody.collision_balls import body_balls, moved
from drake_ltl.multibody.parsing import CENTRE_FRAME, GRASP_FRAME, AddAgentModel, require_collision_geometry
from drake_ltl.scenario.model import Agent

ARM_WEIGHT = 0.1
"""Of a joint's error in gamma [m^2/rad^2]: the arm's inertia is small, a stiffer goal would need shorter time steps."""
NUM_BASE_JOINTS = 2
"""An agent's first two joints move its base along the world's x and y."""


class AgentModel:
    """The agent's own MultibodyPlant (nothing else in it), with a context to compute in.

    All methods take q_i (n,) [m, rad] and leave no trace a caller could see, so that one instance can serve
    several systems of one diagram. It is not safe to share between threads.
    """

    def __init__(self, agent: Agent):
        """Raises InvalidInputError where the model cannot be used (see AddAgentModel) or has no collision geometry."""
        self.agent = agent
        builder = DiagramBuilder()
        self.plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
        self.instance = AddAgentModel(self.plant, agent)
        self.plant.Finalize()
        self._diagram = builder.Build()  # owns the plant
        self._context = self.plant.CreateDefaultContext()
        bodies = [self.plant.get_body(index) for index in self.plant.GetBodyIndices(self.instance)]
        self._outer, self._inner = (
            [(body, body_balls(self.plant, scene_graph.model_inspector(), body, inside=inside)) for body in bodies]
            for inside in (False, True)
        )
        require_collision_geometry([balls for _, balls in self._outer], f"agents.{agent.name}.model", agent.model)
        self._world = self.plant.world_frame()
        self._grasp = self.plant.GetFrameByName(GRASP_FRAME)
        self._centre = self.plant.GetFrameByName(CENTRE_FRAME)

    @property
    def n(self) -> int:
        """n_i, the number of joints."""
        return self.plant.num_positions()

    @property
    def joint_names(self) -> tuple[str, ...]:
        """In the order of q_i."""
        joints = [self.plant.get_joint(JointIndex(i)) for i in self.plant.GetJointIndices(self.instance)]
        moving = [joint for joint in joints if joint.num_positions() == 1]
        return tuple(joint.name() for joint in sorted(moving, key=lambda joint: joint.position_start()))

    @property
    def gamma_weights(self) -> np.ndarray:
        """Diagonal (n,) of the weight in gamma_z: 1 for the base [-], ARM_WEIGHT for the arm's joints [m^2/rad^2]."""
        return np.concatenate([np.ones(NUM_BASE_JOINTS), np.full(self.n - NUM_BASE_JOINTS, ARM_WEIGHT)])

    def gravity(self, q: np.ndarray) -> np.ndarray:
        """g_q(q) (n,) [N, N m] of (1a), the torque that balances gravity."""
        self.plant.SetPositions(self._context, q)
        return -self.plant.CalcGravityGeneralizedForces(self._context)

    def inertia(self, q: np.ndarray) -> np.ndarray:
        """B(q) (n, n) of (1a)."""
        self.plant.SetPositions(self._context, q)
        return self.plant.CalcMassMatrix(self._context)

    def inverse_dynamics(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        """tau (n,) = B qdd + N qd + g_q, the torque of (1a) that yields qdd with no contact."""
        plant = self.plant
        plant.SetPositions(self._context, q)
        plant.SetVelocities(self._context, qd)
        tau = plant.CalcMassMatrix(self._context) @ qdd + plant.CalcBiasTerm(self._context)
        return tau - plant.CalcGravityGeneralizedForces(self._context)

    def kinetic_energy(self, q: np.ndarray, qd: np.ndarray) -> float:
        """qd^T B(q) qd / 2 [J]."""
        return 0.5 * float(qd @ self.inertia(q) @ qd)

    def centre(self, q: np.ndarray) -> np.ndarray:
        """c_i(q) (3,) [m] in W, the centre of the bounding sphere."""
        self.plant.SetPositions(self._context, q)
        return self._centre.CalcPoseInWorld(self._context).translation()

    def centre_jacobian(self, q: np.ndarray) -> np.ndarray:
        """d c_i / d q (3, n) in W."""
        self.plant.SetPositions(self._context, q)
        return self._translational_jacobian(self._centre)

    def volume(self, q: np.ndarray) -> np.ndarray:
        """(m, 4) rows (x, y, z, radius) [m] in W: balls whose hulls, body by body, cover the collision geometry."""
        return self._posed(self._outer, q)

    def inner_volume(self, q: np.ndarray) -> np.ndarray:
        """(m, 4) as `volume`, but balls inside the collision geometry: what it reaches for certain."""
        return self._posed(self._inner, q)

    def grasp_pose(self, q: np.ndarray):
        """X_WE(q), a RigidTransform: the end-effector frame {E_i}."""
        self.plant.SetPositions(self._context, q)
        return self._grasp.CalcPoseInWorld(self._context)

    def grasp_jacobian(self, q: np.ndarray) -> np.ndarray:
        """J_i(q) (6, n) in W, rows (rotational; translational): V_WE = J_i qd."""
        self.plant.SetPositions(self._context, q)
        return self.plant.CalcJacobianSpatialVelocity(
            self._context, JacobianWrtVariable.kV, self._grasp, np.zeros(3), self._world, self._world
        )

    def _translational_jacobian(self, frame) -> np.ndarray:
        return self.plant.CalcJacobianTranslationalVelocity(
            self._context, JacobianWrtVariable.kV, frame, np.zeros(3), self._world, self._world
        )

    def _posed(self, shapes: list[tuple[RigidBody, np.ndarray]], q: np.ndarray) -> np.ndarray:
        self.plant.SetPositions(self._context, q)
        return np.concatenate([moved(body.EvalPoseInWorld(self._context), b) for body, b in shapes if len(b)])
