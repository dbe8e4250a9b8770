"""What a redundant arm (n > 6 joints) does besides its task: tau_0 of the paper, and why V falls with it.

The paper writes tau = J^T u + (I - J^T Jbar^T) tau_0 and leaves tau_0 open, to keep away from singularities and joint
limits. Here tau_0 is the force of a spring with some friction, `PostureSpring`,

    tau_0 = -grad h(q) - D qd,

with h >= 0 that vanishes, slope included, at the posture in which the arm grasped, grows beyond all bounds towards the
limits of joints and towards singularities, and does not depend on x and y of the base. It acts unprojected, because
then the Lyapunov function of the paper, extended by h, needs no further argument. With V = k psi + kinetic energy of
object and team (null-space motion included) + sum of h_i, welds doing no work, (10b) yields

    dV/dt = -v_O^T K_O v_O - sum_i qd_i^T D_i qd_i <= 0.

Projected, tau_0 would do the work qd_N^T tau_0 on the null-space motion qd_N, of any sign, and a heavy base would have
to be brought up to the speed of its gripper by that work alone, all of it a rise of V. Unprojected, the load drags the
base along by the spring. Nothing of the proof is lost: h is finite where an interval begins (0 where a step does), so
that k psi stays finite, and nothing collides; and where all is at rest, the rows of x and y of (1a) say c_i grad psi =
-f_i there, which adds up to grad psi = 0 in the plane: h takes nothing from where a load goes. At the goal all h_i
vanish, for the whole team has then only been shifted. `null_space_projector` is the paper's projection, for those who
want it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from drake_ltl.multibody.manipulability import log_manipulability_slope

EDGE = 0.999
"""Share of a joint's range beyond which its barrier goes on as a parabola: a number for every finite q."""
BARRIER = 0.5
"""Share of a joint's stiffness that is its barrier's, where it rests; the other half is a plain spring's."""
SHORTFALL = 0.5
"""Manipulability below this share of the reference's is pushed up again."""
SINGULARITY_WEIGHT = 2.0
"""[J] for each squared e-fold of manipulability below that."""


def null_space_projector(J: np.ndarray, B: np.ndarray) -> np.ndarray:
    """I - J^T Jbar^T (n, n), Jbar = B^-1 J^T (J B^-1 J^T)^-1: torques behind it do not accelerate the end-effector."""
    by_inertia = np.linalg.solve(B, J.T)
    return np.eye(len(B)) - J.T @ np.linalg.solve(J @ by_inertia, by_inertia.T)


@dataclass(frozen=True)
class PostureSpring:
    """h(q) and tau_0 = -grad h - D qd for one reference posture.

    Each joint has a plain spring of its `stiffness`. Where it has limits, half of that is taken by the barrier
    -log(1 - x^2), x in (-1, 1) over its range, less its tangent at the reference (a Bregman divergence: convex, zero
    with its slope there), scaled so that the stiffness at the reference stays the same.
    Manipulability counts as soon as it falls below SHORTFALL of the reference's.
    """

    reference: np.ndarray
    """q_ref (n,) [m, rad]."""
    stiffness: np.ndarray
    """(n,) [N/m, N m/rad]; zero for x and y."""
    damping: np.ndarray
    """Diagonal of D (n,) [N s/m, N m s/rad]; zero for x and y."""
    lower: np.ndarray
    """(n,), -inf without a limit."""
    upper: np.ndarray
    """(n,)"""
    manipulability: float
    """w at the reference."""

    def energy(self, q: np.ndarray, J: np.ndarray) -> float:
        """h(q) [J], for J = J(q) (6, n)."""
        spring = 0.5 * np.sum(self._plain * (q - self.reference) ** 2)
        x, x0 = self._normalised(q), self._rest
        barrier = np.sum(self._scale * (_barrier(x)[0] - _barrier(x0)[0] - self._slope_at_rest * (x - x0)))
        return float(spring + barrier + 0.5 * SINGULARITY_WEIGHT * self._shortfall(J) ** 2)

    def torque(self, q: np.ndarray, qd: np.ndarray, J: np.ndarray) -> np.ndarray:
        """tau_0 (n,) [N, N m]; of AutoDiffXd as well."""
        slope = self._plain * (q - self.reference)
        slope[self._limited] += self._scale / self._half * (_barrier(self._normalised(q))[1] - self._slope_at_rest)
        shortfall = self._shortfall(J)
        if shortfall > 0.0:
            slope = slope - SINGULARITY_WEIGHT * shortfall * log_manipulability_slope(J)
        return -slope - self.damping * qd

    def _normalised(self, q: np.ndarray) -> np.ndarray:
        """x of the joints with limits."""
        return (q[self._limited] - self._middle) / self._half

    @cached_property
    def _limited(self) -> np.ndarray:
        width = self.upper - self.lower
        return np.isfinite(width) & (width > 0.0) & (self.stiffness > 0.0)

    @cached_property
    def _plain(self) -> np.ndarray:
        """Stiffness (n,) of the plain springs."""
        return self.stiffness * np.where(self._limited, 1.0 - BARRIER, 1.0)

    @cached_property
    def _middle(self) -> np.ndarray:
        return 0.5 * (self.lower[self._limited] + self.upper[self._limited])

    @cached_property
    def _half(self) -> np.ndarray:
        return 0.5 * (self.upper[self._limited] - self.lower[self._limited])

    @cached_property
    def _rest(self) -> np.ndarray:
        """x of the reference."""
        return np.clip(self._normalised(self.reference), -EDGE, EDGE)

    @cached_property
    def _slope_at_rest(self) -> np.ndarray:
        return _barrier(self._rest)[1]

    @cached_property
    def _scale(self) -> np.ndarray:
        """Factor of each barrier [J]."""
        return BARRIER * self.stiffness[self._limited] * self._half**2 / _curvature(self._rest)

    def _shortfall(self, J: np.ndarray):
        """log of SHORTFALL w_ref / w, 0 where w is large enough."""
        log_w = 0.5 * _log_det(J @ J.T)
        short = np.log(SHORTFALL * self.manipulability) - log_w
        return short if short > 0.0 else 0.0 * short


def _barrier(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """-log(1 - x^2) and its slope; a parabola of the same value, slope and curvature beyond +-EDGE."""
    edge = np.where(x > 0.0, EDGE, -EDGE)
    inside = np.where(np.abs(x) < EDGE, x, edge)
    beyond = x - inside
    value, slope, curvature = -np.log(1.0 - inside**2), 2.0 * inside / (1.0 - inside**2), _curvature(inside)
    return value + slope * beyond + 0.5 * curvature * beyond**2, slope + curvature * beyond


def _curvature(x: np.ndarray) -> np.ndarray:
    return 2.0 * (1.0 + x**2) / (1.0 - x**2) ** 2


def _log_det(A: np.ndarray):
    """Of a positive definite matrix; by elimination, which AutoDiffXd can do too. Very negative where A is singular."""
    if A.dtype == float:
        return max(np.linalg.slogdet(A)[1], LEAST_LOG_DET)
    total = 0.0
    while len(A):
        total = total + np.log(A[0, 0])
        A = A[1:, 1:] - np.outer(A[1:, 0], A[0, 1:]) / A[0, 0]
    return total


LEAST_LOG_DET = -100.0
"""In place of -infinity."""
