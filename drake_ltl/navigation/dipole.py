"""gamma of a body that has to arrive along a heading: its descent runs into the goal as field lines do into a dipole.

The paper's gamma is |e|^2, e = p - p_goal: the descent comes straight, from wherever it started. Here the error s along
the goal's heading counts less than the error l across it, near the goal:

    gamma = l^2 + s^2 - (1 - ratio) reach^2 log(1 + s^2 / reach^2).

gamma is strictly convex, grows as |e|^2 far away, and is l^2 + ratio s^2 at the goal, which thereby is a node of the
descent with the heading as its slow direction: l ~ s^(1 / ratio), so all descents but the two that come straight from
the sides arrive with the slope l / s = 0.

The dipolar navigation functions of Tanner, Loizou and Kyriakopoulos (IEEE Trans. Robotics and Automation 19(1), 2003)
have the same aim by an obstacle, the line across the goal, in G. For a factor eps + s^2 with eps > 0 the Hessian at the
goal remains that of |e|^2, a star without a slow direction; with eps = 0, phi is not even continuous there. With gamma
instead of G tilted, phi remains smooth and G as it was.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.navigation.relations import Array


def heading_vector(theta: Array | float) -> Array:
    """h = (cos theta, sin theta) (..., 2)."""
    return np.stack([np.cos(theta), np.sin(theta)], axis=-1)


def left_of(h: Array) -> Array:
    """n (..., 2), h turned by a quarter to the left: d h / d theta."""
    return np.stack([-h[..., 1], h[..., 0]], axis=-1)


@dataclass(frozen=True)
class Dipole:
    """gamma (m^2) of one body with a goal pose in the plane.

    Raises InvalidInputError for a ratio outside (0, 1] or a reach that is not positive.
    """

    p_goal: tuple[float, float]
    """[m], in W."""
    heading: float
    """theta_goal [rad]."""
    ratio: float = 0.25
    """Weight of the error along the heading, at the goal; 1 gives |e|^2, the paper's gamma."""
    reach: float = 1.0
    """Distance from which on the weights differ [m]. What stands farther off sees |e|^2: of obstacles near a goal,
    unequal weights could make minima (Paternain, Koditschek and Ribeiro, IEEE Trans. Automatic Control 63(9), 2018)."""

    def __post_init__(self) -> None:
        mistakes = []
        if not 0.0 < self.ratio <= 1.0:
            mistakes.append(Mistake("dipole.ratio", f"is {self.ratio!r}", "must be above 0 and at most 1"))
        if not 0.0 < self.reach < np.inf:
            mistakes.append(Mistake("dipole.reach", f"is {self.reach!r}", "must be positive and finite"))
        if not np.isfinite([*self.p_goal, self.heading]).all():
            mistakes.append(Mistake("dipole.goal", f"is {(*self.p_goal, self.heading)!r}", "must be finite"))
        if mistakes:
            raise InvalidInputError(mistakes)

    def value(self, p: Array) -> Array:
        """gamma (...) [m^2] at p (..., 2) [m]."""
        along, across = self._errors(p)
        less = (1.0 - self.ratio) * self.reach**2 * np.log1p((along / self.reach) ** 2)
        return across**2 + along**2 - less

    def gradient(self, p: Array) -> Array:
        """d gamma / dp (..., 2) [m]."""
        along, across = self._errors(p)
        weight = 1.0 - (1.0 - self.ratio) / (1.0 + (along / self.reach) ** 2)
        errors = np.stack([weight * along, across], axis=-1)
        return 2.0 * errors @ self._axes

    def at(self, x: float, y: float) -> tuple[float, float, float]:
        """gamma [m^2] and its derivatives by x and y [m] at one point: the same for floats, as controllers ask."""
        (c, s), (_, _) = self._axes.tolist()
        x, y = x - self.p_goal[0], y - self.p_goal[1]
        along, across = c * x + s * y, c * y - s * x
        square, less = (along / self.reach) ** 2, 1.0 - self.ratio
        gamma = across**2 + along**2 - less * self.reach**2 * math.log1p(square)
        slope = 2.0 * (1.0 - less / (1.0 + square)) * along
        return gamma, c * slope - s * 2.0 * across, s * slope + c * 2.0 * across

    def _errors(self, p: Array) -> tuple[Array, Array]:
        """s and l (...) [m]."""
        errors = (np.asarray(p) - self.p_goal) @ self._axes.T
        return errors[..., 0], errors[..., 1]

    @cached_property
    def _axes(self) -> Array:
        """The heading and what is left of it, as rows."""
        h = heading_vector(self.heading)
        return np.stack([h, left_of(h)])
