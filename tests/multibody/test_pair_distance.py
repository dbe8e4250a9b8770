"""Distances between true geometries against what can be worked out by hand."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from pydrake.math import RollPitchYaw

from drake_ltl.multibody import AgentModel
from drake_ltl.multibody.object_model import ObjectModel
from drake_ltl.multibody.pair_distance import FAR, PairDistance
from drake_ltl.multibody.postures import grasp_configurations

UPRIGHT = np.zeros(4)  # the planar arm with both links up
BASE, TOP = 0.25, 0.2  # half of its base's width, and the base's height [m]


@pytest.fixture(scope="module")
def crate(make_object) -> ObjectModel:
    return ObjectModel(make_object())


@pytest.fixture(scope="module")
def to_crate(make_agent, crate) -> PairDistance:
    return PairDistance(make_agent(), crate)


def pose(x: float, y: float, height: float, heading: float = 0.0) -> np.ndarray:
    return np.array([*RollPitchYaw(0.0, 0.0, heading).ToQuaternion().wxyz(), x, y, height])


@pytest.mark.parametrize("gap", [0.3, 0.02, -0.01])
def test_two_robots_side_by_side(make_agent, gap):
    """Their bases are boxes."""
    distance = PairDistance(make_agent(), dataclasses.replace(make_agent(), name="a2"))
    other = UPRIGHT + np.array([0.0, 2 * BASE + gap, 0.0, 0.0])
    assert distance(UPRIGHT, other) == pytest.approx(gap, abs=1e-6)
    assert distance(UPRIGHT, UPRIGHT + np.array([0.0, 5.0, 0.0, 0.0])) == FAR


def test_a_base_before_a_handle(to_crate, crate):
    """The handle's ring, of radius 0.3 m and 24 mm thick, is 0.4 m above the floor: the nearest of the crate."""
    q = UPRIGHT - [BASE + 0.3 + 0.2, 0.0, 0.0, 0.0]
    expected = np.hypot(0.2, crate.height + 0.15 - TOP) - 0.012
    assert to_crate(q, pose(0.0, 0.0, crate.height)) == pytest.approx(expected, abs=1e-5)  # its file has 5 decimals


def test_where_it_is_does_not_matter(to_crate, make_agent, crate):
    """Nor the length of the quaternion."""
    q = grasp_configurations(AgentModel(make_agent()), crate.X_OG, crate.height)[0].q
    near = to_crate(q, pose(0.0, 0.0, crate.height))
    there = pose(3.0, -4.0, crate.height) * np.array([1.1, 1.1, 1.1, 1.1, 1.0, 1.0, 1.0])
    assert to_crate(q + np.array([3.0, -4.0, 0.0, 0.0]), there) == pytest.approx(near, abs=1e-9)


def test_grippers_are_to_touch_handles(to_crate, make_agent, crate):
    """Nothing else of an object may be touched: by another name the handles count."""
    q = grasp_configurations(AgentModel(make_agent()), crate.X_OG, crate.height)[0].q
    at = pose(0.0, 0.0, crate.height)
    assert to_crate(q, at) > 0.05
    parts = tuple(dataclasses.replace(part, name=f"rail_{i}") for i, part in enumerate(crate.collision))
    renamed = ObjectModel(crate.object)
    renamed.collision = parts
    assert PairDistance(make_agent(), renamed)(q, at) < 0.01


def test_corners_come_near_to_the_gripper(to_crate, make_agent, crate):
    """A gripper at the ring is farthest from a face, nearest to a corner; and hits the body when pushed on."""
    q = grasp_configurations(AgentModel(make_agent()), crate.X_OG, crate.height)[0].q
    distances = [to_crate(q, pose(0.0, 0.0, crate.height, heading)) for heading in np.deg2rad([0, 15, 30, 45])]
    assert np.all(np.diff(distances) < 0.0)
    assert 0.002 < distances[-1] < 0.01
    assert to_crate(q + np.array([0.02, 0.0, 0.0, 0.0]), pose(0.0, 0.0, crate.height, np.pi / 4)) < 0.0
