"""Binary relations between spheres and their proximity functions beta.

A configuration is an array of points p (..., P, 3) [m] in the world frame: the centres of all spheres of one
plan step, moving and static. A relation is realised (something touches) where its beta is zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.geometry import Vector3

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Label:
    """What a relation is about, for messages."""

    kind: str
    """One of the kinds of collision functions, such as `agent-region`."""
    names: tuple[str, ...]

    def __str__(self) -> str:
        return f"{' and '.join(self.names)} ({self.kind})"


@dataclass(frozen=True)
class Apart:
    """Two spheres stay apart: beta = |p_a - p_b|^2 - radius^2."""

    a: int
    b: int
    radius: float
    """Sum of both radii [m]."""
    label: Label = Label("apart", ())


@dataclass(frozen=True)
class Inside:
    """A sphere stays inside a fixed ball: beta = radius^2 - |p_a - centre|^2."""

    a: int
    centre: Vector3
    radius: float
    """Radius of the ball less that of the sphere [m]."""
    label: Label = Label("inside", ())


@dataclass(frozen=True)
class Relations:
    """All relations of one plan step; arrays over relations list `apart` first, then `inside`."""

    n_points: int
    apart: tuple[Apart, ...] = ()
    inside: tuple[Inside, ...] = ()

    def __len__(self) -> int:
        return len(self.apart) + len(self.inside)

    @property
    def labels(self) -> tuple[Label, ...]:
        """Label of each relation."""
        return tuple(relation.label for relation in (*self.apart, *self.inside))

    def betas(self, p: Array) -> Array:
        """Proximity function of each relation (..., n) [m^2] at the points p (..., P, 3) [m]."""
        return self.differences_and_betas(p)[1]

    def differences_and_betas(self, p: Array) -> tuple[Array, Array]:
        """The vector d of each relation (..., n, 3) [m] and beta = +-(|d|^2 - radius^2) (..., n) [m^2].

        d = p_a - p_b, or p_a - centre; the sign is minus for a sphere inside a ball.
        """
        d = self._incidence @ p
        d -= self._centres
        squares = np.einsum("...k,...k->...", d, d)
        squares -= self._squared_radii
        squares *= self._signs
        return d, squares

    def log_betas(self, p: Array) -> tuple[Array, Array]:
        """log beta (..., n), -inf where a relation is violated, and the vectors d / 4 (..., n, 3) [m], of any finite p.

        Squares that leave the range of floating point numbers are formed of lengths divided by the largest of each
        relation; a quarter of every difference is in range. nan comes of nan alone.
        """
        with np.errstate(all="ignore"):
            plain = self.betas(p)
            quarter = self._incidence @ (np.asarray(p) / 4.0) - self._centres / 4.0
            scale = np.maximum(np.abs(quarter).max(axis=-1), self._radii / 4.0)
            scale = np.where(scale > 0.0, scale, 1.0)
            lengths = quarter / scale[..., None]
            scaled = np.einsum("...k,...k->...", lengths, lengths) - np.square(self._radii / 4.0 / scale)
            far = np.log(self._signs * scaled) + 2.0 * np.log(scale) + 2.0 * np.log(4.0)
            log_betas = np.where(np.isfinite(plain), np.log(plain), far)
        violated = np.where(np.isfinite(plain), plain, self._signs * scaled) <= 0.0
        return np.where(violated, -np.inf, log_betas), quarter

    def gradient(self, slopes: Array, differences: Array) -> Array:
        """Gradient (..., P, 3) of a function of the betas with respect to the points.

        `slopes` (..., n) are its derivatives with respect to each beta, `differences` (..., n, 3) the vectors
        d that belong to the betas.
        """
        return self._transposed @ (slopes[..., None] * differences)

    def log_product_gradient(self, p: Array) -> Array:
        """Gradient (..., P, 3) [1/m] of log G = sum log beta at points where every beta is positive."""
        d, betas = self.differences_and_betas(p)
        return self.gradient(1.0 / betas, d)

    def violated(self, p: Array) -> list[Label]:
        """Labels of the relations whose beta is not positive (or not a number) at some of p (..., P, 3)."""
        positive = self.log_betas(p)[0] > -np.inf
        everywhere = positive.all(axis=tuple(range(positive.ndim - 1)))
        return [label for label, holds in zip(self.labels, everywhere, strict=True) if not holds]

    @cached_property
    def _incidence(self) -> Array:
        """d = incidence @ p - centres. A product with zeros and ones is exact and quicker than indexing."""
        incidence = np.zeros((len(self), self.n_points))
        for row, apart in enumerate(self.apart):
            incidence[row, apart.a] += 1.0
            incidence[row, apart.b] -= 1.0
        for row, inside in enumerate(self.inside, start=len(self.apart)):
            incidence[row, inside.a] = 1.0
        return incidence

    @cached_property
    def _transposed(self) -> Array:
        """Incidence (P, n) times d beta / d d = +-2 d, the vector d left out."""
        return np.ascontiguousarray((2.0 * self._signs[:, None] * self._incidence).T)

    @cached_property
    def _centres(self) -> Array:
        centres = np.zeros((len(self), 3))
        centres[len(self.apart) :] = np.reshape([inside.centre for inside in self.inside], (-1, 3))
        return centres

    @cached_property
    def _radii(self) -> Array:
        return np.array([float(relation.radius) for relation in (*self.apart, *self.inside)])

    @cached_property
    def _squared_radii(self) -> Array:
        with np.errstate(over="ignore"):
            return np.square(self._radii)

    @cached_property
    def _signs(self) -> Array:
        return np.repeat([1.0, -1.0], [len(self.apart), len(self.inside)])
