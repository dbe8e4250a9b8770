"""The damping of (10a) by a controller whose torques stay as they are for a time step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from pydrake.math import inv

from drake_ltl.dynamics.control_laws import growth_of_damping, speed_of

if TYPE_CHECKING:
    from drake_ltl.multibody.agent_model import AgentModel

BASE = slice(0, 2)
"""x and y among an agent's joints."""
MOST_DECAY = 1.0
"""Time step times K_jj / b_j, b_j what joint j moves, up to which the velocity before a step will do."""


@dataclass(frozen=True)
class HeldDamping:
    """K_z, and the velocity that it acts on.

    Torques that stay for a step do work on its way, which is time_step * w for the velocity w after it. With the
    velocity before it, K_z pushes back and forth as soon as time_step * K_z is above 2 B, and a start from rest in a
    steep place is not damped at all. With w, as an implicit Euler step has it,

        B (w - qd) = -time_step * (grad_q psi + K_z w),

    V falls by at least w^T (K_z - time_step / 2 * H) w * time_step, H the Hessian of psi on the way. For a time step
    that goes to zero both are (10a). Where K_z is small the velocity before will do, for which no inertia is needed.
    """

    K: np.ndarray
    """Diagonal (n,) [N s/m, N m s/rad], all positive."""
    speed_limit: float = np.inf
    """Beyond which K grows, see `growth_of_damping` [m/s]."""
    time_step: float = 0.0
    """For which torques stay [s]."""
    mass: float = np.inf
    """Of the whole agent [kg]."""
    decay: float = 0.0
    """Time step times the largest K_jj / b_j."""

    @staticmethod
    def of(model: AgentModel, K: np.ndarray, speed_limit: float, time_step: float) -> HeldDamping:
        """Of an agent; for torques that follow the state at once `time_step` is 0."""
        if time_step == 0.0:
            return HeldDamping(K, speed_limit)
        decay = time_step * float(np.max(K / model.least_inertia))
        return HeldDamping(K, speed_limit, time_step, model.mass, decay)

    def at(
        self, gradient: np.ndarray, qd: np.ndarray, inertia: Callable[[], np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        """The diagonal of K_z (n,), and the velocity that it acts on (n,).

        Args:
            gradient: grad_q psi (n,).
            qd: velocities before the step (n,).
            inertia: B(q) (n, n); not called if it is not needed.
        """
        push = self.time_step / self.mass  # of a force: what it is about to add to the speed
        speed = speed_of(qd[BASE]) + push * speed_of(gradient[BASE])
        if speed <= self.speed_limit and self.decay <= MOST_DECAY:
            return self.K, qd
        growth = growth_of_damping(speed, self.speed_limit)
        K = growth * self.K
        if self.decay * growth <= MOST_DECAY:
            return K, qd
        return K, velocity_after(inertia(), gradient, K, qd, self.time_step)


def velocity_after(B: np.ndarray, gradient: np.ndarray, K: np.ndarray, qd: np.ndarray, time_step: float) -> np.ndarray:
    """w (n,) with B (w - qd) = -time_step * (gradient + K w), of floats or of AutoDiffXd."""
    A, b = B + time_step * np.diag(K), B @ qd - time_step * gradient
    return inv(A) @ b if A.dtype == object else np.linalg.solve(A, b)
