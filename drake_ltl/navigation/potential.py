"""The multirobot navigation function of one plan step, with its gradient, in the log domain."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import isfinite

import numpy as np

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.navigation.obstacle import LARGEST_LOG, LogObstacle, log_product, log_verified
from drake_ltl.navigation.realisable import RelationSets, all_sets, fixed_points, realisable_sets
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
    realisable: RelationSets | None = None
    """Sets of relations for lambda > 0; None means that all sets may be realised."""

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
        n_movers: int | None = None,
    ) -> NavigationFunction:
        """The navigation function whose G is measured against that at the goal points (P, 3).

        With `n_movers`, all points but the first so many stay where they are in `goal`, for ever; lambda > 0 then
        does without the sets of relations that are never realised at once.

        Raises InvalidInputError that lists every relation violated at the goal.
        """
        if violated := relations.violated(goal):
            raise InvalidInputError(
                [Mistake("goal", f"violates {label}", "place the bodies apart") for label in violated]
            )
        realisable = None
        if lambda_ > 0.0 and n_movers is not None:
            realisable = realisable_sets(relations, fixed_points(goal, n_movers))
        plain = cls(relations, kappa, lambda_, h, realisable=realisable)
        log_G_goal = float(plain.log_G(goal))
        return cls(relations, kappa, lambda_, h, log_G_goal, shaping, realisable=realisable)

    def log_G(self, p: Array) -> Array:
        """log G(p) (...); -inf where a relation is violated."""
        log_betas, violated, _ = self._log_betas(p)
        with np.errstate(all="ignore"):
            return np.where(violated, -np.inf, self._log_obstacle(log_betas)[0])

    def value(self, gamma: Array | float, p: Array) -> Array:
        """Phi (...); the shaping's supremum where a relation is violated."""
        return self._value(gamma, p, self.shaping)

    def phi(self, gamma: Array | float, p: Array) -> Array:
        """The paper's gamma / (gamma^kappa + G / G_goal)^(1/kappa) in [0, 1]; 1 where one is violated."""
        return self._value(gamma, p, PaperPhi(self.kappa))

    def value_and_gradient(self, gamma: Array | float, p: Array) -> tuple[Array, Array, Array]:
        """Phi (...) and its partial derivatives with respect to gamma (...) and to the points (..., P, 3).

        Exact also at gamma = 0, since d w = (G / G_goal)^(-1/kappa) (d gamma - gamma d log G / kappa).
        Where a relation is violated there is no gradient: the value is that of `value`, both derivatives are
        nan. A controller therefore asks whether d Phi / d gamma is finite and, if not, names the relations
        with `violated`. Finite for all other finite arguments: what would overflow saturates.
        """
        with np.errstate(all="ignore"):  # whatever is not finite is done again, with care
            d, betas = self.relations.differences_and_betas(p)
            log_G, shares = self._log_obstacle(np.log(betas))
            log_scale = (self.log_G_goal - log_G) / self.kappa
            L = np.log(gamma) + log_scale
            value = self.shaping.value(L)
            by_gamma = np.exp(self.shaping.log_slope(L) + log_scale)
            by_log_G = by_gamma * gamma / -self.kappa
            by_p = self.relations.gradient(by_log_G[..., None] * shares / betas, d)
            checksum = (value + by_gamma + log_G).sum() + by_p.sum()
        if isfinite(checksum):
            return value, by_gamma, by_p
        return self._with_care(gamma, p)

    def _with_care(self, gamma: Array | float, p: Array) -> tuple[Array, Array, Array]:
        """The same where something touches or numbers are extreme: every product as a sum of logarithms."""
        log_betas, violated, quarter = self._log_betas(p)
        with np.errstate(all="ignore"):
            log_G, shares = self._log_obstacle(log_betas)
            log_scale = self._log_scale(log_G)
            log_gamma = np.log(gamma)
            value = np.minimum(self.shaping.value(log_gamma + log_scale), np.finfo(float).max)
            log_by_gamma = self.shaping.log_slope(log_gamma + log_scale) + log_scale
            log_by_log_G = (log_by_gamma + log_gamma - np.log(self.kappa))[..., None]
            log_slopes = log_by_log_G + np.log(np.abs(shares)) - log_betas
            log_terms = log_slopes[..., None] + np.log(np.abs(quarter)) + np.log(4.0)
            terms = np.exp(np.minimum(log_terms, LARGEST_EXPONENT)) * np.sign(quarter)
            by_p = self.relations.gradient(-np.sign(shares) * np.ones_like(log_betas), terms)
            by_gamma = np.exp(np.minimum(log_by_gamma, LARGEST_EXPONENT))
        return (
            np.where(violated, self.shaping.supremum, value),
            np.where(violated, np.nan, by_gamma),
            np.where(np.asarray(violated)[..., None, None], np.nan, by_p),
        )

    def violated(self, p: Array) -> list[Label]:
        """Labels of the relations whose beta is not positive at some of the points p (..., P, 3)."""
        return self.relations.violated(p)

    def _value(self, gamma: Array | float, p: Array, shaping: Shaping) -> Array:
        log_betas, violated, _ = self._log_betas(p)
        with np.errstate(all="ignore"):  # the goal, where gamma is 0
            L = np.log(gamma) + self._log_scale(self._log_obstacle(log_betas)[0])
            return np.where(violated, shaping.supremum, np.minimum(shaping.value(L), np.finfo(float).max))

    def _log_betas(self, p: Array) -> tuple[Array, Array, Array]:
        """Finite log betas (..., n) unless p is nan, whether a relation is violated (...), and d / 4 (..., n, 3)."""
        log_betas, quarter = self.relations.log_betas(p)
        return np.maximum(log_betas, -LARGEST_LOG), (log_betas == -np.inf).any(axis=-1), quarter

    def _log_scale(self, log_G: Array) -> Array:
        """log (G / G_goal)^(-1/kappa)."""
        return np.clip((self.log_G_goal - log_G) / self.kappa, -LARGEST_LOG, LARGEST_LOG)

    @cached_property
    def _log_obstacle(self) -> LogObstacle:
        if self.lambda_ == 0.0:
            return log_product
        relations = self.realisable or all_sets(len(self.relations.apart))
        return log_verified(relations, self.lambda_, self.h, self.levels)
