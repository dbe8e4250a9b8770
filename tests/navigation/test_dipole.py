"""gamma with a heading to arrive along."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from drake_ltl.errors import InvalidInputError
from drake_ltl.navigation.dipole import Dipole, heading_vector, left_of

LENGTH = st.floats(-20.0, 20.0)
DIPOLES = st.builds(
    Dipole,
    p_goal=st.tuples(LENGTH, LENGTH),
    heading=st.floats(-4.0, 4.0),
    ratio=st.floats(0.05, 1.0),
    reach=st.floats(0.1, 5.0),
)
POINTS = arrays(float, 2, elements=LENGTH)


@given(dipole=DIPOLES, p=POINTS)
def test_gradient_is_that_of_the_value(dipole, p):
    step = 1e-4 * dipole.reach  # error of its square times a third derivative of about 1 / reach
    expected = [(dipole.value(p + d) - dipole.value(p - d)) / (2.0 * step) for d in step * np.eye(2)]
    np.testing.assert_allclose(dipole.gradient(p), expected, rtol=1e-6, atol=1e-6)


@given(dipole=DIPOLES, p=POINTS)
def test_positive_and_zero_at_the_goal_alone(dipole, p):
    goal = np.array(dipole.p_goal)
    squared = np.sum((p - goal) ** 2)
    assert dipole.value(goal) == 0.0
    assert dipole.value(p) >= dipole.ratio * squared * (1.0 - 1e-9)
    assert dipole.value(p) <= squared * (1.0 + 1e-9)
    assert dipole.gradient(p) @ (p - goal) >= 2.0 * dipole.ratio * squared * (1.0 - 1e-9)  # downhill is to the goal


@given(dipole=DIPOLES, p=POINTS)
def test_strictly_convex(dipole, p):
    """The Hessian's least eigenvalue is 2 ratio, at the goal, or more."""
    step = 1e-4 * dipole.reach
    rows = [(dipole.gradient(p + d) - dipole.gradient(p - d)) / (2.0 * step) for d in step * np.eye(2)]
    least = np.linalg.eigvalsh(np.add(rows, np.transpose(rows)) / 2.0)[0]
    assert least >= 2.0 * dipole.ratio - 1e-5  # of central differences


@given(p=POINTS, heading=st.floats(-4.0, 4.0))
def test_ratio_one_is_the_papers_gamma(p, heading):
    dipole = Dipole((1.0, -2.0), heading, ratio=1.0)
    assert dipole.value(p) == pytest.approx(np.sum((p - [1.0, -2.0]) ** 2), rel=1e-12)


def test_far_away_all_directions_count_the_same():
    dipole = Dipole((0.0, 0.0), 0.3, ratio=0.1, reach=0.5)
    p = 50.0 * heading_vector(0.3)
    slope = dipole.gradient(p) / np.linalg.norm(p)
    np.testing.assert_allclose(slope, 2.0 * heading_vector(0.3), rtol=1e-3)  # (reach / 50)^2 = 1e-4 of it is left


def test_descents_arrive_along_the_heading():
    """From all around: the slope l / s dies away as s^(1 / ratio - 1)."""
    dipole = Dipole((2.0, 1.0), 0.7)
    around = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False) + 0.1
    p = np.array(dipole.p_goal) + 4.0 * heading_vector(around)
    while np.linalg.norm(p - dipole.p_goal, axis=-1).max() > 1e-3:
        p = p - 0.02 * dipole.gradient(p)
    e = p - np.array(dipole.p_goal)
    h = heading_vector(dipole.heading)
    assert np.abs((e @ left_of(h)) / (e @ h)).max() < 1e-3


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ({"ratio": 0.0}, "dipole.ratio"),
        ({"ratio": 1.5}, "dipole.ratio"),
        ({"reach": 0.0}, "dipole.reach"),
        ({"reach": np.inf}, "dipole.reach"),
        ({"heading": np.nan}, "dipole.goal"),
    ],
)
def test_bad_parameters_are_refused(change, where):
    with pytest.raises(InvalidInputError, match=where):
        Dipole(**{"p_goal": (0.0, 0.0), "heading": 0.0} | change)
