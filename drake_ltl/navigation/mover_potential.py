"""The navigation function of one plan step as a controller asks for it: one configuration of the movers at a time.

What never moves is folded into constants, and scalars are floats: half the work of `NavigationFunction`, which is
written for arrays of configurations and for every finite argument, and to which this one turns where it must.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import exp, inf, log

import numpy as np

from drake_ltl.navigation.potential import NavigationFunction
from drake_ltl.navigation.relations import Array, MoverRelations
from drake_ltl.navigation.shaping import LARGEST_EXPONENT, Logarithmic, PaperPhi, PseudoHuber
from drake_ltl.navigation.step import StepRelations

LARGE = 1e140
"""Numbers below do not overflow with the lengths (below 1e154, for their squares are numbers) that they meet here."""


@dataclass(frozen=True)
class MoverPotential:
    """Phi(gamma, p) of the points p (m, 3) [m] of a step's movers, m >= 1."""

    step: StepRelations
    function: NavigationFunction
    """Of these relations."""

    def value_and_gradient(self, gamma: float, p: Array) -> tuple[float, float, Array]:
        """Phi, d Phi / d gamma and d Phi / dp (m, 3), as `NavigationFunction.value_and_gradient` has them.

        Where a relation is violated the derivatives are nan.
        """
        found = self._of_product(gamma, p) if self._is_plain else None
        if found is not None:
            return found
        value, by_gamma, by_p = self.function.value_and_gradient(gamma, self.step.at(p))
        return float(value), float(by_gamma), by_p[: self.step.n_movers]

    def _of_product(self, gamma: float, p: Array) -> tuple[float, float, Array] | None:
        """For G the product of the betas; None where something touches or numbers are extreme."""
        movers, function = self._movers, self.function
        d = movers.incidence @ p
        d -= movers.fixed
        betas = np.einsum("nk,nk->n", d, d)  # warns of nothing
        betas -= movers.squared_radii
        betas *= movers.signs
        least = min(numbers := betas.tolist())
        if not least > 0.0 or not max(numbers) < inf:
            return None
        log_scale = (function.log_G_goal - float(np.add.reduce(np.log(betas)))) / function.kappa
        L = (log(gamma) if gamma > 0.0 else -inf) + log_scale
        value = function.shaping.value_at(L)
        by_gamma = exp(min(function.shaping.log_slope_at(L) + log_scale, LARGEST_EXPONENT))
        by_log_G = by_gamma * gamma / -function.kappa
        if not (value < LARGE and by_gamma < LARGE and by_log_G / least > -LARGE):
            return None
        d *= (by_log_G / betas)[:, None]
        return value, by_gamma, movers.transposed @ d

    @cached_property
    def _is_plain(self) -> bool:
        return self.function.lambda_ == 0.0 and type(self.function.shaping) in (PseudoHuber, Logarithmic, PaperPhi)

    @cached_property
    def _movers(self) -> MoverRelations:
        return self.step.relations.of_movers(self.step.start, self.step.n_movers)
