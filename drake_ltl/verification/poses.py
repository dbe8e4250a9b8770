"""Recorded poses as matrices."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation


def rotations(pose: np.ndarray) -> Rotation:
    """T orientations of recorded poses (T, 7): quaternion (w, x, y, z), then origin."""
    return Rotation.from_quat(pose[:, [1, 2, 3, 0]])


def matrices(pose: np.ndarray) -> np.ndarray:
    """(T, 4, 4) homogeneous transforms of recorded poses (T, 7)."""
    X = np.zeros((len(pose), 4, 4))
    X[:, :3, :3] = rotations(pose).as_matrix()
    X[:, :3, 3], X[:, 3, 3] = pose[:, 4:], 1.0
    return X


def angle(R: np.ndarray) -> np.ndarray:
    """(...,) [rad] by which rotation matrices (..., 3, 3) turn; exact for small angles too."""
    axis = np.stack([R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]], axis=-1)
    return np.arctan2(np.linalg.norm(axis, axis=-1), np.trace(R, axis1=-2, axis2=-1) - 1.0)
