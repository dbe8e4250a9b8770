"""The field of a step as seen on the floor: movers slide in the plane, each at the height of its goal.

Here are the critical points of the navigation function found and told apart: the goal, saddles, and what must not be,
other minima. They are the same for every shaping, so log w stands for all of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import root

from drake_ltl.navigation.potential import NavigationFunction
from drake_ltl.navigation.relations import Array
from drake_ltl.navigation.shaping import Shaping
from drake_ltl.navigation.step import StepRelations

DIFFERENCE = 1e-5
"""Step of central differences of the gradient [m]: their error is of the order of its square, and 1e-11 by rounding."""
FLAT = 1e-4
"""Curvatures of log w smaller than this, relative to the largest, count as none."""

Kind = Literal["minimum", "saddle", "maximum", "degenerate"]


@dataclass(frozen=True)
class LogW:
    """psi = log w, nowhere flat but at critical points; no shaping for a controller, for it is not 0 at the goal."""

    supremum = float("inf")

    def value(self, L: Array) -> Array:
        return L

    def log_slope(self, L: Array) -> Array:
        return -L


@dataclass(frozen=True)
class CriticalPoint:
    """Where the gradient vanishes, other than at the goal."""

    x: Array
    """(2 n_movers,) [m]."""
    kind: Kind
    curvatures: Array
    """Eigenvalues of the Hessian of log w, increasing (2 n_movers,) [1/m^2]."""
    directions: Array
    """Their eigenvectors, as columns."""


@dataclass(frozen=True)
class PlanarField:
    """log w of a step as a function of x (2 n_movers,), the stacked (x, y) [m] of its movers' centres."""

    step: StepRelations
    function: NavigationFunction

    @staticmethod
    def of(step: StepRelations, *, kappa: float, lambda_: float = 0.0, h: float = 1.0) -> PlanarField:
        """Raises InvalidInputError as `NavigationFunction.for_goal` does."""
        n, shaping = step.n_movers, LogW()
        return PlanarField(
            step,
            NavigationFunction.for_goal(
                step.relations, step.goal, kappa=kappa, lambda_=lambda_, h=h, shaping=shaping, n_movers=n
            ),
        )

    @property
    def goal(self) -> Array:
        """(2 n_movers,)"""
        return self._flat(self.step.goal)

    @property
    def start(self) -> Array:
        """(2 n_movers,)"""
        return self._flat(self.step.start)

    def _flat(self, p: Array) -> Array:
        return p[: self.step.n_movers, :2].ravel()

    def points(self, x: Array) -> Array:
        """All points (..., P, 3) of the step when the movers are at x (..., 2 n_movers)."""
        movers = np.empty((*np.shape(x)[:-1], self.step.n_movers, 3))
        movers[..., :2] = np.reshape(x, (*np.shape(x)[:-1], -1, 2))
        movers[..., 2] = self.step.goal[: self.step.n_movers, 2]
        return self.step.at(movers)

    def gamma(self, x: Array) -> Array:
        """Sum of all movers' squared errors (...) [m^2]."""
        return np.square(x - self.goal).sum(axis=-1)

    def value(self, x: Array, shaping: Shaping | None = None) -> Array:
        """log w (...), or psi; the supremum where something touches."""
        p, gamma = self.points(x), self.gamma(x)
        return self.function.value(gamma, p) if shaping is None else self._shaped(shaping).value(gamma, p)

    def gradient(self, x: Array, shaping: Shaping | None = None) -> Array:
        """Of log w or psi with respect to x (..., 2 n_movers) [1/m]; nan where something touches."""
        function = self.function if shaping is None else self._shaped(shaping)
        _, by_gamma, by_p = function.value_and_gradient(self.gamma(x), self.points(x))
        by_movers = by_p[..., : self.step.n_movers, :2]
        return np.asarray(by_gamma)[..., None] * 2.0 * (x - self.goal) + by_movers.reshape(np.shape(x))

    def _shaped(self, shaping: Shaping) -> NavigationFunction:
        f = self.function
        return NavigationFunction(f.relations, f.kappa, f.lambda_, f.h, f.log_G_goal, shaping, realisable=f.realisable)

    def hessian(self, x: Array) -> Array:
        """Of log w at x (2 n_movers,), by central differences of the gradient, symmetrised."""
        steps = DIFFERENCE * np.eye(len(x))
        rows = (self.gradient(x + steps) - self.gradient(x - steps)) / (2.0 * DIFFERENCE)
        return 0.5 * (rows + rows.T)

    def free(self, x: Array) -> bool:
        """Whether nothing touches."""
        return not self.function.violated(self.points(x))

    def critical_points(self, starts: Iterable[Array]) -> list[CriticalPoint]:
        """Those that a root finder reaches from the starts (each (2 n_movers,)), each once, without the goal."""
        found: list[CriticalPoint] = []
        for start in starts:
            point = self.critical_near(start)
            if point is not None and all(np.linalg.norm(point.x - other.x) > 1e-4 for other in found):
                found.append(point)
        return found

    def critical_near(self, x: Array) -> CriticalPoint | None:
        """The critical point that the root finder reaches from x, None if it reaches none."""
        if not self.free(x):
            return None
        result = root(self._defined_gradient, x, jac=self.hessian, tol=1e-12)
        at = result.x
        if not (np.isfinite(at).all() and self.free(at) and np.linalg.norm(self.gradient(at)) < 1e-8):
            return None
        curvatures, directions = np.linalg.eigh(self.hessian(at))
        return CriticalPoint(at, _kind(curvatures), curvatures, directions)

    def _defined_gradient(self, x: Array) -> Array:
        """A large one instead of nan, so that the root finder turns back."""
        gradient = self.gradient(x)
        return gradient if np.isfinite(gradient).all() else np.full_like(x, 1e6)


def _kind(curvatures: Array) -> Kind:
    if (np.abs(curvatures) <= FLAT * np.abs(curvatures).max()).any():
        return "degenerate"
    rising = curvatures > 0.0
    return "minimum" if rising.all() else "saddle" if rising.any() else "maximum"


def sampled_starts(step: StepRelations, count: int, seed: int) -> Iterator[Array]:
    """Random x (2 n_movers,) in which nothing touches, as many as asked for; fewer if the space is too crowded.

    Movers take their places one by one, each anywhere in the balls that it must stay inside of.
    """
    rng = np.random.default_rng(seed)
    for _ in range(count):
        for _ in range(20):
            p = _placed(step, rng)
            if p is not None:
                yield p[: step.n_movers, :2].ravel()
                break


def _placed(step: StepRelations, rng: np.random.Generator) -> Array | None:
    p = step.goal.copy()
    pairs = [
        (relation.a, getattr(relation, "b", relation.a)) for relation in (*step.relations.apart, *step.relations.inside)
    ]
    standing = range(step.n_movers, len(p))
    for mover in range(step.n_movers):
        ball = min((inside for inside in step.relations.inside if inside.a == mover), key=lambda inside: inside.radius)
        mine = [row for row, (a, b) in enumerate(pairs) if mover in (a, b) and (max(a, b) in (mover, *standing))]
        for _ in range(200):
            angle, distance = rng.uniform(0.0, 2.0 * np.pi), ball.radius * np.sqrt(rng.uniform())
            p[mover, :2] = ball.centre[0] + distance * np.cos(angle), ball.centre[1] + distance * np.sin(angle)
            if (step.relations.betas(p)[mine] > 0.0).all():
                break
        else:
            return None
    return p
