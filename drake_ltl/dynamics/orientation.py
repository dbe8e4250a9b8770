"""Orientation in the paper's Euler angles and by rotation matrices: (2a), errors, and their slopes.

The paper writes an object's pose as x = (p, eta) with extrinsic Euler angles eta = (roll, pitch, yaw), and (10b) maps
the gradient by eta to a torque with J^O_j(x). That map does not exist where |pitch| = pi/2 (remark 1). The project's
controllers therefore measure orientation by the rotation matrix, `rotation_mismatch`; both forms are here, and equal
where both exist. Angles in rad; functions take AutoDiffXd as well as floats.
"""

from __future__ import annotations

from math import hypot

import numpy as np

SINGULAR_COSINE = 1e-6
"""At a smaller cosine of the pitch, rates of roll and yaw are more than a million times the angular velocity."""


def rotation_from_euler(eta: np.ndarray) -> np.ndarray:
    """R_WO (3, 3) = Rz(yaw) Ry(pitch) Rx(roll), for eta = (roll, pitch, yaw) (3,): turns about the world's axes."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(eta), np.cos(eta)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def euler_from_rotation(R_WO: np.ndarray) -> np.ndarray:
    """eta (3,) with |pitch| <= pi/2, roll and yaw in (-pi, pi].

    Where |pitch| = pi/2, R determines roll and yaw only together: all of it is given to yaw, and roll is zero.
    """
    cosine = np.sqrt(R_WO[0, 0] ** 2 + R_WO[1, 0] ** 2)
    pitch = np.arctan2(-R_WO[2, 0], cosine)
    if cosine < SINGULAR_COSINE:
        return np.array([0.0, pitch, np.arctan2(-R_WO[0, 1], R_WO[1, 1])])
    return np.array([np.arctan2(R_WO[2, 1], R_WO[2, 2]), pitch, np.arctan2(R_WO[1, 0], R_WO[0, 0])])


def is_representation_singular(eta: np.ndarray) -> bool:
    """Whether eta (3,) is outside the set S^O_j: |pitch| = pi/2, up to SINGULAR_COSINE."""
    return bool(abs(np.cos(eta[1])) < SINGULAR_COSINE)


def angular_velocity_map(eta: np.ndarray) -> np.ndarray:
    """E(eta) (3, 3) with omega_W = E d(eta)/dt: its columns are the axes of roll, pitch and yaw; det E = cos pitch."""
    (_, sp, sy), (_, cp, cy) = np.sin(eta), np.cos(eta)
    return np.array([[cy * cp, -sy, 0.0], [sy * cp, cy, 0.0], [-sp, 0.0, 1.0]])


def euler_rate_map(eta: np.ndarray) -> np.ndarray:
    """E^-1 (3, 3): d(eta)/dt = E^-1 omega_W.

    Raises:
        ValueError: at the representation singularity |pitch| = pi/2.
    """
    if is_representation_singular(eta):
        raise ValueError(f"representation singularity: pitch is {float(_value(eta[1]))!r} rad, roll and yaw are one")
    (_, sp, sy), (_, cp, cy) = np.sin(eta), np.cos(eta)
    return np.array([[cy / cp, sy / cp, 0.0], [-sy, cy, 0.0], [cy * sp / cp, sy * sp / cp, 1.0]])


def representation_jacobian(eta: np.ndarray) -> np.ndarray:
    """J^O_j(x) (6, 6) of (2a): d(eta; p)/dt = J^O_j v_O, v_O = (omega; v) in W.

    Its transpose takes the gradient by (eta; p) to a wrench, as (10b) does.

    Raises:
        ValueError: at the representation singularity |pitch| = pi/2.
    """
    rates = euler_rate_map(eta)
    jacobian = np.eye(6).astype(rates.dtype)
    jacobian[:3, :3] = rates
    return jacobian


def euler_mismatch(eta: np.ndarray, eta_goal: np.ndarray) -> tuple[float, np.ndarray]:
    """|eta - eta*|^2 [rad^2], each difference taken the short way round, and its slope (3,) along omega_W.

    Raises:
        ValueError: at the representation singularity, where the slope grows beyond all bounds.
    """
    difference = eta - eta_goal
    error = np.arctan2(np.sin(difference), np.cos(difference))
    return error @ error, euler_rate_map(eta).T @ (2.0 * error)


def rotation_mismatch(R_WO: np.ndarray, R_WO_goal: np.ndarray) -> tuple[float, np.ndarray]:
    """3 - tr(R*^T R) = 2 (1 - cos angle), and its slope (3,) along omega_W, without any singularity.

    Near the goal it is the square of the angle between both, as `euler_mismatch` is with eta* = 0. Its other critical
    points are half turns away from the goal, all of them unstable.
    """
    Q = R_WO @ R_WO_goal.T
    slope = np.array([Q[2, 1] - Q[1, 2], Q[0, 2] - Q[2, 0], Q[1, 0] - Q[0, 1]])
    return 3.0 - Q[0, 0] - Q[1, 1] - Q[2, 2], slope


def quaternion_difference(q_WB: np.ndarray, q_WA: np.ndarray) -> np.ndarray:
    """The unit quaternion (4,) of R_WB R_WA^T, the turn in W that takes A to B; for q = (w, x, y, z), of any length."""
    return np.array(_difference(q_WB, q_WA))


def quaternion_mismatch(q_WO: np.ndarray, q_WO_goal: np.ndarray) -> tuple[float, np.ndarray]:
    """`rotation_mismatch` of quaternions (4,): 4 |v|^2 and its slope 4 w v (3,), for the difference (w, v)."""
    w, x, y, z = _difference(q_WO, q_WO_goal)
    return 4.0 * (x * x + y * y + z * z), np.array([4.0 * w * x, 4.0 * w * y, 4.0 * w * z])


def tilt_mismatch(q_WO: np.ndarray, q_WO_goal: np.ndarray) -> tuple[float, tuple[float, float]]:
    """1 - cos of the angle between the vertical and what is vertical at the goal, for quaternions (4,), and its slope
    along omega_x and omega_y in W; turns about the vertical leave it as it is."""
    w, x, y, z = _difference(q_WO, q_WO_goal)
    return 2.0 * (x * x + y * y), (2.0 * (w * x - y * z), 2.0 * (w * y + x * z))


def _difference(q_WB: np.ndarray, q_WA: np.ndarray) -> tuple[float, float, float, float]:
    """In numbers, which are quick."""
    a, b, c, d = q_WB.tolist()
    e, f, g, h = q_WA.tolist()
    w, x, y, z = (
        a * e + b * f + c * g + d * h,
        b * e - a * f + d * g - c * h,
        c * e - a * g + b * h - d * f,
        d * e - a * h + c * f - b * g,
    )
    length = hypot(w, x, y, z)
    return w / length, x / length, y / length, z / length


def heading_difference(q_WB: np.ndarray, q_WA: np.ndarray) -> float:
    """By how much B is turned from A about the vertical [rad], in (-pi, pi]; what is left is tilt."""
    w, _, _, z = _difference(q_WB, q_WA)
    return float(2.0 * np.arctan2(z, w) if w >= 0.0 else 2.0 * np.arctan2(-z, -w))


def _value(x) -> float:
    """Of a float or an AutoDiffXd."""
    return x.value() if hasattr(x, "value") else x
