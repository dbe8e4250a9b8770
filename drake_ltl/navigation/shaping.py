"""Strictly increasing functions psi of the navigation function.

The paper's phi = gamma / (gamma^kappa + G)^(1/kappa) is itself a strictly increasing function of
w = gamma / G^(1/kappa), and so is every psi below. They share phi's critical points, level sets and the
direction of its gradient, and therefore its proof; they differ in the size of the gradient alone.

Each is given as a function of L = log w in [-inf, inf], and its slope with respect to w as a logarithm, so
that no intermediate number leaves the range of floating point numbers. Those below have a second form for one number,
`value_at` and `log_slope_at`: numpy takes ten times as long for it as Python. Anything with the three members of
`Shaping` will do; `check_shaping` says what is wrong with one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import exp, expm1, hypot, log, log1p
from typing import Protocol, runtime_checkable

import numpy as np

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.navigation.relations import Array

LARGEST_EXPONENT = 700.0
"""exp of more would overflow: far beyond any potential that means something, values saturate there."""
LARGEST_POWER = 0.8
"""Exponent of w at most: with it six movers gather as fast as one mover alone."""


@runtime_checkable
class Shaping(Protocol):
    """psi, with psi = 0 at w = 0."""

    supremum: float
    """Value where a relation is realised (w = inf)."""

    def value(self, L: Array) -> Array:
        """psi(w)."""
        ...

    def log_slope(self, L: Array) -> Array:
        """log(d psi / d w)."""
        ...


@dataclass(frozen=True)
class PseudoHuber:
    """psi = delta / (2 e) ((1 + w / delta^2)^e - 1), in m, with an exponent e of 1/2 or more.

    With e = 1/2 this is delta (sqrt(1 + w / delta^2) - 1): a cone far away, quadratic (w / 2 delta) at the goal. With
    s = sqrt(w), a length, the slope with respect to s tends to 1 far away: k psi has a force of about k. Where many
    gather, w grows much slower than squared distances do, and a larger e makes up for it (`gathering_exponent`).
    """

    delta: float = 0.5
    """Distance at which the cone turns into the bowl [m]; k / delta is the stiffness at the goal."""
    exponent: float = 0.5
    supremum = float("inf")

    def value(self, L: Array) -> Array:
        if self.exponent != 0.5:
            grown = np.expm1(np.minimum(self.exponent * np.logaddexp(0.0, L - 2.0 * log(self.delta)), LARGEST_EXPONENT))
            return 0.5 * self.delta / self.exponent * grown
        s = np.exp(np.minimum(0.5 * L, LARGEST_EXPONENT))
        return s * (s / (self.delta + np.hypot(self.delta, s)))  # no cancellation near 0, no square far away

    def log_slope(self, L: Array) -> Array:
        return -log(2.0 * self.delta) + (self.exponent - 1.0) * np.logaddexp(0.0, L - 2.0 * log(self.delta))

    def value_at(self, L: float) -> float:
        if self.exponent != 0.5:
            grown = expm1(min(self.exponent * _log_1_plus_exp(L - 2.0 * log(self.delta)), LARGEST_EXPONENT))
            return 0.5 * self.delta / self.exponent * grown
        s = exp(min(0.5 * L, LARGEST_EXPONENT))
        return s * (s / (self.delta + hypot(self.delta, s)))

    def log_slope_at(self, L: float) -> float:
        return -log(2.0 * self.delta) + (self.exponent - 1.0) * _log_1_plus_exp(L - 2.0 * log(self.delta))


@dataclass(frozen=True)
class Logarithmic:
    """psi = delta / 2 log(1 + w / delta^2), in m: the same bowl at the goal, ever weaker far away."""

    delta: float = 0.5
    """Distance at which the slope is largest [m]."""
    supremum = float("inf")

    def value(self, L: Array) -> Array:
        return 0.5 * self.delta * np.logaddexp(0.0, L - 2.0 * log(self.delta))

    def log_slope(self, L: Array) -> Array:
        return -log(2.0 * self.delta) - np.logaddexp(0.0, L - 2.0 * log(self.delta))

    def value_at(self, L: float) -> float:
        return 0.5 * self.delta * _log_1_plus_exp(L - 2.0 * log(self.delta))

    def log_slope_at(self, L: float) -> float:
        return -log(2.0 * self.delta) - _log_1_plus_exp(L - 2.0 * log(self.delta))


@dataclass(frozen=True)
class PaperPhi:
    """phi = (1 + w^-kappa)^(-1/kappa) in [0, 1]: the navigation function itself."""

    kappa: float
    supremum = 1.0

    def value(self, L: Array) -> Array:
        return np.exp(-np.logaddexp(0.0, -self.kappa * L) / self.kappa)

    def log_slope(self, L: Array) -> Array:
        log_sum = np.logaddexp(0.0, self.kappa * L)
        return -(log_sum + log_sum / self.kappa)

    def value_at(self, L: float) -> float:
        return exp(-_log_1_plus_exp(-self.kappa * L) / self.kappa)

    def log_slope_at(self, L: float) -> float:
        log_sum = _log_1_plus_exp(self.kappa * L)
        return -(log_sum + log_sum / self.kappa)


def _log_1_plus_exp(x: float) -> float:
    return x + log1p(exp(-x)) if x > 0.0 else log1p(exp(x))


NAMES = ("pseudo_huber", "logarithmic", "paper")
"""What a scenario may ask for."""


def gathering_exponent(n_movers: int, kappa: float) -> float:
    """e with which psi grows as distances do while so many movers come from far to places near each other.

    Their m = n (n - 1) / 2 betas and gamma all grow as the square of their distances, so that w = gamma / G^(1/kappa)
    grows as the power 2 - 2 m / kappa of these, and w^e as the first if e = 1 / (2 - 2 m / kappa).
    """
    share = 0.5 * n_movers * (n_movers - 1) / kappa
    return min(LARGEST_POWER, 0.5 / (1.0 - share)) if share < 1.0 else LARGEST_POWER


def shaping_from(choice: str | Shaping, *, delta: float, kappa: float, n_movers: int = 1) -> Shaping:
    """The shaping of that name, or the user's own if it is fit to be one.

    Raises:
        InvalidInputError: see `check_shaping`; or an unknown name.
    """
    if choice == "pseudo_huber":
        return PseudoHuber(delta, gathering_exponent(n_movers, kappa))
    if choice == "logarithmic":
        return Logarithmic(delta)
    if choice == "paper":
        return PaperPhi(kappa)
    if isinstance(choice, str):
        raise InvalidInputError([Mistake(_WHERE, f"{choice!r} is unknown", f"use one of {', '.join(NAMES)}")])
    check_shaping(choice)
    return choice


def check_shaping(shaping: object) -> None:
    """Looks at psi on a sample of w from 1e-8 to 1e6 m^2.

    Raises:
        InvalidInputError: it is no Shaping, is not 0 at w = 0, does not increase strictly, exceeds its own supremum,
            or its slope is not that of its value.
    """
    if not isinstance(shaping, Shaping):
        what = f"{shaping!r} has not all of supremum, value and log_slope"
        raise InvalidInputError([Mistake(_WHERE, what, "see drake_ltl.navigation.Shaping")])
    if mistakes := list(_mistakes(shaping)):
        raise InvalidInputError(mistakes)


def _mistakes(shaping: Shaping) -> Iterator[Mistake]:
    with np.errstate(all="ignore"):
        value, log_slope = np.asarray(shaping.value(_SAMPLE)), np.asarray(shaping.log_slope(_SAMPLE))
        ahead, behind = (np.asarray(shaping.value(_SAMPLE + side)) for side in (_SIDE, -_SIDE))
        at_goal = float(shaping.value(np.array(-np.inf)))
    if value.shape != _SAMPLE.shape or log_slope.shape != _SAMPLE.shape:
        yield Mistake(_WHERE, "does not keep the shape of its argument", "write it for arrays")
        return
    if at_goal != 0.0:
        yield Mistake(_WHERE, f"is {at_goal!r} at w = 0", "must be 0 there (L = -inf)")
    if not value.max() <= shaping.supremum:
        yield Mistake(f"{_WHERE}.supremum", f"{shaping.supremum!r} is exceeded", "give the least upper bound")
    by_L = np.exp(log_slope + _SAMPLE)
    rise = (ahead - behind) / (2.0 * _SIDE)
    visible = np.maximum(np.abs(rise), by_L) > 1e-4 * np.abs(value)  # the rest is rounding, as near a supremum
    faults = {
        "is not finite": ~(np.isfinite(value) & np.isfinite(log_slope)),
        "does not increase": ~((ahead >= value) & (value >= behind)) | (visible & (rise <= 0.0)),
        "has another slope than log_slope says": visible & ~(np.abs(rise - by_L) <= 1e-3 * np.abs(rise)),
    }
    for what, where in faults.items():
        if where.any():
            w = float(np.exp(_SAMPLE[where][0]))
            yield Mistake(_WHERE, f"{what} at w = {w:.3g} m^2", "must increase strictly, with log_slope = log(dpsi/dw)")
            return


_WHERE = "controller.shaping"
_SAMPLE = np.linspace(log(1e-8), log(1e6), 2001)
_SIDE = 1e-4
"""Of central differences in L: their error is of the order 1e-8 of the slope, their rounding 1e-12 of the value."""
