"""The navigation function of one plan step as a controller asks for it: one configuration of the movers at a time.

Few relations are a matter of a few numbers, for which Python alone is quicker than numpy: between two steps of a plant
each call of numpy finds the processor's caches full of other code. What is too much or too extreme for that is left to
`NavigationFunction`, which is written for arrays of configurations and for every finite argument.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import exp, inf, isfinite, log

import numpy as np

from drake_ltl.navigation.potential import NavigationFunction
from drake_ltl.navigation.shaping import LARGEST_EXPONENT, Logarithmic, PaperPhi, PseudoHuber
from drake_ltl.navigation.step import StepRelations

FEW = 40
"""Relations up to which numbers are quicker than arrays."""
LARGE = 1e140
"""Numbers below do not overflow with the lengths (below 1e154, for their squares are numbers) that they meet here."""

Rows = list[list[float]]
"""(m, 3)"""
Fixed = tuple[float, float, float, float, float]
"""A point (x, y, z) [m] that never moves, the squared radius [m^2], and 1 to keep away from it or -1 to stay within."""


@dataclass(frozen=True)
class MoverPotential:
    """Phi(gamma, p) of the points p (m, 3) [m] of a step's movers, m >= 1."""

    step: StepRelations
    function: NavigationFunction
    """Of these relations."""

    def value_and_gradient(self, gamma: float, p: Rows) -> tuple[float, float, Rows]:
        """Phi, d Phi / d gamma and d Phi / dp (m, 3), as `NavigationFunction.value_and_gradient` has them.

        Where a relation is violated the derivatives are nan.
        """
        found = self._of_product(gamma, p) if self._is_plain else None
        if found is not None:
            return found
        value, by_gamma, by_p = self.function.value_and_gradient(gamma, self.step.at(np.array(p)))
        return float(value), float(by_gamma), by_p[: self.step.n_movers].tolist()

    def _of_product(self, gamma: float, p: Rows) -> tuple[float, float, Rows] | None:
        """For G the product of the betas; None where something touches or numbers are extreme."""
        function = self.function
        G, half_slopes = self._product(p)
        if not 0.0 < G < inf:
            return None
        log_scale = (function.log_G_goal - log(G)) / function.kappa
        L = (log(gamma) if gamma > 0.0 else -inf) + log_scale
        value = function.shaping.value_at(L)
        by_gamma = exp(min(function.shaping.log_slope_at(L) + log_scale, LARGEST_EXPONENT))
        twice = 2.0 * by_gamma * gamma / -function.kappa
        by_p = [[twice * x, twice * y, twice * z] for x, y, z in half_slopes]
        if not (value < LARGE and by_gamma < LARGE and isfinite(sum(map(sum, by_p)))):
            return None
        return value, by_gamma, by_p

    def _product(self, p: Rows) -> tuple[float, Rows]:
        """G and half the slopes of log G with respect to each coordinate; G = 0 where something touches."""
        G, slopes = 1.0, []
        for (x, y, z), around in zip(p, self._around, strict=True):
            by_x = by_y = by_z = 0.0
            for there_x, there_y, there_z, squared_radius, sign in around:
                dx, dy, dz = x - there_x, y - there_y, z - there_z
                beta = sign * (dx * dx + dy * dy + dz * dz - squared_radius)
                if not beta > 0.0:
                    return 0.0, []
                G *= beta
                weight = sign / beta
                by_x += weight * dx
                by_y += weight * dy
                by_z += weight * dz
            slopes.append([by_x, by_y, by_z])
        for a, b, squared_radius in self._pairs:
            (x, y, z), (there_x, there_y, there_z) = p[a], p[b]
            dx, dy, dz = x - there_x, y - there_y, z - there_z
            beta = dx * dx + dy * dy + dz * dz - squared_radius
            if not beta > 0.0:
                return 0.0, []
            G *= beta
            for slope, sign in ((slopes[a], 1.0), (slopes[b], -1.0)):
                weight = sign / beta
                slope[0] += weight * dx
                slope[1] += weight * dy
                slope[2] += weight * dz
        return G, slopes

    @cached_property
    def _is_plain(self) -> bool:
        known = type(self.function.shaping) in (PseudoHuber, Logarithmic, PaperPhi)
        return known and self.function.lambda_ == 0.0 and len(self.step.relations) <= FEW

    @cached_property
    def _around(self) -> list[list[Fixed]]:
        """For each mover, all that never moves."""
        relations, around = self.step.relations, [[] for _ in range(self.step.n_movers)]
        for apart in relations.apart:
            if apart.b >= self.step.n_movers:
                around[apart.a].append((*self.step.start[apart.b].tolist(), apart.radius * apart.radius, 1.0))
        for inside in relations.inside:
            around[inside.a].append((*map(float, inside.centre), inside.radius * inside.radius, -1.0))
        return around

    @cached_property
    def _pairs(self) -> list[tuple[int, int, float]]:
        """Movers that keep apart, and the squared sums of their radii [m^2]."""
        apart = self.step.relations.apart
        return [(pair.a, pair.b, pair.radius * pair.radius) for pair in apart if pair.b < self.step.n_movers]
