"""Critical points: how many there are, that they are alike for all shapings, that none is degenerate."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from drake_ltl.navigation import (
    Logarithmic,
    PaperPhi,
    PseudoHuber,
    RegionBall,
    StaticBody,
    Traveller,
    step_relations,
)
from drake_ltl.navigation.planar import PlanarField, sampled_starts

HOME = RegionBall("home", (0.0, 0.0, 0.0), 12.0)
OBSTACLES = [(0.0, 0.3, 2.0), (3.0, 6.0, 1.5), (-3.0, -6.0, 1.5), (5.0, -4.0, 1.0)]
SHAPINGS = [PseudoHuber(0.5), Logarithmic(2.0), PaperPhi(6.0)]


def step(goals=((8.0, 1.0),), starts=((-8.0, 0.0),), obstacles=OBSTACLES):
    travellers = [
        Traveller(f"a{k}", 1.0, "home", "home", (*a, 0.0), (*b, 0.0))
        for k, (a, b) in enumerate(zip(starts, goals, strict=True))
    ]
    static = [StaticBody(f"o{k}", r, (x, y, 0.0)) for k, (x, y, r) in enumerate(obstacles)]
    return step_relations(travellers=travellers, static_objects=static, regions=[HOME], workspace_radius=12.0)


def behind(field):
    """Places behind each obstacle as seen from the goal, where its saddle is."""
    for x, y, r in OBSTACLES:
        away = np.array([x, y]) - field.goal
        for distance in np.linspace(0.05, 3.0, 15):
            yield np.array([x, y]) + (r + 1.0 + distance) * away / np.linalg.norm(away)


def test_a_mover_among_obstacles_meets_one_saddle_behind_each_and_no_other_minimum():
    """Morse: on a disc with m holes, minima - saddles + maxima = 1 - m."""
    field = PlanarField.of(step(), kappa=8.0)

    found = field.critical_points([*behind(field), *sampled_starts(field.step, 60, 0)])

    assert [point.kind for point in found] == ["saddle"] * len(OBSTACLES)


def test_too_small_a_kappa_has_another_minimum_and_one_saddle_more():
    field = PlanarField.of(step(), kappa=2.0)

    kinds = [point.kind for point in field.critical_points([*behind(field), *sampled_starts(field.step, 200, 0)])]

    assert "minimum" in kinds
    assert kinds.count("saddle") - kinds.count("minimum") == len(OBSTACLES)


@pytest.mark.parametrize("lambda_", [0.0, 1.0])
def test_the_gradient_of_every_shaping_vanishes_where_one_does_and_nowhere_else(lambda_):
    field = PlanarField.of(step(), kappa=6.0, lambda_=lambda_)
    found = field.critical_points([*behind(field), *sampled_starts(field.step, 60, 0)])
    elsewhere = np.stack(list(sampled_starts(field.step, 30, 1)))

    assert len(found) >= len(OBSTACLES)
    for shaping in SHAPINGS:
        at_critical = np.stack([field.gradient(point.x, shaping) for point in found])
        # The scale is the slope a metre away; zeros are those of log w, found to 1e-8.
        scale = np.stack([field.gradient(point.x + point.directions[:, -1] * 0.1, shaping) for point in found])
        assert (np.linalg.norm(at_critical, axis=1) < 1e-5 * np.linalg.norm(scale, axis=1)).all()
        ours, theirs = field.gradient(elsewhere, shaping), field.gradient(elsewhere)
        cosine = (ours * theirs).sum(axis=1) / np.linalg.norm(ours, axis=1) / np.linalg.norm(theirs, axis=1)
        np.testing.assert_allclose(cosine, 1.0, atol=1e-9)


@pytest.mark.parametrize("shaping", SHAPINGS[:2], ids=repr)
def test_the_goal_is_a_nondegenerate_minimum(shaping):
    field, side = PlanarField.of(step(), kappa=6.0), 1e-4
    steps = side * np.eye(2)
    hessian = (field.gradient(field.goal + steps, shaping) - field.gradient(field.goal - steps, shaping)) / (2 * side)

    # psi is w / (2 delta) there and w tends to gamma: the Hessian is 1 / delta times the identity.
    np.testing.assert_allclose(hessian, np.eye(2) / shaping.delta, rtol=1e-5, atol=1e-5)


@settings(deadline=None, max_examples=20)
@given(seed=st.integers(0, 1000), kappa=st.floats(3.0, 30.0), lambda_=st.sampled_from([0.0, 1.0]))
def test_critical_points_are_nondegenerate(seed, kappa, lambda_):
    """Obstacles anywhere: degenerate ones have measure zero."""
    rng = np.random.default_rng(seed)
    obstacles = [(*rng.uniform(-5.0, 3.0, 2), rng.uniform(0.5, 1.5)) for _ in range(3)]
    field = PlanarField.of(step(obstacles=obstacles), kappa=kappa, lambda_=lambda_)

    for point in field.critical_points(sampled_starts(field.step, 15, seed)):
        assert point.kind != "degenerate"
        assert np.linalg.norm(field.gradient(point.x)) < 1e-8


@settings(deadline=None, max_examples=50)
@given(seed=st.integers(0, 10_000), lambda_=st.sampled_from([0.0, 0.5]))
def test_the_planar_gradient_agrees_with_central_differences(seed, lambda_):
    two = step(goals=((8.0, 2.0), (-8.0, 2.0)), starts=((-8.0, 0.0), (8.0, 0.0)), obstacles=OBSTACLES[:2])
    field, side = PlanarField.of(two, kappa=5.0, lambda_=lambda_), 1e-6
    (x,) = sampled_starts(two, 1, seed)
    gaps = np.sqrt(two.relations.betas(field.points(x)).min())
    if gaps < 0.1 or field.gamma(x) < 0.1:
        return  # log w is too steep for these differences
    steps = side * np.eye(4)
    numeric = (field.value(x + steps) - field.value(x - steps)) / (2.0 * side)

    # rounding eps |log w| / side = 1e-9, truncation side^2 / gap^3.
    np.testing.assert_allclose(field.gradient(x), numeric, rtol=1e-6, atol=1e-7)


def test_saturated_betas_would_move_critical_points():
    """Why no beta is rescaled to beta / (beta + mu): on the axis through the goal and an obstacle, log w has its saddle
    where 2 / (x - goal) = slope of log G / kappa; saturation weakens the slope by 1 / (1 + beta / mu)."""
    field = PlanarField.of(step(goals=((8.0, 0.0),), obstacles=[(0.0, 0.0, 2.0)]), kappa=6.0)

    def slope(x, mu):
        beta, border = x**2 - 9.0, 121.0 - x**2  # of the workspace and of the region
        return 2.0 / (x - 8.0) - (2.0 * x / beta / (1.0 + beta / mu) - 4.0 * x / border) / 6.0

    plain, saturated = (brentq(slope, -10.9, -3.01, (mu,)) for mu in (np.inf, 4.0))
    point = field.critical_near(np.array([plain + 0.1, 0.1]))
    np.testing.assert_allclose(point.x, [plain, 0.0], atol=1e-6)
    assert abs(saturated - plain) > 0.1


def test_sampled_starts_are_free_inside_their_region_and_repeatable():
    two = step(goals=((8.0, 2.0), (-8.0, 2.0)), starts=((-8.0, 0.0), (8.0, 0.0)))
    field = PlanarField.of(two, kappa=5.0)

    first, again = (np.stack(list(sampled_starts(two, 40, 3))) for _ in range(2))

    assert first.shape == (40, 4)
    assert all(field.free(x) for x in first)
    np.testing.assert_array_equal(first, again)


def test_a_root_finder_that_starts_in_a_collision_finds_nothing():
    field = PlanarField.of(step(), kappa=6.0)

    assert field.critical_near(np.array(OBSTACLES[0][:2])) is None
