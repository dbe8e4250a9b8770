"""h_O: a potential with a slope, zero at the goal, which lifts what is carried and keeps it level."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from drake_ltl.dynamics.load_spring import DESCENT, LIFT, TILT_STIFFNESS, LoadSpring
from drake_ltl.scenario.model import Tolerances

STEP = 1e-6
GOAL = np.array([3.0, -2.0, 0.25])
HEADING = Rotation.from_rotvec([0.0, 0.0, 0.7])
offsets = arrays(float, 3, elements=st.floats(-2.0, 2.0))
turns = arrays(float, 3, elements=st.floats(-1.5, 1.5))


def quaternion(R: Rotation) -> np.ndarray:
    return np.roll(R.as_quat(), 1)


def pose(p: np.ndarray, R: Rotation, length: float = 1.0) -> np.ndarray:
    return np.concatenate([length * quaternion(R), p])


@pytest.fixture(scope="module")
def spring() -> LoadSpring:
    return LoadSpring(GOAL, quaternion(HEADING))


@given(offset=offsets, turn=turns, length=st.floats(0.5, 2.0))
def test_slope_is_that_of_the_value(spring, offset, turn, length):
    p, R = GOAL + offset, Rotation.from_rotvec(turn) * HEADING
    value, slope = spring.value_and_slope(pose(p, R, length))
    assert value >= 0.0
    turned = [_difference(lambda h, e=e: pose(p, Rotation.from_rotvec(h * e) * R), spring) for e in np.eye(3)]
    moved = [_difference(lambda h, e=e: pose(p + h * e, R), spring) for e in np.eye(3)]
    # relative to forces of thousands of newtons at metres off
    np.testing.assert_allclose(slope, [*turned, *moved], rtol=1e-6, atol=1e-3)


def _difference(at, spring) -> float:
    return (spring.value_and_slope(at(STEP))[0] - spring.value_and_slope(at(-STEP))[0]) / (2 * STEP)


def test_nothing_is_left_at_the_goal_and_turns_about_the_vertical_are_free(spring):
    for turn in (0.0, 1.0, -2.5):
        value, slope = spring.value_and_slope(pose(GOAL, Rotation.from_rotvec([0.0, 0.0, turn]) * HEADING))
        assert value == pytest.approx(0.0, abs=1e-12)
        np.testing.assert_allclose(slope, 0.0, atol=1e-12)


@given(turn=turns)
def test_tilt_counts_by_its_cosine_whichever_way(spring, turn):
    R = Rotation.from_rotvec(turn)
    value = spring.value_and_slope(pose(GOAL, R * HEADING))[0]
    assert value == pytest.approx(TILT_STIFFNESS * (1.0 - R.as_matrix()[2, 2]), abs=1e-12)


@given(distance=st.floats(0.0, 50.0), azimuth=st.floats(-3.0, 3.0))
def test_it_is_lifted_on_its_way_and_down_where_goals_count_as_reached(spring, distance, azimuth):
    """At the height with the least h_O there is no force at all, in no direction."""
    away = distance * np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    lift = LIFT * distance**2 / (distance**2 + DESCENT**2)
    value, slope = spring.value_and_slope(pose(GOAL + away + [0.0, 0.0, lift], HEADING))
    assert value == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(slope, 0.0, atol=1e-9)
    if distance >= 1.0:
        assert lift >= 0.9 * LIFT
    if distance <= Tolerances().position:
        assert lift <= 1.2e-3


@given(distance=st.floats(0.0, 3.0), share=st.floats(0.0, 1.0))
def test_below_its_height_it_is_drawn_nowhere_but_to_the_goal(spring, distance, share):
    """So it adds no place of rest to those of k psi, whose pull along gamma is the same way."""
    lift = LIFT * distance**2 / (distance**2 + DESCENT**2)
    _, slope = spring.value_and_slope(pose(GOAL + np.array([distance, 0.0, share * lift]), HEADING))
    assert slope[3] >= -1e-12  # rounding of heights of some 0.1 m, times 1000 N/m
    assert slope[4] == 0.0


def test_energies_are_those_of_the_rows(spring):
    poses = np.array([pose(GOAL + np.array([d, 0.1, 0.02]), HEADING) for d in (0.0, 0.3, 5.0)])
    np.testing.assert_array_equal(spring.energy(poses), [spring.value_and_slope(row)[0] for row in poses])
