"""Shapings: the named ones are fit, and what is unfit in one of the user's own is said."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from drake_ltl.errors import InvalidInputError
from drake_ltl.navigation import (
    Apart,
    Logarithmic,
    NavigationFunction,
    PaperPhi,
    PseudoHuber,
    Relations,
    check_shaping,
    shaping_from,
)
from drake_ltl.navigation.shaping import LARGEST_POWER, gathering_exponent


class Power:
    """psi = w^power, strictly increasing."""

    supremum = float("inf")

    def __init__(self, power=0.5):
        self.power = power

    def value(self, L):
        return np.exp(np.minimum(self.power * L, 700.0))

    def log_slope(self, L):
        return np.log(self.power) + (self.power - 1.0) * L


class Falling(Power):
    """Up to w = 1, then down."""

    def value(self, L):
        return np.where(L < 0.0, np.exp(L), np.exp(-L))


class Flat(Power):
    def value(self, L):
        return np.minimum(np.exp(L), 3.0)

    def log_slope(self, L):
        return np.zeros_like(L)


class WrongSlope(Power):
    def log_slope(self, L):
        return 2.0 + super().log_slope(L)


class Shifted(Power):
    def value(self, L):
        return 1.0 + super().value(L)


class Bounded(Power):
    supremum = 10.0


class Plunging(Power):
    def value(self, L):
        return np.where(L > 5.0, np.nan, super().value(L))


class ForOneNumberAlone(Power):
    def value(self, L):
        return float(np.max(np.exp(L)))


@pytest.mark.parametrize(
    "shaping",
    [
        PseudoHuber(0.5),
        PseudoHuber(1e-3),
        Logarithmic(2.0),
        PaperPhi(0.5),
        PaperPhi(30.0),
        PaperPhi(200.0),
        Power(),
        Power(2.0),
    ],
    ids=lambda shaping: f"{type(shaping).__name__}",
)
def test_strictly_increasing_ones_are_fit(shaping):
    check_shaping(shaping)


@pytest.mark.parametrize(
    ("shaping", "message"),
    [
        (Falling(), r"controller\.shaping: does not increase at w = "),
        (Flat(), r"does not increase at w = 3.*strictly"),
        (WrongSlope(), r"another slope than log_slope says at w = 1e-08"),
        (Shifted(), r"is 1\.0 at w = 0"),
        (Bounded(), r"supremum: 10\.0 is exceeded"),
        (Plunging(), r"is not finite at w = 1"),
        (ForOneNumberAlone(), r"shape"),
        (object(), r"has not all of supremum, value and log_slope"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_what_is_unfit_is_said(shaping, message):
    with pytest.raises(InvalidInputError, match=message):
        check_shaping(shaping)


def test_scenarios_name_them():
    assert shaping_from("pseudo_huber", delta=2.0, kappa=5.0) == PseudoHuber(2.0)
    assert shaping_from("pseudo_huber", delta=2.0, kappa=20.0, n_movers=3) == PseudoHuber(2.0, 1.0 / 1.7)
    assert shaping_from("logarithmic", delta=2.0, kappa=5.0) == Logarithmic(2.0)
    assert shaping_from("paper", delta=2.0, kappa=5.0) == PaperPhi(5.0)
    mine = Power()
    assert shaping_from(mine, delta=2.0, kappa=5.0) is mine
    with pytest.raises(InvalidInputError, match="'huber' is unknown; use one of pseudo_huber, logarithmic, paper"):
        shaping_from("huber", delta=2.0, kappa=5.0)
    with pytest.raises(InvalidInputError, match="does not increase"):
        shaping_from(Falling(), delta=2.0, kappa=5.0)


@pytest.mark.parametrize("exponent", [0.5, 0.58, 0.8])
@pytest.mark.parametrize("delta", [0.1, 0.5, 3.0])
def test_whatever_its_exponent_the_bowl_at_the_goal_is_the_same(delta, exponent):
    shaping = PseudoHuber(delta, exponent)
    check_shaping(shaping)
    w = 1e-6 * delta**2
    assert shaping.value(np.log(w)) == pytest.approx(
        w / (2.0 * delta), rel=1e-6
    )  # the next term is 1e-6 of it, or less


@given(n=st.integers(2, 6), kappa=st.floats(12.0, 200.0))
def test_psi_grows_as_distances_do_while_movers_gather_from_far(n, kappa):
    """Of movers at the corners of an ever larger polygon, whose places are near each other."""
    exponent = gathering_exponent(n, kappa)
    assume(exponent < LARGEST_POWER)
    angles = 2.0 * np.pi * np.arange(n) / n
    corners = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(n)])
    relations = Relations(n, tuple(Apart(a, b, 1.0) for a, b in combinations(range(n), 2)))
    function = NavigationFunction.for_goal(relations, 3.0 * corners, kappa=kappa, shaping=PseudoHuber(0.5, exponent))
    near, far = (float(function.value(scale**2 * n, scale * corners)) for scale in (1e8, 2e8))
    assert far / near == pytest.approx(2.0, rel=1e-3)  # (delta^2 / w)^e of it is not in proportion


def test_one_mover_needs_no_larger_exponent_and_no_number_of_movers_more_than_the_largest():
    assert gathering_exponent(1, 12.0) == 0.5
    assert gathering_exponent(3, 20.0) == pytest.approx(1.0 / 1.7)
    assert gathering_exponent(6, 26.25) == LARGEST_POWER
    assert gathering_exponent(40, 12.0) == LARGEST_POWER  # w itself falls with the distance


@pytest.mark.parametrize(
    "shaping", [PseudoHuber(0.5), PseudoHuber(0.5, 0.7), Logarithmic(2.0), PaperPhi(0.5), PaperPhi(30.0)]
)
def test_forms_for_one_number_agree_with_those_for_arrays(shaping):
    L = np.array([-np.inf, *np.linspace(-1e3, 1e3, 401), np.inf])
    with np.errstate(all="ignore"):
        value, log_slope = shaping.value(L), shaping.log_slope(L)
    np.testing.assert_allclose([shaping.value_at(float(x)) for x in L], value, rtol=1e-12)
    np.testing.assert_allclose([shaping.log_slope_at(float(x)) for x in L], log_slope, rtol=1e-12)
