"""The obstacle function G of the betas, as its logarithm."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from math import comb, log

import numpy as np

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.navigation.relations import Array

MAX_VERIFIED = 10
"""More binary relations than these have too many subsets (2^n - 1) for relation verification functions."""

LogObstacle = Callable[[Array], tuple[Array, Array]]
"""From positive betas (..., n) to log G (...) and its slopes d log G / d beta (..., n)."""


def log_product(betas: Array) -> tuple[Array, Array]:
    """G is the product of all betas: zero exactly where some relation is realised."""
    return np.log(betas).sum(axis=-1), 1.0 / betas


def log_verified(n_apart: int, lambda_: float, h: float, levels: int | None = None) -> LogObstacle:
    """G = G_0 prod_L prod_j (g_Rj)_L with relation verification functions of every level L = 1 .. n_apart.

    A relation R of level k is any set of k of the first `n_apart` betas; b_R is their sum, B_R the product of
    b over the other relations of level k, and g_R = b_R + lambda b_R / (b_R + B_R^(1/h)). The remaining betas
    (spheres inside balls) form the product G_0.

    With fewer levels than relations that can be realised at once, G stays positive through a collision: where
    two betas vanish together, b_R and B_R do so as well and g_R of level 1 need not.

    Raises:
        InvalidInputError: if fewer levels are asked for, or there are more than MAX_VERIFIED relations.
    """
    _check(n_apart, lambda_, h, n_apart if levels is None else levels)
    members = _membership(n_apart)
    starts = np.cumsum([0] + [comb(n_apart, k) for k in range(1, n_apart)])[: n_apart or None]
    sizes = [comb(n_apart, k) for k in range(1, n_apart + 1)]
    log_lambda = log(lambda_)

    def per_level(terms: Array) -> Array:
        """Sum of terms (..., 2^n - 1) over each level, repeated for each relation of the level."""
        return np.repeat(np.add.reduceat(terms, starts, axis=-1), sizes, axis=-1)

    def log_G(betas: Array) -> tuple[Array, Array]:
        log_G_0, slopes_0 = log_product(betas[..., n_apart:])
        b = betas[..., :n_apart] @ members.T
        log_b = np.log(b)
        log_B = per_level(log_b) - log_b
        log_sum = np.logaddexp(log_b, log_B / h)  # log(b + B^(1/h))
        log_ratio = log_lambda - log_sum
        log_g = log_b + np.logaddexp(0.0, log_ratio)
        # sigma: share of lambda's part in g; of the sum, b has the share exp(log_b - log_sum).
        sigma = np.exp(-np.logaddexp(0.0, -log_ratio))
        by_b = sigma * np.exp(log_b - log_sum)
        by_B = sigma * np.exp(log_B / h - log_sum) / h
        by_log_b = 1.0 - by_b - (per_level(by_B) - by_B)
        slopes = (by_log_b / b) @ members
        return log_G_0 + log_g.sum(axis=-1), np.concatenate([slopes, slopes_0], axis=-1)

    return log_G if n_apart else log_product


def _membership(n: int) -> Array:
    """Rows are all nonempty subsets of n relations, by size, as zeros and ones (2^n - 1, n)."""
    subsets = [chosen for k in range(1, n + 1) for chosen in combinations(range(n), k)]
    members = np.zeros((len(subsets), n))
    for row, chosen in enumerate(subsets):
        members[row, list(chosen)] = 1.0
    return members


def _check(n_apart: int, lambda_: float, h: float, levels: int) -> None:
    mistakes = []
    if not lambda_ > 0.0:
        mistakes.append(Mistake("controller.lambda", f"is {lambda_!r}", "must be positive here"))
    if not h > 0.0:
        mistakes.append(Mistake("controller.h", f"is {h!r}", "must be positive"))
    if levels < n_apart:
        what = f"relation verification functions of {levels} of {n_apart} levels leave collisions with G > 0"
        mistakes.append(Mistake("controller.lambda", what, "use all levels, or lambda: 0"))
    if n_apart > MAX_VERIFIED:
        what = f"{n_apart} binary relations have {2**n_apart - 1} relations over all levels"
        remedy = f"use lambda: 0, or at most {MAX_VERIFIED} binary relations"
        mistakes.append(Mistake("controller.lambda", what, remedy))
    if mistakes:
        raise InvalidInputError(mistakes)
