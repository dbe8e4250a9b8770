"""The navigation function of bodies with goal poses."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from drake_ltl.errors import InvalidInputError
from drake_ltl.navigation import RegionBall, StaticBody, Traveller, step_relations
from drake_ltl.navigation.dipolar_field import DipolarField
from drake_ltl.navigation.dipole import Dipole

HOME = RegionBall("home", (0.0, 0.0, 0.0), 8.0)
GOALS = [(4.0, 0.0, 0.3), (-4.0, 0.5, 2.0), (0.0, 4.0, -1.0)]


@pytest.fixture(scope="module")
def step():
    """Three movers across each other, a body near the middle."""
    travellers = [
        Traveller(f"a{i}", 0.3, "home", "home", (-x, -y, 0.1), (x, y, 0.1)) for i, (x, y, _) in enumerate(GOALS)
    ]
    return step_relations(
        travellers=travellers,
        static_objects=[StaticBody("o1", 0.5, (0.5, -0.7, 0.2))],
        regions=[HOME],
        workspace_radius=8.0,
    )


@pytest.fixture(scope="module")
def field(step) -> DipolarField:
    return DipolarField.of(step, [Dipole((x, y), theta) for x, y, theta in GOALS], force=20.0, kappa=12.0)


@given(p=arrays(float, (3, 2), elements=st.floats(-5.0, 5.0)))
def test_forces_are_the_negative_gradient(field, p):
    assume(np.isfinite(field.value(p)))
    value, forces = field.value_and_forces(p)
    assume(np.abs(forces).max() < 1e3)  # nearer to an obstacle the steps below would be too long
    expected = np.empty((3, 2))
    for index in np.ndindex(3, 2):
        d = np.zeros((3, 2))
        d[index] = 1e-5
        expected[index] = -(field.value(p + d) - field.value(p - d)) / 2e-5
    np.testing.assert_allclose(forces, expected, rtol=1e-4, atol=1e-4)
    assert value == pytest.approx(field.value(p), rel=1e-12)


def test_broadcasts(field):
    p = np.random.default_rng(0).uniform(-4.0, 4.0, size=(7, 5, 3, 2))
    values, forces = field.value_and_forces(p)
    assert values.shape == (7, 5)
    assert forces.shape == p.shape
    one_value, one = field.value_and_forces(p[6, 4])
    np.testing.assert_allclose(forces[6, 4], one, rtol=1e-12)
    assert values[6, 4] == pytest.approx(one_value, rel=1e-12)


def test_zero_at_the_goal_and_nan_in_collision(field):
    goal = np.array(GOALS)[:, :2]
    value, forces = field.value_and_forces(goal)
    assert value == 0.0
    assert np.all(forces == 0.0)
    together = goal.copy()
    together[1] = together[0] + [0.1, 0.0]
    value, forces = field.value_and_forces(together)
    assert value == np.inf
    assert np.isnan(forces).any()
    assert "a0" in str(field.violated(together)[0])


def test_dipoles_stand_at_the_goals(step):
    dipoles = [Dipole((x, y), theta) for x, y, theta in GOALS]
    for wrong in (dipoles[:2], dipoles[::-1], []):
        with pytest.raises(InvalidInputError, match="one dipole for each mover"):
            DipolarField.of(step, wrong, force=20.0, kappa=12.0)
    with pytest.raises(InvalidInputError, match="force"):
        DipolarField.of(step, dipoles, force=0.0, kappa=12.0)
