"""Strictly increasing functions psi of the navigation function.

The paper's phi = gamma / (gamma^kappa + G)^(1/kappa) is itself a strictly increasing function of
w = gamma / G^(1/kappa), and so is every psi below. They share phi's critical points, level sets and the
direction of its gradient, and therefore its proof; they differ in the size of the gradient alone.

Each is given as a function of L = log w in [-inf, inf], and its slope with respect to w as a logarithm, so
that no intermediate number leaves the range of floating point numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log
from typing import Protocol

import numpy as np

from drake_ltl.navigation.relations import Array

LARGEST_EXPONENT = 700.0
"""exp of more would overflow: far beyond any potential that means something, values saturate there."""


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
    """psi = delta (sqrt(1 + w / delta^2) - 1), in m: a cone far away, quadratic (w / 2 delta) at the goal.

    With s = sqrt(w), a length, the slope with respect to s tends to 1 far away: k psi has a force of about k.
    """

    delta: float = 0.5
    """Distance at which the cone turns into the bowl [m]; k / delta is the stiffness at the goal."""
    supremum = float("inf")

    def value(self, L: Array) -> Array:
        x = np.exp(np.minimum(0.5 * L - log(self.delta), LARGEST_EXPONENT))
        return self.delta * x * (x / (1.0 + np.hypot(1.0, x)))  # no cancellation near 0, no square far away

    def log_slope(self, L: Array) -> Array:
        return -log(2.0 * self.delta) - 0.5 * np.logaddexp(0.0, L - 2.0 * log(self.delta))


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


@dataclass(frozen=True)
class PaperPhi:
    """phi = (1 + w^-kappa)^(-1/kappa) in [0, 1]: the navigation function itself."""

    kappa: float
    supremum = 1.0

    def value(self, L: Array) -> Array:
        return np.exp(-np.logaddexp(0.0, -self.kappa * L) / self.kappa)

    def log_slope(self, L: Array) -> Array:
        return -(1.0 + 1.0 / self.kappa) * np.logaddexp(0.0, self.kappa * L)
