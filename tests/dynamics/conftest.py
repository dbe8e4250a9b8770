"""Arms of 4 to 7 joints, each alone in a plant, and teams of them that carry a crate in a simulation."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    PrismaticJoint,
    RevoluteJoint,
    RotationalInertia,
    SpatialInertia,
    UnitInertia,
)
from pydrake.systems.analysis import Simulator

from drake_ltl.dynamics import (
    JointDynamics,
    SpatialDynamics,
    body_gravity,
    coupled_dynamics,
    frame_jacobian,
    grasp_matrix,
    gravity_torque,
    joint_dynamics,
    load_shares,
    null_space_wrench,
    object_dynamics,
    task_dynamics,
    team_wrench,
    transport_torque,
    wrench_at_gripper,
    wrench_on_object,
)

X, Y, Z = np.eye(3)
LIMBS = {  # joints above the base: axis in the parent, mass [kg], length of the limb it moves [m]
    5: ((Z, 1.5, 0.2), (Y, 0.6, 0.9), (Y, 0.5, 0.6)),
    6: ((Z, 1.5, 0.2), (Y, 0.6, 0.9), (Y, 0.5, 0.6), (Z, 0.2, 0.2)),
    7: ((Z, 1.5, 0.2), (Y, 0.6, 0.9), (Y, 0.5, 0.6), (Y, 0.3, 0.3), (Z, 0.2, 0.2)),
}
"""A turret that yaws, links that pitch, a wrist that rolls about its own axis: with x and y, J has full rank.

Without the wrist, which twists are missing turns with the yaw (those of the planar arm never do).
"""
MASS = 0.8
INERTIA = np.array([[0.05, 0.004, -0.003], [0.004, 0.06, 0.002], [-0.003, 0.002, 0.04]])
"""Of the crate [kg m^2], no two axes alike, so that its gyroscopic terms count."""


def add_arm(plant: MultibodyPlant, name: str, n: int):
    """Adds x, y and the limbs of LIMBS[n], made of cylinders; returns the end-effector's frame."""
    instance = plant.AddModelInstance(name)
    slide = plant.AddRigidBody("slide", instance, SpatialInertia.SolidSphereWithMass(0.3, 0.1))
    base = plant.AddRigidBody("base", instance, SpatialInertia.SolidBoxWithMass(2.0, 0.5, 0.5, 0.2))
    joints = [
        PrismaticJoint("x", plant.world_frame(), slide.body_frame(), X),
        PrismaticJoint("y", slide.body_frame(), base.body_frame(), Y),
    ]
    parent = base.body_frame()
    for k, (axis, mass, length) in enumerate(LIMBS[n]):
        inertia = SpatialInertia.SolidCylinderWithMassAboutEnd(mass, 0.05, length, Z)
        limb = plant.AddRigidBody(f"limb{k}", instance, inertia)
        joints.append(RevoluteJoint(f"q{k}", parent, limb.body_frame(), axis))
        end = FixedOffsetFrame(f"end{k}", limb.body_frame(), RigidTransform([0.0, 0.0, length]), instance)
        parent = plant.AddFrame(end)
    for joint in joints:
        plant.AddJointActuator(joint.name(), plant.AddJoint(joint))
    return parent


@dataclass(frozen=True)
class Solo:
    """One arm alone."""

    plant: MultibodyPlant
    frame: object

    def dynamics(self, q: np.ndarray, qd: np.ndarray) -> JointDynamics:
        context = self.plant.CreateDefaultContext()
        self.plant.SetPositionsAndVelocities(context, np.concatenate([q, qd]))
        return joint_dynamics(self.plant, context, self.frame)


def make_solo(n: int) -> Solo:
    plant = MultibodyPlant(0.0)
    frame = add_arm(plant, "arm", n)
    plant.Finalize()
    return Solo(plant, frame)


@pytest.fixture(scope="session")
def solo(arm_plant):
    """n -> Solo: the paper's planar arm for 4 joints, arms of primitives for 5, 6 and 7."""
    planar = arm_plant(0.4)
    arms = {n: make_solo(n) for n in LIMBS} | {4: Solo(planar, planar.GetFrameByName("grasp"))}
    return arms.__getitem__


@pytest.fixture(scope="session")
def transport():
    """transport(joints, power, dt, duration, every): see `simulate_transport`; the same one is made once."""
    return functools.cache(simulate_transport)


@dataclass(frozen=True)
class Sample:
    """One step of a simulated transport: states at its beginning, accelerations by differences over it."""

    joint: tuple[JointDynamics, ...]
    """(1a) of each arm alone, at its own state."""
    offsets: tuple[np.ndarray, ...]
    R_WO: np.ndarray
    V_WO: np.ndarray
    A_WO: np.ndarray
    u: tuple[np.ndarray, ...]
    """The wrench each member commands (6,), tau = J^T u + g_q with gravity as the wrench g of (1b)."""
    idle: tuple[np.ndarray, ...]
    """`null_space_wrench` of each member."""
    f: tuple[np.ndarray, ...]
    """What each member puts on the crate (6,), measured at its last joint."""

    @property
    def coupled(self) -> SpatialDynamics:
        """(7)."""
        crate = object_dynamics(MASS, INERTIA, self.R_WO, self.V_WO[:3])
        return coupled_dynamics(crate, [task_dynamics(j) for j in self.joint], self.offsets, self.V_WO[:3])

    @property
    def residual(self) -> np.ndarray:
        """(6,) M~ vdot + C~ v + g~ + G^T h - G^T u: zero if (7) holds."""
        G = grasp_matrix(self.offsets)
        return self.coupled.wrench(self.A_WO, self.V_WO) + G.T @ np.concatenate(
            [h - u for h, u in zip(self.idle, self.u, strict=True)]
        )


def simulate_transport(
    joints: tuple[int, ...], power: tuple[float, ...], dt: float, duration: float, every: float
) -> list[Sample]:
    """Arms of the given numbers of joints, welded to a crate, carry it about under (10b) with a wavering gradient.

    Nothing touches a floor. One sample per `every` seconds.
    """
    arms = [make_solo(n) for n in joints]
    X_WO = RigidTransform(RollPitchYaw(0.1, -0.2, 0.3), [0.2, 0.1, 0.9])
    starts = [_posture(n, k, len(joints)) for k, n in enumerate(joints)]
    plant, frames, body = _welded_plant(joints, arms, starts, X_WO, dt)
    instances = [frame.model_instance() for frame in frames]
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    for instance, q in zip(instances, starts, strict=True):
        plant.SetPositions(context, instance, q)
    plant.SetFreeBodyPose(context, body, X_WO)
    shares, damping = load_shares(power), np.array([1.0, 1.0, 1.0, 4.0, 4.0, 4.0])
    samples, stride = [], round(every / dt)
    for step in range(round(duration / dt)):
        q = [plant.GetPositions(context, instance) for instance in instances]
        qd = [plant.GetVelocities(context, instance) for instance in instances]
        X, V_WO = body.EvalPoseInWorld(context), body.EvalSpatialVelocityInWorld(context).get_coeffs()
        F_O = team_wrench(body_gravity(MASS), _gradient(step * dt), damping, V_WO)
        parts = [_torque(*rest, F_O, X.translation()) for rest in zip(arms, q, qd, shares, strict=True)]
        tau, offsets, pushes = zip(*parts, strict=True)
        for instance, torque in zip(instances, tau, strict=True):
            plant.get_actuation_input_port(instance).FixValue(context, torque)
        simulator.AdvanceTo((step + 1) * dt)
        if step % stride != stride - 1:
            continue
        joint = tuple(arm.dynamics(*state) for arm, *state in zip(arms, q, qd, strict=True))
        samples.append(
            Sample(
                joint=joint,
                offsets=offsets,
                R_WO=X.rotation().matrix(),
                V_WO=V_WO,
                A_WO=(body.EvalSpatialVelocityInWorld(context).get_coeffs() - V_WO) / dt,
                u=tuple(f + task_dynamics(j).g for f, j in zip(pushes, joint, strict=True)),
                idle=tuple(null_space_wrench(j, v) for j, v in zip(joint, qd, strict=True)),
                f=tuple(wrench_on_object(plant, context, frame) for frame in frames),
            )
        )
    return samples


def _gradient(t: float) -> np.ndarray:
    """Forces and torques that waver, each at its own rate."""
    return np.array([1.0, -1.5, 0.8, 10.0, -8.0, 6.0]) * np.sin(np.array([9, 7, 8, 5, 6, 7]) * t + 0.4)


def _posture(n: int, k: int, size: int) -> np.ndarray:
    """Around the crate, the gripper towards it, and no angle special."""
    yaw = 2.0 * np.pi * k / size + 0.3
    arm = {6: [0.7, 0.9, 0.2], 7: [0.5, 0.6, 0.5, 0.2]}[n]
    return np.array([-1.6 * np.cos(yaw), -1.6 * np.sin(yaw), yaw, *arm])


def _welded_plant(joints, arms, starts, X_WO, dt):
    plant = MultibodyPlant(dt)
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kLagged)
    unit = UnitInertia()
    unit.SetFromRotationalInertia(
        RotationalInertia(*np.diag(INERTIA), INERTIA[0, 1], INERTIA[0, 2], INERTIA[1, 2]), MASS
    )
    body = plant.AddRigidBody("crate", SpatialInertia(MASS, np.zeros(3), unit))
    frames = []
    for k, (n, arm, q) in enumerate(zip(joints, arms, starts, strict=True)):
        frame = add_arm(plant, f"arm{k}", n)
        frames.append(frame)
        alone = arm.plant.CreateDefaultContext()
        arm.plant.SetPositions(alone, q)
        X_OE = X_WO.inverse() @ arm.frame.CalcPoseInWorld(alone)
        plant.AddWeldConstraint(frame.body(), frame.GetFixedPoseInBodyFrame(), body, X_OE)
    plant.Finalize()
    return plant, frames, body


def _torque(arm: Solo, q, qd, share, F_O, p_WO):
    """(10b): torque, p_OoEo_W, and the wrench at the gripper of which it is J^T, without gravity."""
    plant, context = arm.plant, arm.plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, np.concatenate([q, qd]))
    p_OoEo_W = arm.frame.CalcPoseInWorld(context).translation() - p_WO
    J = frame_jacobian(plant, context, arm.frame)
    tau = transport_torque(share, F_O, p_OoEo_W, J, gravity_torque(plant, context))
    return tau, p_OoEo_W, wrench_at_gripper(share * F_O, p_OoEo_W)
