"""The wrench f_i that an agent puts on its object, read off a simulated plant."""

from __future__ import annotations

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, Joint, JointIndex
from pydrake.systems.framework import Context


def wrench_on_object(plant: MultibodyPlant, context: Context, frame: Frame) -> np.ndarray:
    """f_i (6,) [N m; N] of (1a), (6): what the end-effector puts on the object it is welded to, at Eo, in W.

    Drake offers no output for the force in a weld constraint. But it does for the reaction in the joint inboard of the
    end-effector (a fixed one will do); less the weight and the inertia of that one body, this is what is handed on.
    A discrete plant's outputs are those of the step it took last; nothing else may touch the end-effector.

    Args:
        frame: {E_i}; its body carries nothing but the object.
    """
    body = frame.body()
    reactions = plant.get_reaction_forces_output_port().Eval(context)
    joint = _inboard_joint(plant, frame)
    F = reactions[int(joint.index())]
    X_WJ, X_WB = joint.frame_on_child().CalcPoseInWorld(context), body.EvalPoseInWorld(context)
    torque, force = X_WJ.rotation().multiply(F.rotational()), X_WJ.rotation().multiply(F.translational())

    A = plant.get_body_spatial_accelerations_output_port().Eval(context)[int(body.index())]
    w, alpha = body.EvalSpatialVelocityInWorld(context).rotational(), A.rotational()
    inertia = body.CalcSpatialInertiaInBodyFrame(context)
    p = X_WB.rotation().multiply(inertia.get_com())
    R = X_WB.rotation().matrix()
    I_cm = R @ inertia.Shift(inertia.get_com()).CalcRotationalInertia().CopyToFullMatrix3() @ R.T
    a_cm = A.translational() + np.cross(alpha, p) + np.cross(w, np.cross(w, p))
    own_force = inertia.get_mass() * (a_cm - plant.gravity_field().gravity_vector())
    own_torque = I_cm @ alpha + np.cross(w, I_cm @ w)

    p_WE, p_WCm = frame.CalcPoseInWorld(context).translation(), X_WB.translation() + p
    torque = torque + np.cross(X_WJ.translation() - p_WE, force)
    own_torque = own_torque + np.cross(p_WCm - p_WE, own_force)
    return np.concatenate([torque - own_torque, force - own_force])


def _inboard_joint(plant: MultibodyPlant, frame: Frame) -> Joint:
    for index in plant.GetJointIndices(frame.model_instance()):
        joint = plant.get_joint(JointIndex(index))
        if joint.child_body().index() == frame.body().index():
            return joint
    raise ValueError(f"no joint carries the body {frame.body().name()!r} of frame {frame.name()!r}")
