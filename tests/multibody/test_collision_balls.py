"""Balls whose convex hull covers a shape."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.geometry import Box, Capsule, Convex, Cylinder, Ellipsoid, HalfSpace, Mesh, Sphere
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.framework import DiagramBuilder

from drake_ltl.errors import DrakeLtlError
from drake_ltl.multibody.collision_balls import RIM_POINTS, RIM_SEGMENTS, body_balls, farthest, moved, shape_balls

TETRAHEDRON = """\
v 0 0 0
v 0.3 0 0
v 0 0.5 0.1
v 0.1 0.1 0.9
f 1 3 2
f 1 2 4
f 2 3 4
f 1 4 3
"""
units = st.floats(-1.0, 1.0)
triples = arrays(float, 3, elements=units)
directions = triples.filter(lambda d: np.linalg.norm(d) > 1e-3).map(lambda d: d / np.linalg.norm(d))
lengths = st.floats(0.05, 2.0)


def support(balls: np.ndarray, direction: np.ndarray) -> float:
    """Largest extent of the balls' hull along a unit vector."""
    return float((balls[:, :3] @ direction + balls[:, 3]).max())


def box_support(d, size) -> float:
    return float(np.abs(d) @ np.asarray(size) / 2)


SHAPES = {
    "box": (lambda a, b, c: Box(a, b, c), lambda d, a, b, c: box_support(d, (a, b, c))),
    "sphere": (lambda a, b, c: Sphere(a), lambda d, a, b, c: a),
    "capsule": (lambda a, b, c: Capsule(a, b), lambda d, a, b, c: a + abs(d[2]) * b / 2),
    "cylinder": (lambda a, b, c: Cylinder(a, b), lambda d, a, b, c: a * np.hypot(d[0], d[1]) + abs(d[2]) * b / 2),
    "ellipsoid": (lambda a, b, c: Ellipsoid(a, b, c), lambda d, a, b, c: np.linalg.norm(d * [a, b, c])),
}


@pytest.mark.parametrize("name", SHAPES)
@given(a=lengths, b=lengths, c=lengths, direction=directions)
def test_hull_covers_the_shape(name, a, b, c, direction):
    """A convex set covers another iff it reaches at least as far in every direction; the shapes' supports by hand."""
    make, by_hand = SHAPES[name]
    assert support(shape_balls(make(a, b, c)), direction) >= by_hand(direction, a, b, c) - 1e-12


@pytest.mark.parametrize("name", SHAPES)
@given(a=lengths, b=lengths, c=lengths, direction=directions)
def test_inner_balls_stay_inside_the_shape_and_reach_nearly_as_far(name, a, b, c, direction):
    """Rims have 128 corners (0.03 % short between them); the ellipsoid's points are up to 7 degrees apart (1.5 %)."""
    make, by_hand = SHAPES[name]
    reach, exact = support(shape_balls(make(a, b, c), inside=True), direction), by_hand(direction, a, b, c)
    assert reach <= exact + 1e-12
    assert reach >= (1 - 0.015 if name == "ellipsoid" else np.cos(np.pi / RIM_POINTS)) * exact - 1e-12


@pytest.mark.parametrize("name", ["box", "sphere", "capsule"])
@given(a=lengths, b=lengths, c=lengths, direction=directions)
def test_hull_is_tight_where_the_shape_is_a_hull_of_balls(name, a, b, c, direction):
    make, by_hand = SHAPES[name]
    assert support(shape_balls(make(a, b, c)), direction) == pytest.approx(by_hand(direction, a, b, c), abs=1e-12)


@given(a=lengths, b=lengths, direction=directions)
def test_hull_of_a_cylinder_is_half_a_percent_larger_at_most(a, b, direction):
    make, by_hand = SHAPES["cylinder"]
    largest = by_hand(direction, a / np.cos(np.pi / RIM_SEGMENTS), b, 0)
    assert support(shape_balls(make(a, b, 0)), direction) <= largest + 1e-12


@pytest.mark.parametrize("shape", [Mesh, Convex])
def test_hull_covers_a_mesh(tmp_path, shape):
    path = tmp_path / "tetrahedron.obj"
    path.write_text(TETRAHEDRON, encoding="utf-8")
    balls = shape_balls(shape(str(path), 2.0))
    corners = 2.0 * np.array([[0, 0, 0], [0.3, 0, 0], [0, 0.5, 0.1], [0.1, 0.1, 0.9]])
    assert np.all(balls[:, 3] == 0.0)
    found = balls[np.lexsort(balls.T), :3]
    np.testing.assert_allclose(np.sort(found, axis=0), np.sort(corners, axis=0), atol=1e-6)


def test_a_half_space_has_no_radius():
    with pytest.raises(DrakeLtlError, match="HalfSpace"):
        shape_balls(HalfSpace())


@given(rpy=triples, p=triples, direction=directions)
def test_moved_balls_are_the_balls_elsewhere(rpy, p, direction):
    X = RigidTransform(RollPitchYaw(3.0 * rpy), 5.0 * p)
    balls = shape_balls(Capsule(0.2, 1.0))
    expected = support(balls, X.rotation().inverse() @ direction) + direction @ X.translation()
    assert support(moved(X, balls), direction) == pytest.approx(expected, abs=1e-12)


@given(points=arrays(float, (3, 3), elements=st.floats(-2.0, 2.0)), centre=triples, direction=directions)
def test_no_point_is_farther_than_the_farthest(points, centre, direction):
    balls = np.column_stack([points, [0.1, 0.2, 0.3]])
    surface = balls[:, :3] + balls[:, 3:] * direction
    reach = farthest(balls, centre)
    assert np.linalg.norm(surface - centre, axis=1).max() <= reach + 1e-12
    index = int(np.argmax(np.linalg.norm(points - centre, axis=1) + balls[:, 3]))
    away = points[index] - centre
    if np.linalg.norm(away) > 1e-6:
        tip = points[index] + balls[index, 3] * away / np.linalg.norm(away)
        assert np.linalg.norm(tip - centre) == pytest.approx(reach)


def test_a_body_s_balls_are_those_of_all_its_shapes():
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    body = plant.AddRigidBody("body", SpatialInertia.SolidSphereWithMass(1.0, 0.1))
    bare = plant.AddRigidBody("bare", SpatialInertia.SolidSphereWithMass(1.0, 0.1))
    X = RigidTransform(RollPitchYaw(0.3, 0.2, 0.1), [1.0, 2.0, 3.0])
    for name, shape in (("ball", Sphere(0.1)), ("box", Box(1, 2, 3))):
        plant.RegisterCollisionGeometry(body, X, shape, name, CoulombFriction(1, 1))
        plant.RegisterVisualGeometry(body, RigidTransform([9.0, 0, 0]), shape, name, np.ones(4))  # does not touch
    plant.Finalize()
    inspector = scene_graph.model_inspector()
    expected = np.concatenate([moved(X, shape_balls(Sphere(0.1))), moved(X, shape_balls(Box(1, 2, 3)))])
    np.testing.assert_allclose(body_balls(plant, inspector, body), expected)
    assert body_balls(plant, inspector, bare).shape == (0, 4)
