"""The obstacle function G of the betas, in the log domain: from log beta to log G.

With lambda = 0, G is the product of the betas. With lambda > 0 it is the paper's, of relation verification functions
(RVFs) of all levels; what is left out of the sets of relations must be impossible (see `realisable`): where exactly
the relations of a set Z are realised, b_Z = 0 while every other set of its level holds some relation that is not
realised, so the complement's product B_Z is positive and g_Z = 0. Sets that are never realised are not needed for
that, and without them every factor stays finite.
"""

from __future__ import annotations

from collections.abc import Callable
from math import log

import numpy as np

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.navigation.realisable import RelationSets
from drake_ltl.navigation.relations import Array
from drake_ltl.navigation.shaping import LARGEST_EXPONENT

LogObstacle = Callable[[Array], tuple[Array, "Array | float"]]
"""From finite log betas (..., n) to log G (...) and its slopes d log G / d log beta (..., n), or 1 for all."""
LARGEST_LOG = 1e300
"""Logarithms that grow beyond this saturate: their differences stay numbers."""


def log_product(log_betas: Array) -> tuple[Array, float]:
    """G is the product of all betas: zero exactly where some relation is realised."""
    return log_betas.sum(axis=-1), 1.0


def log_verified(relations: RelationSets, lambda_: float, h: float, levels: int | None = None) -> LogObstacle:
    """G = G_0 prod_L prod_j (g_Rj)_L with relation verification functions of every level L = 1 .. n_L.

    Of each relation R, a set of the first `relations.n_apart` betas: the relation proximity function b_R is their
    sum, B_R the product of b over all other relations of its level, and g_R = b_R + lambda b_R / (b_R + B_R^(1/h)).
    The remaining betas (spheres inside balls) form the workspace factor G_0.

    With fewer levels than relations that can be realised at once, G stays positive through a collision: where
    two betas vanish together, b_R and B_R do so as well and g_R of level 1 need not.

    Args:
        relations: all sets that may be realised at once.
        levels: how many levels to use; None means all.

    Raises:
        InvalidInputError: lambda or h is not positive, or realisable levels would be left out.
    """
    _check(relations, lambda_, h, levels)
    if not relations.sets:
        return log_product
    level = _Levels(relations)
    log_lambda, log_h = log(lambda_), log(h)

    def log_G(log_betas: Array) -> tuple[Array, Array]:
        pairs, rest = log_betas[..., : relations.n_apart], log_betas[..., relations.n_apart :]
        log_b = level.log_sums(pairs)
        log_B = level.others(log_b)
        root = np.clip(log_B, -LARGEST_LOG * h, LARGEST_LOG * h) / h
        log_sum = np.logaddexp(log_b, root)  # log(b + B^(1/h))
        log_ratio = log_lambda - log_sum
        log_g = log_b + np.logaddexp(0.0, log_ratio)
        # sigma: share of lambda's part in g; of the sum, b has the share exp(log_b - log_sum).
        log_sigma = -np.logaddexp(0.0, -log_ratio)
        by_b = np.exp(log_sigma + log_b - log_sum)
        by_B = np.exp(np.minimum(log_sigma + (root - log_sum) - log_h, LARGEST_EXPONENT))
        slopes = level.to_relations(1.0 - by_b - level.others(by_B), pairs, log_b)
        return log_g.sum(axis=-1) + rest.sum(axis=-1), np.concatenate([slopes, np.ones_like(rest)], axis=-1)

    return log_G


class _Levels:
    """Sums over the members of each set, and over the sets of each level."""

    def __init__(self, relations: RelationSets):
        sizes = np.array([len(chosen) for chosen in relations.sets])
        self._members = np.array([index for chosen in relations.sets for index in chosen])
        """All sets' members, one set after another."""
        self._starts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
        self._owners = np.repeat(np.arange(len(sizes)), sizes)
        self._counts = np.unique(sizes, return_counts=True)[1]
        self._level_starts = np.concatenate([[0], np.cumsum(self._counts)[:-1]])
        self._one_hot = np.eye(relations.n_apart)[self._members]

    def log_sums(self, log_betas: Array) -> Array:
        """log b (..., N) of all sets."""
        return np.logaddexp.reduceat(log_betas[..., self._members], self._starts, axis=-1)

    def others(self, terms: Array) -> Array:
        """For each set the sum of `terms` (..., N) over the other sets of its level.

        Summed from both sides: what one set has can be larger than all others' by so much that subtracting it from
        the level's sum would leave nothing of these.
        """
        parts = np.split(terms, self._level_starts[1:], axis=-1)
        return np.concatenate([_sums_without_each(part) for part in parts], axis=-1)

    def to_relations(self, by_log_b: Array, log_betas: Array, log_b: Array) -> Array:
        """Slopes with respect to log beta (..., n_apart), from those with respect to log b (..., N)."""
        shares = np.exp(log_betas[..., self._members] - log_b[..., self._owners])
        return (by_log_b[..., self._owners] * shares) @ self._one_hot


def _sums_without_each(terms: Array) -> Array:
    before, after = np.zeros_like(terms), np.zeros_like(terms)
    before[..., 1:] = np.cumsum(terms[..., :-1], axis=-1)
    after[..., :-1] = np.cumsum(terms[..., :0:-1], axis=-1)[..., ::-1]
    return before + after


def _check(relations: RelationSets, lambda_: float, h: float, levels: int | None) -> None:
    mistakes = []
    if not lambda_ > 0.0:
        mistakes.append(Mistake("controller.lambda", f"is {lambda_!r}", "must be positive here"))
    if not h > 0.0:
        mistakes.append(Mistake("controller.h", f"is {h!r}", "must be positive"))
    if levels is not None and levels < relations.levels:
        what = f"relation verification functions of {levels} of {relations.levels} levels leave collisions with G > 0"
        mistakes.append(Mistake("controller.lambda", what, "use all levels, or lambda: 0"))
    if mistakes:
        raise InvalidInputError(mistakes)
