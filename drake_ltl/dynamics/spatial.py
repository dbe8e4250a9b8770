"""The common shape of (1b), (2b) and (7): inertia, Coriolis matrix and gravity of something with one twist."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class SpatialDynamics:
    """M vdot + C v + g = the wrench that acts, for a twist v (6,) (rotational; translational) in W.

    C is such that dM/dt - 2 C is skew symmetric (Lemma 1); the product C v alone would not determine it.
    """

    M: np.ndarray
    """(6, 6)."""
    C: np.ndarray
    """(6, 6)."""
    g: np.ndarray
    """(6,) [N m; N], the wrench that balances gravity."""

    def wrench(self, vdot: np.ndarray, v: np.ndarray) -> np.ndarray:
        """M vdot + C v + g (6,) [N m; N]."""
        return self.M @ vdot + self.C @ v + self.g
