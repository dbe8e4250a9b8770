"""Sets of relations that are left out are never realised: against random contacts, packings and hand-made cases."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares

from drake_ltl.errors import InvalidInputError
from drake_ltl.navigation import (
    Apart,
    Inside,
    NavigationFunction,
    RegionBall,
    Relations,
    StaticBody,
    Traveller,
    step_relations,
)
from drake_ltl.navigation.realisable import (
    MAX_RELATIONS,
    all_sets,
    fit_around,
    fixed_points,
    realisable_sets,
    spheres_meet,
)


def row(n_movers, fixed, workspace=50.0, radius=1.0):
    """Relations of movers of one radius among fixed bodies [(position, radius)]; fixed points follow the movers."""
    n = n_movers + len(fixed)
    apart = [Apart(a, b, 2.0 * radius) for a, b in combinations(range(n_movers), 2)]
    apart += [Apart(a, n_movers + k, radius + r) for a in range(n_movers) for k, (_, r) in enumerate(fixed)]
    inside = [Inside(a, (0.0, 0.0, 0.0), workspace - radius) for a in range(n_movers)]
    points = tuple((n_movers + k, tuple(map(float, p))) for k, (p, _) in enumerate(fixed))
    return Relations(n, tuple(apart), tuple(inside)), points


def test_one_mover_touches_neighbours_but_not_two_that_are_far_apart():
    relations, fixed = row(1, [((0, 0, 0), 1.0), ((3, 0, 0), 1.0), ((20, 0, 0), 1.0)])

    assert realisable_sets(relations, fixed).sets == ((0,), (1,), (2,), (0, 1))


def test_two_movers_bridge_a_gap_that_one_does_not():
    relations, fixed = row(2, [((0, 0, 0), 1.0), ((5.5, 0, 0), 1.0)])
    # 0: the movers; 1, 2: the first and the fixed points; 3, 4: the second.
    sets = realisable_sets(relations, fixed).sets

    assert (0, 1, 4) in sets
    assert (0, 2, 3) in sets
    assert (1, 4) in sets
    assert (1, 2) not in sets
    assert (0, 1, 2) not in sets

    wider, fixed = row(2, [((0, 0, 0), 1.0), ((6.5, 0, 0), 1.0)])

    assert (0, 1, 4) not in realisable_sets(wider, fixed).sets
    assert (1, 4) in realisable_sets(wider, fixed).sets


def test_what_cannot_be_reached_inside_the_workspace_is_left_out():
    relations, fixed = row(2, [((12.5, 0, 0), 1.0)], workspace=10.0)

    assert realisable_sets(relations, fixed).sets == ((0,),)


def test_a_mover_touches_four_bodies_only_if_their_spheres_meet_in_a_point():
    on_a_sphere = 2.0 * np.array([[1, 0, 0], [-0.5, 0.9, 0], [-0.5, -0.9, 0], [0, 0.2, 1.0]])
    on_a_sphere *= 2.0 / np.linalg.norm(on_a_sphere, axis=1, keepdims=True)

    def largest(bodies):
        return realisable_sets(*row(1, [(p, 1.0) for p in bodies])).levels

    assert largest(on_a_sphere) == 4
    assert largest(on_a_sphere * [[1.0], [1.0], [1.0], [0.9]]) == 3


@pytest.mark.parametrize(("count", "possible"), [(3, True), (4, False)])
def test_large_bodies_around_a_small_one_are_few(count, possible):
    """A small mover between large ones: three 119 degrees apart fit, four need 110 degrees at most."""
    radii = np.full(count, 10.0)
    lower = np.full((count, count), 2.0 * 10.0 * np.sin(np.radians(119.0) / 2.0))

    assert fit_around(radii, lower) is possible


def test_a_ball_has_room_for_twelve_equal_ones_around_it_but_not_for_fifteen():
    assert fit_around(np.full(12, 2.0), np.full((12, 12), 2.0))
    assert not fit_around(np.full(15, 2.0), np.full((15, 15), 2.0))


@given(seed=st.integers(0, 100_000))
def test_points_that_are_around_something_are_never_said_not_to_fit(seed):
    rng = np.random.default_rng(seed)
    radii = rng.uniform(0.5, 3.0, size=rng.integers(3, 12))
    directions = rng.normal(size=(len(radii), 3))
    points = radii[:, None] * directions / np.linalg.norm(directions, axis=1, keepdims=True)

    assert fit_around(radii, np.linalg.norm(points[:, None] - points, axis=-1))


@given(seed=st.integers(0, 100_000), n=st.integers(2, 6), dimensions=st.integers(1, 3))
def test_spheres_through_one_point_always_meet(seed, n, dimensions):
    rng = np.random.default_rng(seed)
    centres = np.zeros((n, 3))
    centres[:, :dimensions] = rng.uniform(-5.0, 5.0, size=(n, dimensions))  # on a line, in a plane, or anywhere
    x = rng.uniform(-5.0, 5.0, size=3)

    assert spheres_meet(centres, np.linalg.norm(centres - x, axis=1), 1e-6)


@given(seed=st.integers(0, 100_000))
def test_whatever_is_realised_somewhere_is_never_left_out(seed):
    """Movers are pushed into random contacts; wherever that succeeds, the set of all contacts has to be there."""
    rng = np.random.default_rng(seed)
    n_movers = int(rng.integers(1, 4))
    bodies = [((*rng.uniform(-3.0, 3.0, 2), 0.0), float(rng.uniform(0.5, 1.5))) for _ in range(2)]
    relations, fixed = row(n_movers, bodies, workspace=6.0, radius=float(rng.uniform(0.3, 1.0)))
    anywhere = np.array([p for p, _ in bodies])
    n = len(relations.apart)
    wanted = rng.choice(n, size=rng.integers(1, n + 1), replace=False)

    def points(x):
        return np.vstack([x.reshape(-1, 3), anywhere])

    def gaps(x):
        betas = relations.betas(points(x))
        return np.concatenate([betas[wanted], np.minimum(betas, 0.0)])

    found = least_squares(gaps, rng.uniform(-3.0, 3.0, 3 * n_movers), xtol=1e-15, ftol=1e-15, gtol=1e-15)
    realised = np.abs(gaps(found.x)).max() < 1e-9
    sets = realisable_sets(relations, fixed).sets

    if realised:
        assert tuple(sorted(wanted.tolist())) in sets
    assert all(part in sets for chosen in sets for part in combinations(chosen, len(chosen) - 1) if part)


def test_more_movers_than_all_sets_allow_work_when_most_sets_are_impossible():
    """Three travellers, 18 binary relations: 262143 sets, of which some hundred can be realised."""
    regions = [RegionBall(f"r{k}", (20.0 * np.cos(k), 20.0 * np.sin(k), 0.0), 3.0) for k in range(6)]
    start = [(0.0, 4.0 * k, 0.0) for k in range(3)]
    travellers = [Traveller(f"a{k}", 1.25, "r0", "r1", start[k], (5.0, 4.0 * k, 0.0)) for k in range(3)]
    static = [StaticBody("o", 0.5, (-5.0, 0.0, 0.0))]
    step = step_relations(travellers=travellers, regions=regions, static_objects=static, workspace_radius=30.0)

    assert len(step.relations.apart) == 18
    sets = realisable_sets(step.relations, fixed_points(step.start, step.n_movers))
    assert len(sets.sets) < 1500

    nf = NavigationFunction.for_goal(step.relations, step.goal, kappa=20.0, lambda_=1.0, n_movers=step.n_movers)
    p = step.start.copy()
    p[0] = p[1] + [0.0, 0.0, 2.5 + 1e-12]
    assert nf.log_G(p) < nf.log_G(step.start) - 20.0


def test_too_many_are_refused_with_their_number_and_the_remedy():
    relations, fixed = row(6, [])

    with pytest.raises(InvalidInputError, match=rf"15 binary relations: more than {MAX_RELATIONS}.*lambda: 0"):
        realisable_sets(relations, fixed)


def test_all_sets_are_counted_by_level():
    sets = all_sets(4)

    assert [len(sets.of_level(k)) for k in range(1, 5)] == [4, 6, 4, 1]
    assert sets.levels == 4
