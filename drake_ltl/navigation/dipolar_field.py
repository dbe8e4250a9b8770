"""The navigation function of several bodies on the floor, each with a goal pose: value, and the force on each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.navigation.dipole import Dipole
from drake_ltl.navigation.potential import DEFAULT_SHAPING, NavigationFunction
from drake_ltl.navigation.relations import Array, Label
from drake_ltl.navigation.shaping import Shaping
from drake_ltl.navigation.step import StepRelations


@dataclass(frozen=True)
class DipolarField:
    """k Phi of a step whose movers slide on the floor, with gamma the sum of one dipole for each.

    Raises InvalidInputError where dipoles and movers do not match.
    """

    step: StepRelations
    function: NavigationFunction
    dipoles: tuple[Dipole, ...]
    """One for each mover, in their order; `Dipole(..., ratio=1)` for one that has no heading to arrive with."""
    force: float
    """k [N]."""

    def __post_init__(self) -> None:
        goals = self.step.goal[: self.step.n_movers, :2]
        dipoles = np.array([dipole.p_goal for dipole in self.dipoles]).reshape(-1, 2)
        if goals.shape != dipoles.shape or not np.allclose(goals, dipoles, rtol=0.0, atol=1e-9):
            what = f"are at {dipoles.tolist()}, the movers' goals at {goals.tolist()}"
            raise InvalidInputError([Mistake("dipoles", what, "give one dipole for each mover, at its goal")])
        if not 0.0 < self.force < np.inf:
            raise InvalidInputError([Mistake("force", f"is {self.force!r}", "must be positive and finite")])

    @staticmethod
    def of(
        step: StepRelations,
        dipoles: Sequence[Dipole],
        *,
        force: float,
        kappa: float,
        shaping: Shaping = DEFAULT_SHAPING,
    ) -> DipolarField:
        """With G measured against that at the goal, as `NavigationFunction.for_goal`."""
        function = NavigationFunction.for_goal(step.relations, step.goal, kappa=kappa, shaping=shaping)
        return DipolarField(step, function, tuple(dipoles), force)

    def gamma(self, p: Array) -> Array:
        """Each mover's share of gamma (..., N) [m^2] at p (..., N, 2) [m]."""
        return np.stack([dipole.value(p[..., i, :]) for i, dipole in enumerate(self.dipoles)], axis=-1)

    def value(self, p: Array) -> Array:
        """k Phi (...) [J]; psi's supremum where something touches."""
        return self.force * self.function.value(self.gamma(p).sum(axis=-1), self.points(p))

    def value_and_forces(self, p: Array) -> tuple[Array, Array]:
        """k Phi (...) [J] and f = -k dPhi/dp (..., N, 2) [N]; f is nan where something touches."""
        value, by_gamma, by_p = self.function.value_and_gradient(self.gamma(p).sum(axis=-1), self.points(p))
        slopes = np.stack([dipole.gradient(p[..., i, :]) for i, dipole in enumerate(self.dipoles)], axis=-2)
        gradient = np.asarray(by_gamma)[..., None, None] * slopes + by_p[..., : len(self.dipoles), :2]
        return self.force * value, -self.force * gradient

    def points(self, p: Array) -> Array:
        """All points (..., P, 3) of the step, the movers at p and at the height of their goals."""
        n = self.step.n_movers
        movers = np.empty((*np.shape(p)[:-2], n, 3))
        movers[..., :2], movers[..., 2] = p, self.step.goal[:n, 2]
        return self.step.at(movers)

    def violated(self, p: Array) -> list[Label]:
        """Which spheres meet."""
        return self.function.violated(self.points(p))
