"""One agent alone, as a controller sees it: its dynamics (1a) and the kinematics of its two frames."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import JacobianWrtVariable, JointIndex, RigidBody
from pydrake.systems.framework import DiagramBuilder

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.multibody.collision_balls import body_balls, farthest_of_each, moved
from drake_ltl.multibody.manipulability import manipulability
from drake_ltl.multibody.parsing import CENTRE_FRAME, GRASP_FRAME, AddAgentModel, require_collision_geometry
from drake_ltl.scenario.model import Agent
from drake_ltl.scenario.model_files import resolve

ARM_WEIGHT = 0.1
"""Of a joint's error in gamma [m^2/rad^2]: the arm's inertia is small, a stiffer goal would need shorter time steps."""
WEIGHT_PER_INERTIA = 4.0
"""... and at most so much for each kg m^2 that the joint moves, for wrists that are lighter still [1/kg]."""
REFERENCE_INERTIA = 0.15
"""Of a joint that is damped as told [kg m^2]."""
FASTEST_DECAY = 120.0
"""Damping of a joint per inertia [1/s]: K dt / b stays near one half at time steps of 5 ms; beyond, it chatters."""
POSTURE_FREQUENCY = 40.0
"""Of a joint of a redundant arm on its spring, all other joints free [rad/s]: as stiff as time steps of 5 ms allow with
ease, so that loads stay upright and a base that is dragged along lags by a few centimetres."""
POSTURE_DAMPING = 0.7
"""Of that spring, relative to the critical one."""
YAW_DAMPING = 1.5
"""Of the yaw of who carries, for each kg [m^2/s]: a team swings about its load by a few tenths of its turn."""
INERTIA_SAMPLES = 500
"""Postures of which the least inertia is taken."""
NUM_BASE_JOINTS = 2
"""An agent's first two joints move its base along the world's x and y."""


class AgentModel:
    """The agent's own MultibodyPlant (nothing else in it), with a context to compute in.

    All methods take q_i (n,) [m, rad] and leave no trace a caller could see, so that one instance can serve
    several systems of one diagram. It is not safe to share between threads.
    """

    has_arm = True
    """Whether it can grasp; see `DriveAgent` for agents that cannot."""

    def __init__(self, agent: Agent):
        """Raises InvalidInputError where the model cannot be used (see AddAgentModel), has no collision geometry, or
        has first joints that do not move the whole robot along the world's x and y."""
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
        self._grasp = self.plant.GetFrameByName(GRASP_FRAME) if self.has_arm else None
        self._centre = self.plant.GetFrameByName(CENTRE_FRAME)
        self._require_holonomic_base()

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
    def is_redundant(self) -> bool:
        """Whether it can move with its gripper at rest: more than six joints."""
        return self.n > 6

    @cached_property
    def yaw_direction(self) -> float:
        """1 or -1 if the third joint turns the whole robot about the vertical (-1: clockwise as its angle grows), 0 if
        none does: such a robot can turn what it carries."""
        if self.n <= NUM_BASE_JOINTS:
            return 0.0
        q = np.concatenate([np.zeros(NUM_BASE_JOINTS), np.clip(0.0, *self.arm_limits)])
        axes = [jacobian[:3, NUM_BASE_JOINTS] for jacobian in (self.grasp_jacobian(q), self._spatial(self._centre))]
        direction = float(np.sign(axes[0][2]))
        return direction if np.allclose(axes, [0.0, 0.0, direction], atol=1e-9) else 0.0

    @property
    def yaw_is_limited(self) -> bool:
        """Whether that joint cannot turn for ever."""
        limits = self.plant.GetPositionLowerLimits(), self.plant.GetPositionUpperLimits()
        return bool(np.isfinite([limit[NUM_BASE_JOINTS] for limit in limits]).any())

    def turned(self, q: np.ndarray, angle: float) -> np.ndarray:
        """q (n,) when all of the robot is turned by `angle` [rad] about the world's z axis.

        Raises:
            ValueError: it has no yaw joint, and the angle is not zero.
        """
        if angle == 0.0:
            return q
        if not self.yaw_direction:
            raise ValueError(f"{self.agent.name} has no yaw joint: it cannot be turned by {angle!r} rad")
        c, s = np.cos(angle), np.sin(angle)
        turned = q.copy()
        turned[:NUM_BASE_JOINTS] = c * q[0] - s * q[1], s * q[0] + c * q[1]
        turned[NUM_BASE_JOINTS] += self.yaw_direction * angle
        return turned

    @property
    def start_arm(self) -> np.ndarray | None:
        """All joints but x and y at the start (n - 2,), if the scenario says where they are."""
        return None if self.agent.joints is None else np.asarray(self.agent.joints, dtype=float)

    def arriving(self, q: np.ndarray, region: str) -> np.ndarray:
        """q (n,) as it should be when it has travelled to a region."""
        return q

    def goal_error(self, q: np.ndarray, q_goal: np.ndarray) -> tuple[float, np.ndarray]:
        """gamma_z [m^2] and half its gradient (n,)."""
        error = q - q_goal
        slope = self.gamma_weights * error
        return float(slope @ error), slope

    def gamma(self, q: np.ndarray, q_goal: np.ndarray) -> np.ndarray:
        """gamma_z (...) [m^2] of configurations (..., n)."""
        return (q - q_goal) ** 2 @ self.gamma_weights

    def rates_of_travel(self, qd: np.ndarray) -> np.ndarray:
        """Those of the rates (n,) that say whether it gets on [m/s, rad/s]."""
        return qd

    def joint_error(self, q: np.ndarray, q_goal: np.ndarray) -> float:
        """Of the joint that is farthest from where it should be, but for x and y [rad]."""
        return float(np.abs((q - q_goal)[NUM_BASE_JOINTS:]).max())

    @cached_property
    def gamma_weights(self) -> np.ndarray:
        """Diagonal (n,) of the weight in gamma_z: 1 for the base [-], for the arm's joints ARM_WEIGHT [m^2/rad^2], less
        for light ones."""
        weights = np.minimum(ARM_WEIGHT, WEIGHT_PER_INERTIA * self.least_inertia)
        weights[:NUM_BASE_JOINTS] = 1.0
        return weights

    @cached_property
    def least_inertia(self) -> np.ndarray:
        """(n,) [kg, kg m^2]: 1 / (B^-1)_jj, what joint j moves while others are free, the least of many postures."""
        lower, upper = self.arm_limits
        arms = np.random.default_rng(0).uniform(lower, upper, size=(INERTIA_SAMPLES, len(lower)))
        configurations = np.pad(arms, ((0, 0), (NUM_BASE_JOINTS, 0)))
        return 1.0 / np.max([np.diag(np.linalg.inv(self.inertia(q))) for q in configurations], axis=0)

    @property
    def arm_limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Of all joints but x and y (n - 2,) [rad], +-pi where there are none or wider ones."""
        lower, upper = self.plant.GetPositionLowerLimits(), self.plant.GetPositionUpperLimits()
        return np.maximum(lower[NUM_BASE_JOINTS:], -np.pi), np.minimum(upper[NUM_BASE_JOINTS:], np.pi)

    @property
    def effort_limits(self) -> np.ndarray:
        """(n,) [N, N m] of the joints' actuators; inf without one. Drake's plant applies no more."""
        B = self.plant.MakeActuationMatrix()
        limits = [self.plant.get_joint_actuator(i).effort_limit() for i in self.plant.GetJointActuatorIndices()]
        return np.array([limits[int(np.argmax(row))] for row in B])

    def damping(self, base: float, arm: float) -> np.ndarray:
        """Diagonal (n,) of K_z [N s/m, N m s/rad].

        `arm` is that of a joint with an inertia of REFERENCE_INERTIA and grows with the root of the inertia, so that
        all joints of an arm swing equally little; less for joints that are too light for so much.
        """
        inertia = np.diag(self.inertia(np.zeros(self.n)))
        K = np.minimum(arm * np.sqrt(inertia / REFERENCE_INERTIA), FASTEST_DECAY * self.least_inertia)
        K[:NUM_BASE_JOINTS] = base
        return K

    def manipulability(self, q: np.ndarray) -> float:
        """w(q) = sqrt(det J J^T), see `multibody.manipulability`."""
        return float(manipulability(self.grasp_jacobian(q)))

    @property
    def posture_stiffness(self) -> np.ndarray:
        """(n,) [N m/rad] of the spring that keeps a redundant arm's posture while it carries; none for x, y and the
        base's yaw, which follow the load."""
        stiffness = POSTURE_FREQUENCY**2 * self.least_inertia
        stiffness[: NUM_BASE_JOINTS + bool(self.yaw_direction)] = 0.0
        return stiffness

    @property
    def posture_damping(self) -> np.ndarray:
        """(n,) [N m s/rad] that goes with it; some for the base's yaw too, or teams would swing about their load."""
        damping = 2.0 * POSTURE_DAMPING / POSTURE_FREQUENCY * self.posture_stiffness
        if self.yaw_direction:
            damping[NUM_BASE_JOINTS] = YAW_DAMPING * self.mass
        return damping

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

    def energy(self, q: np.ndarray, qd: np.ndarray) -> float:
        """What its motion adds to V [J]."""
        return self.kinetic_energy(q, qd)

    def centre(self, q: np.ndarray) -> np.ndarray:
        """c_i(q) (3,) [m] in W, the centre of the bounding sphere."""
        self.plant.SetPositions(self._context, q)
        return self._centre.CalcPoseInWorld(self._context).translation()

    @cached_property
    def mass(self) -> float:
        """Of all that its joints move [kg]."""
        return float(self.inertia(np.zeros(self.n))[0, 0])

    def mass_velocity(self, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
        """Velocity (3,) [m/s] of its centre of mass in W."""
        self.plant.SetPositionsAndVelocities(self._context, np.concatenate([q, qd]))
        return self.plant.CalcCenterOfMassTranslationalVelocityInWorld(self._context)

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

    def reaches(self, arms: np.ndarray, *, inner: bool = False) -> np.ndarray:
        """(k,) largest distances [m] from c_i to a point of `volume` (or `inner_volume`), for arms (k, n_i - 2)."""
        found = []
        for arm in arms:
            centre = self.centre(np.concatenate([np.zeros(NUM_BASE_JOINTS), arm]))
            found.append([(body.EvalPoseInWorld(self._context), centre) for body, _ in self._outer])
        return farthest_of_each(found, [balls for _, balls in (self._inner if inner else self._outer)])

    def grasp_pose(self, q: np.ndarray):
        """X_WE(q), a RigidTransform: the end-effector frame {E_i}."""
        self.plant.SetPositions(self._context, q)
        return self._grasp.CalcPoseInWorld(self._context)

    def grasp_jacobian(self, q: np.ndarray) -> np.ndarray:
        """J_i(q) (6, n) in W, rows (rotational; translational): V_WE = J_i qd."""
        self.plant.SetPositions(self._context, q)
        return self._spatial(self._grasp)

    def _spatial(self, frame) -> np.ndarray:
        return self.plant.CalcJacobianSpatialVelocity(
            self._context, JacobianWrtVariable.kV, frame, np.zeros(3), self._world, self._world
        )

    def nearest_turn(self, q: np.ndarray, other: np.ndarray) -> np.ndarray:
        """q (n,) with its yaw, if that has no limits, changed by whole turns to be nearest to that of `other`."""
        if not self.yaw_direction or self.yaw_is_limited:
            return q
        nearest = q.copy()
        nearest[NUM_BASE_JOINTS] += 2.0 * np.pi * np.round((other - q)[NUM_BASE_JOINTS] / (2.0 * np.pi))
        return nearest

    def _require_holonomic_base(self) -> None:
        along_x_and_y = np.eye(6)[:, 3 : 3 + NUM_BASE_JOINTS]
        q = np.concatenate(
            [np.zeros(NUM_BASE_JOINTS), np.clip(0.0, *self.arm_limits)]
        )  # x, y do not turn: any q will do
        bases = (jacobian[:, :NUM_BASE_JOINTS] for jacobian in (self.grasp_jacobian(q), self._spatial(self._centre)))
        if self.n > NUM_BASE_JOINTS and all(np.allclose(base, along_x_and_y, atol=1e-9) for base in bases):
            return
        raise InvalidInputError(
            [
                Mistake(
                    f"agents.{self.agent.name}.model",
                    f"{resolve(self.agent.model).name} has the joints {', '.join(self.joint_names)}: of these the "
                    "first two do not move all of it along the world's x and y, or no arm follows",
                    "begin with prismatic joints from `world`, of axes 1 0 0 and 0 1 0; a yaw joint and the arm follow",
                )
            ]
        )

    def _translational_jacobian(self, frame) -> np.ndarray:
        return self.plant.CalcJacobianTranslationalVelocity(
            self._context, JacobianWrtVariable.kV, frame, np.zeros(3), self._world, self._world
        )

    def _posed(self, shapes: list[tuple[RigidBody, np.ndarray]], q: np.ndarray) -> np.ndarray:
        self.plant.SetPositions(self._context, q)
        return np.concatenate([moved(body.EvalPoseInWorld(self._context), b) for body, b in shapes if len(b)])
