"""How far apart the bodies are kept, and what a ball on the floor leaves of a region."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drake_ltl.scenario.model import Region

Array = NDArray[np.float64]

MARGINS = (0.10, 0.05)
"""Clearance between bodies [m], the first that works. The barrier of a navigation function is weak, its goals are
reached to within centimetres: bodies that may touch at their goals would."""

LEAST_MARGIN = MARGINS[-1]
"""Clearance of pairs whose distance the way of grasping fixes [m]: partners around one object, and an agent that
waits to grasp an object or has just released it. No choice of place can widen these."""

REGION_MARGIN = 0.05
"""Clearance between a body and the boundary of the region it must be inside of [m]: more than the tolerance with
which goals are reached."""

GOOD_SPACING = 0.5
"""Clearance beyond which more room is of no use to the navigation [m]."""

_RING_SPACING = 0.6
"""Distance of circles of places to choose from [m]."""


def norm(vectors: Array) -> Array:
    """Euclidean lengths (...) of vectors (..., 3); several times faster than `numpy.linalg.norm` when small."""
    return np.sqrt(np.einsum("...i,...i->...", vectors, vectors))


def planar_reach(region: Region, radius: float, height: float) -> float:
    """How far from the region's axis the centre of a sphere at z = `height` may stand, with margin [m].

    Negative if the sphere does not fit at all.
    """
    slant = region.radius - radius - REGION_MARGIN
    rise = height - region.centre[2]
    return math.sqrt(slant**2 - rise**2) if slant >= abs(rise) else -1.0


def rings(reach: float, outermost: int) -> Array:
    """Points (n, 2) on concentric circles about the origin, from the radius `reach` [m] inwards, and the origin.

    The outermost circle has `outermost` points: with 60, up to six bodies can stand evenly along the rim, which
    is how they fit most tightly.
    """
    count = min(max(math.ceil(reach / _RING_SPACING), 3), 8)
    circles = []
    for ring in range(count):
        share = 1.0 - ring / count
        points = max(6 * round(outermost * share / 6.0), 6)
        angles = 2.0 * np.pi * np.arange(points) / points
        circles.append(reach * share * np.column_stack([np.cos(angles), np.sin(angles)]))
    return np.vstack([*circles, np.zeros((1, 2))])
