"""The multirobot navigation function of one plan step, with its gradient, in the log domain."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.navigation.obstacle import LogObstacle, log_product, log_verified
from drake_ltl.navigation.relations import Array, Label, Relations
from drake_ltl.navigation.shaping import LARGEST_EXPONENT, PaperPhi, PseudoHuber, Shaping

DEFAULT_SHAPING = PseudoHuber()


@dataclass(frozen=True)
class NavigationFunction:
    """Phi = psi(w), w = gamma / (G / G_goal)^(1/kappa), for the relations of one plan step.

    gamma [m^2] is the sum of squared errors of all movers, formed by the caller; G the obstacle function of
    the points p (..., P, 3) [m]. Dividing by G at the goal makes the base of the power free of units; it
    scales w by a constant and so is one more monotone change of phi. All methods broadcast over leading axes.

    Raises InvalidInputError for a kappa, h or lambda out of range (see `log_verified` for lambda > 0).
    """

    relations: Relations
    kappa: float
    lambda_: float = 0.0
    """Weight of the relation verification functions; 0 makes G the product of the betas."""
    h: float = 1.0
    log_G_goal: float = 0.0
    shaping: Shaping = DEFAULT_SHAPING
    levels: int | None = None
    """Levels of relations for lambda > 0; None means all, and fewer are refused."""

    def __post_init__(self) -> None:
        mistakes = []
        if not 0.0 < self.kappa < np.inf:
            mistakes.append(Mistake("controller.kappa", f"is {self.kappa!r}", "must be positive and finite"))
        if not 0.0 <= self.lambda_ < np.inf:
            mistakes.append(Mistake("controller.lambda", f"is {self.lambda_!r}", "must be 0 or more"))
        if not np.isfinite(self.log_G_goal):
            mistakes.append(Mistake("goal", "touches or overlaps something", "place the bodies apart"))
        if mistakes:
            raise InvalidInputError(mistakes)
        _ = self._log_obstacle  # refuses what it cannot do now, not at the first evaluation

    @classmethod
    def for_goal(
        cls,
        relations: Relations,
        goal: Array,
        *,
        kappa: float,
        lambda_: float = 0.0,
        h: float = 1.0,
        shaping: Shaping = DEFAULT_SHAPING,
    ) -> NavigationFunction:
        """The navigation function whose G is measured against that at the goal points (P, 3).

        Raises InvalidInputError that lists every relation violated at the goal.
        """
        if violated := relations.violated(goal):
            raise InvalidInputError(
                [Mistake("goal", f"violates {label}", "place the bodies apart") for label in violated]
            )
        plain = cls(relations, kappa, lambda_, h)
        log_G_goal = float(plain.log_G(goal))
        return cls(relations, kappa, lambda_, h, log_G_goal, shaping)

    def log_G(self, p: Array) -> Array:
        """log G(p) (...); -inf where a relation is violated."""
        betas = self.relations.betas(p)
        with np.errstate(all="ignore"):
            log_G = self._log_obstacle(betas)[0]
        return np.where((betas <= 0.0).any(axis=-1), -np.inf, log_G)

    def value(self, gamma: Array | float, p: Array) -> Array:
        """Phi (...); +inf (or the shaping's supremum) where a relation is violated."""
        return self._value(gamma, p, self.shaping)

    def phi(self, gamma: Array | float, p: Array) -> Array:
        """The paper's gamma / (gamma^kappa + G / G_goal)^(1/kappa) in [0, 1]; 1 where one is violated."""
        return self._value(gamma, p, PaperPhi(self.kappa))

    def value_and_gradient(self, gamma: Array | float, p: Array) -> tuple[Array, Array, Array]:
        """Phi (...) and its partial derivatives with respect to gamma (...) and to the points (..., P, 3).

        Exact also at gamma = 0, since d w = (G / G_goal)^(-1/kappa) (d gamma - gamma d log G / kappa).
        Where a relation is violated there is no gradient: the value is that of `value`, both derivatives are
        nan. A controller therefore asks whether d Phi / d gamma is finite and, if not, names the relations
        with `violated`.
        """
        d, betas = self.relations.differences_and_betas(p)
        with np.errstate(all="ignore"):  # logarithms of betas <= 0, dealt with below
            log_G, slopes = self._log_obstacle(betas)
            log_scale = (self.log_G_goal - log_G) / self.kappa
            L = np.log(gamma) + log_scale
            value = self.shaping.value(L)
            by_gamma = np.exp(np.minimum(self.shaping.log_slope(L) + log_scale, LARGEST_EXPONENT))
            by_log_G = by_gamma * gamma * (-1.0 / self.kappa)
        by_p = self.relations.gradient(by_log_G[..., None] * slopes, d)
        bad = betas.min(axis=-1, initial=np.inf) <= 0.0
        if bad.any():
            value = np.where(bad, self.shaping.supremum, value)
            by_gamma = np.where(bad, np.nan, by_gamma)
            by_p = np.where(bad[..., None, None], np.nan, by_p)
        return value, by_gamma, by_p

    def violated(self, p: Array) -> list[Label]:
        """Labels of the relations whose beta is not positive at some of the points p (..., P, 3)."""
        return self.relations.violated(p)

    def _value(self, gamma: Array | float, p: Array, shaping: Shaping) -> Array:
        log_G = self.log_G(p)
        with np.errstate(divide="ignore", invalid="ignore"):  # the goal, where gamma is 0
            L = np.log(gamma) + (self.log_G_goal - log_G) / self.kappa
        return np.where(log_G == -np.inf, shaping.supremum, shaping.value(L))

    @cached_property
    def _log_obstacle(self) -> LogObstacle:
        if self.lambda_ == 0.0:
            return log_product
        return log_verified(len(self.relations.apart), self.lambda_, self.h, self.levels)
