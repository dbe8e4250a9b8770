"""Packing of spheres that stand on the floor into a region: the procedure P_s of the paper for one region.

Heights are known, so spheres become discs: two spheres of radii r, s at heights y, z keep a clearance m iff the
planar distance of their centres is at least sqrt((r + s + m)^2 - (y - z)^2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from drake_ltl.planning.spheres import LEAST_MARGIN, REGION_MARGIN, Array

_PAD = 5e-4
"""Relaxation aims at this much more than is asked for [m], so that it gets there in finitely many steps."""

_TRIES = 32
_ITERATIONS = 150
_HURRY = 1.6
"""Each push is so much longer than what would just do: overlaps are resolved in fewer steps."""


@dataclass(frozen=True)
class Sphere:
    """One sphere of a group."""

    offset: tuple[float, float, float]
    """x and y from the group's origin, z from the floor [m]."""
    radius: float


@dataclass(frozen=True)
class Group:
    """Spheres that stand rigidly to each other, in one of some alternative ways, each of as many spheres.

    Spheres of one group are not kept apart: whether they may touch is settled when the alternatives are made.
    """

    alternatives: tuple[tuple[Sphere, ...], ...]


@dataclass(frozen=True)
class Packed:
    """Where the groups' origins stand, and which alternative each has taken."""

    origins: tuple[tuple[float, float], ...]
    """x and y from the region's axis [m]."""
    alternatives: tuple[int, ...]


def pack(groups: Sequence[Group], radius: float, height: float, *, seed: int = 0) -> Packed | None:
    """Places of the groups in a ball of `radius` [m] whose centre is at z = `height`; None if none were found.

    Spheres of different groups are LEAST_MARGIN apart, all are REGION_MARGIN inside. What is returned has been
    checked; None may be wrong where the ball is nearly full.
    """
    if not groups:
        return Packed((), ())
    choices = list(product(*(range(len(group.alternatives)) for group in groups)))
    if not choices:
        return None
    repeats = -(-_TRIES // len(choices))
    tries = _Tries(groups, [choice for choice in choices for _ in range(repeats)], radius, height)
    found = None if tries.hopeless else tries.relax(np.random.default_rng(seed))
    if found is None:
        return None
    origins, number = found
    return Packed(tuple((float(x), float(y)) for x, y in origins), choices[number // repeats])


class _Tries:
    """K tries at once to place S discs of U groups in a circle, P pairs of them apart."""

    def __init__(self, groups: Sequence[Group], choices: Sequence[tuple[int, ...]], radius: float, height: float):
        ways = [[s for g, c in zip(groups, choice, strict=True) for s in g.alternatives[c]] for choice in choices]
        owner = np.array([u for u, group in enumerate(groups) for _ in group.alternatives[0]])
        offsets = np.array([[sphere.offset for sphere in spheres] for spheres in ways])  # (K, S, 3)
        radii = np.array([[sphere.radius for sphere in spheres] for spheres in ways])  # (K, S)
        apart = [(a, b) for a, b in combinations(range(len(owner)), 2) if owner[a] != owner[b]]
        self._a, self._b = np.array(apart, dtype=int).reshape(-1, 2).T  # (P,)
        self._offsets = offsets[..., :2]
        self._distance = self._least_distance(radii, offsets[..., 2])  # (K, P)
        slant, rise = radius - radii - REGION_MARGIN, offsets[..., 2] - height
        self._fits_alone = (slant >= np.abs(rise)).all(axis=1)  # (K,)
        self._reach = np.sqrt(np.maximum(slant**2 - rise**2, 0.0))  # (K, S)
        self._member = np.eye(len(groups))[owner]  # (S, U)
        self._push = 0.5 * _HURRY * (self._member[self._a] - self._member[self._b])  # (P, U)

    def _least_distance(self, radii: Array, heights: Array) -> Array:
        slant = radii[:, self._a] + radii[:, self._b] + LEAST_MARGIN
        rise = heights[:, self._a] - heights[:, self._b]
        return np.sqrt(np.maximum(slant**2 - rise**2, 0.0))

    @property
    def hopeless(self) -> bool:
        """Whether in each try a sphere is too large for the region, or two are together."""
        room = self._reach[:, self._a] + self._reach[:, self._b]
        return not (self._fits_alone & (self._distance <= room).all(axis=1)).any()

    def relax(self, rng: np.random.Generator) -> tuple[Array, int] | None:
        """Push what overlaps apart and what sticks out back in, from random starts, until one try has room.

        Returns:
            Origins (U, 2) and the number of the try, or None if none has got there.
        """
        count, groups = len(self._offsets), self._member.shape[1]
        angle = rng.uniform(0.0, 2.0 * np.pi, (count, groups))
        distance = self._reach.max() * np.sqrt(rng.uniform(0.0, 1.0, (count, groups)))
        origins = np.stack([distance * np.cos(angle), distance * np.sin(angle)], axis=-1)
        for _ in range(_ITERATIONS):
            discs = self._offsets + np.einsum("su,kud->ksd", self._member, origins)
            gaps = discs[:, self._a] - discs[:, self._b]
            lengths = np.sqrt(np.einsum("kpd,kpd->kp", gaps, gaps))
            radial = np.sqrt(np.einsum("ksd,ksd->ks", discs, discs))
            apart = (lengths >= self._distance).all(axis=1)
            done = apart & (radial <= self._reach).all(axis=1) & self._fits_alone
            if done.any():
                number = int(np.argmax(done))
                return origins[number], number
            overlap = np.maximum(self._distance + _PAD - lengths, 0.0) / np.maximum(lengths, 1e-9)
            excess = np.maximum(radial - self._reach + _PAD, 0.0) / np.maximum(radial, 1e-9)
            origins += np.einsum("kp,kpd,pu->kud", overlap, gaps, self._push, optimize=True)
            origins -= np.einsum("ks,ksd,su->kud", excess, discs, self._member, optimize=True)
        return None
