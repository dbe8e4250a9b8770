"""Modelling and control of the paper, eqs. (1) to (10), as pure functions of arrays or of a plant and its context."""

from drake_ltl.dynamics.control_laws import (
    GRAVITY,
    MAX_GROWTH,
    body_gravity,
    growing_damping,
    speed_of,
    team_damping,
    team_wrench,
    transition_torque,
    transport_torque,
)
from drake_ltl.dynamics.coupled import admissible_twists, coupled_dynamics, object_dynamics
from drake_ltl.dynamics.grasp import (
    grasp_matrix,
    grasp_matrix_rate,
    object_to_agent_jacobian,
    object_to_agent_jacobian_rate,
    skew,
    wrench_at_gripper,
)
from drake_ltl.dynamics.held_damping import HeldDamping, velocity_after
from drake_ltl.dynamics.joint_space import (
    JointDynamics,
    coriolis_matrix,
    frame_jacobian,
    frame_jacobian_rate,
    gravity_torque,
    inertia_matrix,
    joint_dynamics,
)
from drake_ltl.dynamics.load_sharing import check_load_shares, internal_wrenches, load_shares
from drake_ltl.dynamics.orientation import (
    angular_velocity_map,
    euler_from_rotation,
    euler_mismatch,
    euler_rate_map,
    heading_difference,
    is_representation_singular,
    quaternion_difference,
    quaternion_mismatch,
    representation_jacobian,
    rotation_from_euler,
    rotation_mismatch,
)
from drake_ltl.dynamics.spatial import SpatialDynamics
from drake_ltl.dynamics.task_space import null_space_wrench, task_dynamics, task_inverse
from drake_ltl.dynamics.tracking import quintic, tracking_acceleration
from drake_ltl.dynamics.wrist import wrench_on_object

__all__ = [
    "GRAVITY",
    "MAX_GROWTH",
    "HeldDamping",
    "JointDynamics",
    "SpatialDynamics",
    "admissible_twists",
    "angular_velocity_map",
    "body_gravity",
    "check_load_shares",
    "coriolis_matrix",
    "coupled_dynamics",
    "euler_from_rotation",
    "euler_mismatch",
    "euler_rate_map",
    "frame_jacobian",
    "frame_jacobian_rate",
    "grasp_matrix",
    "grasp_matrix_rate",
    "gravity_torque",
    "growing_damping",
    "heading_difference",
    "inertia_matrix",
    "internal_wrenches",
    "is_representation_singular",
    "joint_dynamics",
    "load_shares",
    "null_space_wrench",
    "object_dynamics",
    "object_to_agent_jacobian",
    "object_to_agent_jacobian_rate",
    "quaternion_difference",
    "quaternion_mismatch",
    "quintic",
    "representation_jacobian",
    "rotation_from_euler",
    "rotation_mismatch",
    "skew",
    "speed_of",
    "task_dynamics",
    "task_inverse",
    "team_damping",
    "team_wrench",
    "tracking_acceleration",
    "transition_torque",
    "transport_torque",
    "velocity_after",
    "wrench_at_gripper",
    "wrench_on_object",
]
