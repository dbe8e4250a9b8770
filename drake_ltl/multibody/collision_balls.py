"""Balls whose convex hulls cover the collision geometry of bodies: what radii are measured from."""

from __future__ import annotations

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    Mesh,
    SceneGraphInspector,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody

from drake_ltl.errors import DrakeLtlError

RIM_SEGMENTS = 32
"""A cylinder's rim counts as the regular polygon around it with this many corners (0.5 % larger at its corners)."""

RIM_POINTS = 128
"""... and inside it as the polygon with this many corners (0.03 % smaller between them)."""


def body_balls(
    plant: MultibodyPlant, inspector: SceneGraphInspector, body: RigidBody, *, inside: bool = False
) -> np.ndarray:
    """(n, 4) rows (x, y, z, radius) [m] in the body's frame; their convex hull covers its collision geometry.

    Args:
        inside: the hull lies in the geometry's instead (see `shape_balls`).
    """
    balls = [
        moved(inspector.GetPoseInFrame(geometry), shape_balls(inspector.GetShape(geometry), inside=inside))
        for geometry in plant.GetCollisionGeometriesForBody(body)
    ]
    return np.concatenate(balls) if balls else np.zeros((0, 4))


def moved(X_AB: RigidTransform, balls_B: np.ndarray) -> np.ndarray:
    """The balls (n, 4), given in B, in A."""
    return np.column_stack([(X_AB @ balls_B[:, :3].T).T, balls_B[:, 3]])


def farthest(balls: np.ndarray, point: np.ndarray) -> float:
    """Largest distance [m] from the point (3,) to a point of the balls (n, 4)."""
    return float((np.linalg.norm(balls[:, :3] - point, axis=1) + balls[:, 3]).max())


def farthest_of_each(places: list[list[tuple[RigidTransform, np.ndarray]]], balls: list[np.ndarray]) -> np.ndarray:
    """(k,) `farthest` [m] of k configurations at once: of all their bodies' balls.

    Args:
        places: of each configuration, for each body, X_WB and the point (3,) in W to measure from.
        balls: of each body, (n, 4) in its frame; n may be 0.
    """
    most = np.zeros(len(places))
    for body, own in enumerate(balls):
        X_WB = np.array([row[body][0].GetAsMatrix34() for row in places])
        from_point = X_WB[:, :, 3] - [row[body][1] for row in places]
        p = X_WB[:, :, :3] @ own[:, :3].T + from_point[:, :, None]  # (k, 3, n)
        most = np.maximum(most, (np.linalg.norm(p, axis=1) + own[:, 3]).max(axis=1, initial=0.0))
    return most


def shape_balls(shape: Shape, *, inside: bool = False) -> np.ndarray:
    """(n, 4) rows (x, y, z, radius) [m] in the shape's frame; their convex hull covers the shape.

    Args:
        inside: balls in the shape instead, whose hull reaches nearly as far. The two differ for round shapes
            only: a cylinder, as many points of its rims, and an ellipsoid, as points of its surface.

    Raises:
        DrakeLtlError: an unbounded shape, such as a half-space.
    """
    if isinstance(shape, Box):
        return _points(_CORNERS * np.asarray(shape.size()) / 2)
    if isinstance(shape, Sphere):
        return np.array([[0.0, 0.0, 0.0, shape.radius()]])
    if isinstance(shape, Capsule):
        half, radius = shape.length() / 2, shape.radius()
        return np.array([[0.0, 0.0, -half, radius], [0.0, 0.0, half, radius]])
    if isinstance(shape, Ellipsoid):
        return _points((_DIRECTIONS if inside else _CORNERS) * [shape.a(), shape.b(), shape.c()])
    if isinstance(shape, Cylinder):
        segments = RIM_POINTS if inside else RIM_SEGMENTS
        corner = shape.radius() if inside else shape.radius() / np.cos(np.pi / segments)
        return _points(_prism(corner, shape.length() / 2, segments))
    if isinstance(shape, (Convex, Mesh)):
        surface = shape.GetConvexHull()
        return _points(np.array([surface.vertex(i) for i in range(surface.num_vertices())]))
    raise DrakeLtlError(f"a collision geometry of type {type(shape).__name__} has no finite radius")


_CORNERS = np.array(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0])).reshape(3, 8).T
_GRID = np.array(np.meshgrid(*3 * [np.linspace(-1.0, 1.0, 9)])).reshape(3, -1).T
_SURFACE = _GRID[np.abs(_GRID).max(axis=1) == 1.0]  # of a cube
_DIRECTIONS = _SURFACE / np.linalg.norm(_SURFACE, axis=1, keepdims=True)


def _points(points: np.ndarray) -> np.ndarray:
    return np.column_stack([points, np.zeros(len(points))])


def _prism(corner: float, half_length: float, segments: int) -> np.ndarray:
    """Corners (2 segments, 3) of a prism about z, at a distance of `corner` from the axis."""
    angles = 2 * np.pi * np.arange(segments) / segments
    rim = corner * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(segments)])
    up = np.array([0.0, 0.0, half_length])
    return np.concatenate([rim - up, rim + up])
