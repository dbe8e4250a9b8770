"""Shapings: the named ones are fit, and what is unfit in one of the user's own is said."""

import numpy as np
import pytest

from drake_ltl.errors import InvalidInputError
from drake_ltl.navigation import Logarithmic, PaperPhi, PseudoHuber, check_shaping, shaping_from


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
    assert shaping_from("logarithmic", delta=2.0, kappa=5.0) == Logarithmic(2.0)
    assert shaping_from("paper", delta=2.0, kappa=5.0) == PaperPhi(5.0)
    mine = Power()
    assert shaping_from(mine, delta=2.0, kappa=5.0) is mine
    with pytest.raises(InvalidInputError, match="'huber' is unknown; use one of pseudo_huber, logarithmic, paper"):
        shaping_from("huber", delta=2.0, kappa=5.0)
    with pytest.raises(InvalidInputError, match="does not increase"):
        shaping_from(Falling(), delta=2.0, kappa=5.0)


@pytest.mark.parametrize("shaping", [PseudoHuber(0.5), Logarithmic(2.0), PaperPhi(0.5), PaperPhi(30.0)])
def test_forms_for_one_number_agree_with_those_for_arrays(shaping):
    L = np.array([-np.inf, *np.linspace(-1e3, 1e3, 401), np.inf])
    with np.errstate(all="ignore"):
        value, log_slope = shaping.value(L), shaping.log_slope(L)
    np.testing.assert_allclose([shaping.value_at(float(x)) for x in L], value, rtol=1e-12)
    np.testing.assert_allclose([shaping.log_slope_at(float(x)) for x in L], log_slope, rtol=1e-12)
