"""Which sets of binary relations can be realised at once: the relations of every level that a step needs.

A set of relations is realised where all its spheres touch. Most sets never are: nobody touches two bodies at once
that stand far apart. Sets are left out only if a proof says so, and every proof here holds for all positions of the
movers inside their balls:

1. distances: bounds on the distances of all points, tightened by the triangle inequality until they contradict
   each other or do not (triangle bound smoothing);
2. fixed points: one mover's centre lies on the spheres around all the fixed points that it touches;
3. packing: those who touch the same body are apart from each other, so its surface holds only so many.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, groupby

import numpy as np

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.navigation.relations import Array, Relations
from drake_ltl.planning.geometry import Vector3

MAX_RELATIONS = 4095
"""Relations of all levels; more take longer to evaluate than a controller has time."""
SLACK = 1e-6
"""Relative to the largest length: a contradiction smaller than this is no proof, it may be rounding."""
BATCH = 512
"""Candidates that are tested at once, to bound the memory."""

FixedPoints = tuple[tuple[int, Vector3], ...]
"""Index and position [m] of each point that never moves."""


@dataclass(frozen=True)
class RelationSets:
    """Relations of all levels over the first `n_apart` binary relations."""

    n_apart: int
    sets: tuple[tuple[int, ...], ...]
    """Indices of the binary relations in each, in increasing order; by level, then by index."""

    @property
    def levels(self) -> int:
        """n_L, the size of the largest set."""
        return len(self.sets[-1]) if self.sets else 0

    def of_level(self, level: int) -> tuple[tuple[int, ...], ...]:
        """All relations of one level."""
        return tuple(chosen for chosen in self.sets if len(chosen) == level)


def all_sets(n_apart: int) -> RelationSets:
    """All nonempty sets of `n_apart` binary relations.

    Raises:
        InvalidInputError: there are more than MAX_RELATIONS.
    """
    if 2**n_apart - 1 > MAX_RELATIONS:
        raise _too_many(f"{n_apart} binary relations have {2**n_apart - 1} relations over all levels")
    levels = range(1, n_apart + 1)
    return RelationSets(n_apart, tuple(chosen for k in levels for chosen in combinations(range(n_apart), k)))


@lru_cache(maxsize=32)
def realisable_sets(relations: Relations, fixed: FixedPoints) -> RelationSets:
    """All sets of the binary relations `relations.apart` but those that are proved never to be realised at once.

    Whatever part of a realisable set is realised with it, so sets are grown level by level out of those that are
    left, and the cost is bounded by MAX_RELATIONS.

    Args:
        relations: with the balls that movers are inside of.
        fixed: the points that never move; all others may be anywhere that `relations` allow.

    Raises:
        InvalidInputError: more than MAX_RELATIONS sets are left.
    """
    bounds = _Bounds(relations, dict(fixed))
    kept: list[tuple[int, ...]] = []
    level: list[tuple[int, ...]] = [(index,) for index in range(len(relations.apart))]
    while level:
        for start in range(0, len(level), BATCH):
            kept += bounds.possible(level[start : start + BATCH])
            if len(kept) > MAX_RELATIONS:
                what = f"more than {MAX_RELATIONS} relations over all levels may be realised"
                raise _too_many(f"{len(relations.apart)} binary relations: {what}")
        size = len(level[0])
        level = list(_grown([chosen for chosen in kept if len(chosen) == size]))
    return RelationSets(len(relations.apart), tuple(kept))


def number_of_factors(relations: Relations, lambda_: float, p: Array, n_movers: int) -> int:
    """Of which G is a product: with lambda = 0 one for each relation, else one for each that can be realised of every
    level, and one for each ball.

    Args:
        p: (P, 3) [m], of which all but the first `n_movers` stay for ever.

    Raises:
        InvalidInputError: as `realisable_sets`.
    """
    if lambda_ == 0.0:
        return len(relations)
    return len(realisable_sets(relations, fixed_points(p, n_movers)).sets) + len(relations.inside)


def _grown(sets: list[tuple[int, ...]]) -> Iterator[tuple[int, ...]]:
    """Sets with one member more, all of whose parts are among `sets` (of one size, in order)."""
    known = set(sets)
    for _, alike in groupby(sets, key=lambda chosen: chosen[:-1]):
        for first, second in combinations(alike, 2):
            union = (*first, second[-1])
            if all(part in known for part in combinations(union, len(first))):
                yield union


def _too_many(what: str) -> InvalidInputError:
    return InvalidInputError([Mistake("controller.lambda", what, "use lambda: 0, or fewer movers at once")])


class _Bounds:
    """What is known of all distances, whatever the movers do."""

    def __init__(self, relations: Relations, fixed: dict[int, Vector3]):
        self._relations, self._fixed = relations, fixed
        self._nodes = np.array([*fixed.values(), *(inside.centre for inside in relations.inside)]).reshape(-1, 3)
        self._fixed_node = {point: node for node, point in enumerate(fixed)}
        movers = [point for point in range(relations.n_points) if point not in fixed]
        self._node = self._fixed_node | {point: len(self._nodes) + i for i, point in enumerate(movers)}
        size = len(self._nodes) + len(movers)
        self._lower, self._upper = np.zeros((size, size)), np.full((size, size), np.inf)
        known = np.linalg.norm(self._nodes[:, None] - self._nodes, axis=-1)
        self._lower[: len(known), : len(known)] = self._upper[: len(known), : len(known)] = known
        np.fill_diagonal(self._upper, 0.0)
        self._ends = [(self._node[apart.a], self._node[apart.b]) for apart in relations.apart]
        for (a, b), apart in zip(self._ends, relations.apart, strict=True):
            self._lower[a, b] = self._lower[b, a] = max(self._lower[a, b], apart.radius)
        for centre, inside in enumerate(relations.inside, start=len(fixed)):
            a = self._node[inside.a]
            self._upper[a, centre] = self._upper[centre, a] = min(self._upper[a, centre], inside.radius)
        largest = max(known.max(initial=0.0), *(apart.radius for apart in relations.apart), 0.0)
        self._slack = SLACK * largest
        self._meets: dict[tuple[int, ...], bool] = {}

    def possible(self, candidates: list[tuple[int, ...]]) -> Iterator[tuple[int, ...]]:
        """Those of the candidates (of one size) that no proof excludes."""
        lower, feasible = self._smoothed(candidates)
        for index, chosen in enumerate(candidates):
            if feasible[index] and self._placed(chosen) and self._packed(chosen, lower[index]):
                yield chosen

    def _smoothed(self, candidates: list[tuple[int, ...]]) -> tuple[Array, Array]:
        """Lower bounds of all distances (C, m, m) if a candidate is realised, and whether they are below the upper."""
        lower = np.repeat(self._lower[None], len(candidates), axis=0)
        upper = np.repeat(self._upper[None], len(candidates), axis=0)
        ends = np.array([[self._ends[i] for i in chosen] for chosen in candidates])
        radii = np.array([[self._relations.apart[i].radius for i in chosen] for chosen in candidates])
        rows = np.arange(len(candidates))[:, None]
        for a, b in ((ends[..., 0], ends[..., 1]), (ends[..., 1], ends[..., 0])):
            upper[rows, a, b] = np.minimum(upper[rows, a, b], radii)
        for k in range(lower.shape[1]):
            np.minimum(upper, upper[:, :, k, None] + upper[:, None, k, :], out=upper)
        for k in range(lower.shape[1]):
            by_way_of_k = lower[:, :, k, None] - upper[:, k, None, :]
            np.maximum(lower, np.maximum(by_way_of_k, by_way_of_k.swapaxes(1, 2)), out=lower)
        return lower, (lower <= upper + self._slack).all(axis=(1, 2))

    def _placed(self, chosen: tuple[int, ...]) -> bool:
        """Whether each mover has a place from which it touches all the fixed points that it has to touch."""
        touched: dict[int, list[int]] = {}
        for index in chosen:
            apart = self._relations.apart[index]
            for mover, other in ((apart.a, apart.b), (apart.b, apart.a)):
                if mover not in self._fixed and other in self._fixed:
                    touched.setdefault(mover, []).append(index)
        return all(self._meet(tuple(indices)) for indices in touched.values() if len(indices) > 2)

    def _meet(self, indices: tuple[int, ...]) -> bool:
        if indices not in self._meets:
            pairs = [self._relations.apart[index] for index in indices]
            centres = np.array([self._fixed[pair.b if pair.b in self._fixed else pair.a] for pair in pairs])
            self._meets[indices] = spheres_meet(centres, np.array([pair.radius for pair in pairs]), self._slack)
        return self._meets[indices]

    def _packed(self, chosen: tuple[int, ...], lower: Array) -> bool:
        """Whether every body's surface has room for all that touch it."""
        touching: dict[int, dict[int, float]] = {}
        for index in chosen:
            a, b = self._ends[index]
            radius = self._relations.apart[index].radius
            touching.setdefault(a, {})[b] = touching.setdefault(b, {})[a] = radius
        for around in touching.values():
            if len(around) > 2:
                nodes = list(around)
                if not fit_around(np.array(list(around.values())), lower[np.ix_(nodes, nodes)] - self._slack):
                    return False
        return True


def spheres_meet(centres: Array, radii: Array, slack: float) -> bool:
    """False only if no point lies on all the spheres with `centres` (m, 3) and `radii` (m,).

    Differences of |x - c_i|^2 = r_i^2 are linear in x: the solution nearest to c_0 must not be farther than r_0.
    """
    c = centres[1:] - centres[0]
    right = 0.5 * (radii[0] ** 2 - radii[1:] ** 2 + (c**2).sum(axis=1))
    x = np.linalg.lstsq(c, right, rcond=1e-9)[0]
    lengths = np.linalg.norm(c, axis=1) + radii[0]
    return bool((np.abs(c @ x - right) <= slack * lengths).all() and np.linalg.norm(x) <= radii[0] + slack)


def fit_around(radii: Array, lower: Array) -> bool:
    """False only if points at distances `radii` (m,) from one point cannot all be `lower` (m, m) from each other.

    Seen from the middle two of them are theta_ij apart, cos theta_ij <= (r_i^2 + r_j^2 - l_ij^2) / (2 r_i r_j).
    The sum of all directions has a length, so m + 2 sum cos >= 0; and caps of half the angle to the next one do not
    overlap on a sphere, of which each covers (1 - cos) / 2.
    """
    product = np.maximum(radii[:, None] * radii, np.finfo(float).tiny)
    cosines = (radii[:, None] ** 2 + radii**2 - np.maximum(lower, 0.0) ** 2) / (2.0 * product)
    cosines = np.clip(cosines, -1.0, 1.0)
    np.fill_diagonal(cosines, -1.0)
    caps = 1.0 - np.cos(0.5 * np.arccos(cosines.max(axis=1)))
    np.fill_diagonal(cosines, 1.0)
    return bool(cosines.sum() >= -SLACK and caps.sum() <= 2.0 + SLACK)


def fixed_points(p: Array, n_movers: int) -> FixedPoints:
    """Every point of p (P, 3) but the first `n_movers`."""
    return tuple((index, _vector(p[index])) for index in range(n_movers, len(p)))


def _vector(p: Iterable[float]) -> Vector3:
    x, y, z = (float(coordinate) for coordinate in p)
    return x, y, z
