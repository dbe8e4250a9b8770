"""G by relation verification functions of all levels, against the written definition; what is refused."""

from itertools import combinations
from math import prod

import numpy as np
import pytest

from drake_ltl.errors import InvalidInputError
from drake_ltl.navigation.obstacle import log_product
from drake_ltl.navigation.obstacle import log_verified as log_verified_of_logs
from drake_ltl.navigation.realisable import MAX_RELATIONS, RelationSets, all_sets


def log_verified(n_apart, lambda_, h, levels=None, sets=None):
    """log G and its slopes as a function of the betas, all sets of relations being realisable."""
    log_G = log_verified_of_logs(sets or all_sets(n_apart), lambda_, h, levels)

    def of_betas(betas):
        value, slopes = log_G(np.log(betas))
        return value, slopes / betas

    return of_betas


def written_out(betas, n_apart, lambda_, h, levels=None, sets=None):
    """G of the definition, with sums, products and loops alone."""
    G = prod(betas[n_apart:])
    for k in range(1, (levels or n_apart) + 1):
        level = combinations(range(n_apart), k) if sets is None else sets.of_level(k)
        sums = [sum(betas[i] for i in chosen) for chosen in level]
        for j, b in enumerate(sums):
            B = prod(sums[:j] + sums[j + 1 :])
            G *= b + lambda_ * b / (b + B ** (1.0 / h))
    return G


@pytest.mark.parametrize("lambda_", [1e-6, 0.7, 50.0])
@pytest.mark.parametrize("h", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("n_apart", [0, 1, 2, 4])
def test_log_G_is_the_definition(n_apart, lambda_, h):
    betas = np.random.default_rng(n_apart).uniform(0.05, 3.0, size=(6, n_apart + 2))

    log_G, slopes = log_verified(n_apart, lambda_, h)(betas)

    expected = [np.log(written_out(list(row), n_apart, lambda_, h)) for row in betas]
    np.testing.assert_allclose(log_G, expected, rtol=1e-12, atol=1e-12)
    assert slopes.shape == betas.shape


@pytest.mark.parametrize("n_apart", [1, 2, 5])
def test_slopes_agree_with_central_differences(n_apart):
    log_G = log_verified(n_apart, lambda_=0.8, h=2.0)
    betas = np.random.default_rng(1).uniform(0.2, 3.0, size=n_apart + 1)
    step = 1e-6
    numeric = [(log_G(betas + e)[0] - log_G(betas - e)[0]) / (2 * step) for e in step * np.eye(n_apart + 1)]

    # eps / step = 2e-10, times log G of about 30.
    np.testing.assert_allclose(log_G(betas)[1], numeric, rtol=1e-7, atol=1e-8)


def test_a_small_lambda_tends_to_the_product_of_the_sums():
    betas = np.array([0.3, 2.0, 5.0])

    with_lambda = log_verified(3, 1e-14, 1.0)(betas)[0]
    sums = [0.3, 2.0, 5.0, 2.3, 5.3, 7.0, 7.3]

    assert with_lambda == pytest.approx(np.log(sums).sum(), rel=1e-12)
    assert log_product(np.log(betas))[0] == pytest.approx(np.log(3.0), rel=1e-12)


def test_collisions_of_one_and_of_two_relations_at_once_have_vanishing_G():
    log_G = log_verified(3, lambda_=1.0, h=1.0)
    clear = log_G(np.array([2.0, 3.0, 4.0]))[0]

    for touching in ([0], [0, 1], [0, 2], [0, 1, 2]):
        betas = np.array([2.0, 3.0, 4.0])
        betas[touching] = 1e-12
        assert log_G(betas)[0] < clear - 20.0


def test_why_fewer_levels_are_refused_two_collisions_at_once_would_keep_G_away_from_zero():
    def level_one(*betas):
        return written_out([*betas, 4.0], 3, lambda_=1.0, h=1.0, levels=1)

    assert level_one(1e-12, 3.0) < 1e-10
    assert level_one(1e-12, 1e-12) > 0.1  # both at once: b / (b + B) tends to 1 / (1 + 4), not to zero


def test_fewer_levels_are_refused_with_the_remedy():
    with pytest.raises(InvalidInputError, match=r"2 of 4 levels leave collisions.*lambda: 0"):
        log_verified(4, 1.0, 1.0, levels=2)


def test_too_many_relations_are_refused_with_their_number():
    assert len(all_sets(12).sets) == MAX_RELATIONS
    with pytest.raises(InvalidInputError, match=r"15 binary relations have 32767 relations"):
        all_sets(15)


@pytest.mark.parametrize(("lambda_", "h"), [(0.0, 1.0), (-1.0, 1.0), (float("nan"), 1.0), (1.0, 0.0)])
def test_parameters_out_of_range_are_refused(lambda_, h):
    with pytest.raises(InvalidInputError, match="must be positive"):
        log_verified(2, lambda_, h)


PRUNED = RelationSets(4, ((0,), (1,), (2,), (3,), (0, 1), (1, 2), (1, 3), (0, 1, 3)))


@pytest.mark.parametrize("h", [0.5, 1.0, 3.0])
def test_log_G_of_some_sets_is_the_definition_with_these_sets_alone(h):
    betas = np.random.default_rng(4).uniform(0.05, 3.0, size=(6, 6))

    log_G, slopes = log_verified(4, 0.7, h, sets=PRUNED)(betas)

    expected = [np.log(written_out(list(row), 4, 0.7, h, sets=PRUNED)) for row in betas]
    np.testing.assert_allclose(log_G, expected, rtol=1e-12, atol=1e-12)
    step = 1e-6
    for i, e in enumerate(step * np.eye(6)):
        log_G_of = log_verified(4, 0.7, h, sets=PRUNED)
        numeric = (log_G_of(betas + e)[0] - log_G_of(betas - e)[0]) / (2 * step)
        np.testing.assert_allclose(slopes[:, i], numeric, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("realised", PRUNED.sets)
def test_G_vanishes_wherever_one_of_the_sets_is_realised(realised):
    log_G = log_verified(4, 1.0, 1.0, sets=PRUNED)
    betas = np.array([2.0, 3.0, 4.0, 5.0, 1.0])
    clear = log_G(betas)[0]
    betas[list(realised)] = 1e-100

    assert log_G(betas)[0] < clear - 200.0


def test_a_set_that_is_left_out_although_it_is_realised_would_be_a_hole():
    betas = np.array([2.0, 3.0, 1e-100, 1e-100, 1.0])  # (2, 3) is not among the sets

    assert log_verified(4, 1.0, 1.0, sets=PRUNED)(betas)[0] > -20.0


@pytest.mark.parametrize("h", [1e-12, 1.0, 1e12])
@pytest.mark.parametrize("lambda_", [1e-300, 1.0, 1e300])
def test_logarithms_of_any_size_give_numbers(lambda_, h):
    log_G = log_verified_of_logs(all_sets(4), lambda_, h)

    for log_betas in ([-1e300, 700.0, 0.0, 1e300], [-1e300] * 4, [1e300] * 4):
        value, slopes = log_G(np.array([*log_betas, 0.0]))
        assert not np.isnan(value)
        assert np.isfinite(slopes).all()
