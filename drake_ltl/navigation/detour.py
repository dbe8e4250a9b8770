"""A way around static spheres for one mover, in the plane: what is asked when a gradient field leads nowhere."""

from __future__ import annotations

from itertools import combinations, product
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from drake_ltl.navigation.relations import Array
from drake_ltl.navigation.step import StepRelations

SPACING = 0.2
"""Of the lattice on which ways are sought [m]."""
IN_SIGHT = 1.2
"""So far from the ends of a way and from middles of gaps the lattice is entered [m]."""
NARROW = 0.8
"""A gap of less is sought by its middle [m]."""
CLEARANCES = (0.3, 0.1, 0.04)
"""Distance that a way keeps from everything [m], the first for which there is one."""
RUN_UP_LENGTHS = (0.35, 0.7, 1.4)
"""Distances from the goal at which a run-up may begin [m], the first at which there is room: the shorter, the slower
is the mover when it arrives."""
RUN_UP_DIRECTIONS = 24
"""Directions from the goal in which it is sought."""


def detour(step: StepRelations) -> list[tuple[float, float]] | None:
    """Way points (x, y) [m] of a short way from the start to the goal of the step's only mover, the goal excluded.

    Between way points the straight line is clear, and at each of them the mover could come to stand. The sphere of an
    arm that is stuck may be higher than it will be at its goal: obstacles count at whichever of the two heights leaves
    less room. None if there is no way at any of the clearances.

    Raises:
        ValueError: more than one mover.
    """
    if step.n_movers != 1:
        raise ValueError(f"a detour is for one mover, not for {step.n_movers}")
    for clearance in CLEARANCES:
        scene = Scene(step, clearance)
        way = scene.way()
        if way is not None:
            return way
    return None


def run_up(step: StepRelations) -> list[tuple[float, float]]:
    """A way point (x, y) [m] in the open from which the step's only mover can make for its goal straight; none if
    there is none.

    For a mover that has come close and stuck: squeezed between what it must keep clear of and its goal, its arm gives
    way, and there is no way downhill from there. With room around it the arm comes back to its posture first.
    """
    scene = Scene(step, CLEARANCES[0])
    angles = np.linspace(0.0, 2.0 * np.pi, RUN_UP_DIRECTIONS, endpoint=False)
    around = np.column_stack([np.cos(angles), np.sin(angles)])
    for length in RUN_UP_LENGTHS:
        points = scene.goal[:2] + length * around
        points = points[scene.stands(points)]
        open_ = [p for p in points if scene.room(p) > 0.0 and scene.straight(scene.start[:2], p)]
        if open_:
            x, y = max(open_, key=scene.room)
            return [(float(x), float(y))]
    return []


def arrival_order(goals: Array) -> list[int]:
    """In which order movers should arrive one after another at `goals` (n, 3) [m]: innermost first.

    Whoever has arrived stands in the way of the others, the less the farther from the middle.
    """
    return [int(index) for index in np.argsort(np.linalg.norm(goals - goals.mean(axis=0), axis=1), kind="stable")]


_Disc = tuple[Array, float]
"""Centre (2,) and radius [m]."""


class Tree(NamedTuple):
    """Shortest ways from the start."""

    nodes: Array
    """(m, 2) [m], the start first."""
    distances: Array
    """Of each node (m,) [m], inf where no way leads."""
    before: Array
    """The node before each on its way (m,)."""


class Scene:
    """Discs to keep out of and discs to stay inside of, around one mover."""

    def __init__(self, step: StepRelations, clearance: float):
        self.start, self.goal = step.start[0], step.goal[0]
        discs, bounds = self._flat(step, clearance)
        self._discs = [(centre, min(radius, *self._ends(centre))) for centre, radius in discs]
        self._bounds = [(centre, max(radius, *self._ends(centre))) for centre, radius in bounds]
        self._standing = self._flat(step, CLEARANCES[-1])

    def _flat(self, step: StepRelations, clearance: float) -> tuple[list[_Disc], list[_Disc]]:
        """Balls cut at the heights of the mover's start and goal, the worse of both."""

        def cut(ball: Array, radius: float) -> list[float]:
            heights = (ball[2] - self.start[2], ball[2] - self.goal[2])
            return [float(np.sqrt(max(0.0, max(0.0, radius) ** 2 - z * z))) for z in heights]

        apart = [(step.start[pair.b], pair.radius + clearance) for pair in step.relations.apart]
        inside = [(np.asarray(ball.centre), ball.radius - clearance) for ball in step.relations.inside]
        return (
            [(centre[:2], max(cut(centre, radius))) for centre, radius in apart],
            [(centre[:2], min(cut(centre, radius))) for centre, radius in inside],
        )

    def _ends(self, centre: Array) -> list[float]:
        """Distances of the two ends of the way, which never count as blocked [m]."""
        return [float(np.linalg.norm(end[:2] - centre)) for end in (self.start, self.goal)]

    def stands(self, points: Array) -> Array:
        """Whether the mover could come to stand at each of the points (n, 2) as it will at its goal (n,)."""
        return _is_clear(points, *self._standing)

    def free(self, points: Array) -> Array:
        """Whether each of the points (n, 2) is clear (n,)."""
        return _is_clear(points, self._discs, self._bounds)

    def room(self, point: Array) -> float:
        """Distance [m] of a point (2,) from all that it must be clear of."""
        outside = [np.linalg.norm(point - centre) - radius for centre, radius in self._discs]
        inside = [radius - np.linalg.norm(point - centre) for centre, radius in self._bounds]
        return float(min(outside + inside))

    def straight(self, a: Array, b: Array) -> bool:
        """Whether the straight line from a to b (2,) is clear."""
        samples = max(2, int(np.linalg.norm(b - a) / (SPACING / 4)))
        return bool(self.free(a + np.linspace(0.0, 1.0, samples)[:, None] * (b - a)).all())

    def way(self) -> list[tuple[float, float]] | None:
        """The shortest way on the lattice, shortened to corners that see each other, its ends excluded."""
        tree = self.tree()
        return self.corners(tree, _GOAL)[:-1] if np.isfinite(tree.distances[_GOAL]) else None

    def tree(self) -> Tree:
        """Shortest ways from the start to everywhere."""
        ids, nodes = self._lattice()
        distances, before = dijkstra(self._edges(ids, nodes), indices=_START, return_predecessors=True)
        return Tree(nodes, distances, before)

    def corners(self, tree: Tree, end: int) -> list[tuple[float, float]]:
        """Of the way to a node that can be reached: points that see each other, the start excluded."""
        path = [end]
        while path[-1] != _START:
            path.append(int(tree.before[path[-1]]))
        corners = tree.nodes[path[::-1]]
        kept = [0]
        while kept[-1] != len(corners) - 1:
            here = kept[-1]
            ahead = range(len(corners) - 1, here, -1)
            kept.append(next((i for i in ahead if self.straight(corners[here], corners[i])), here + 1))
        return [(float(x), float(y)) for x, y in corners[kept[1:]]]

    def _lattice(self) -> tuple[Array, Array]:
        """Square lattice over the tightest bound: number of each node (n, n), -1 where blocked; nodes (m, 2).

        The start, the goal and the middles of narrow gaps come first and are not on the lattice, which may miss these.
        """
        centre, radius = min(self._bounds, key=lambda bound: bound[1])
        ticks = np.arange(-radius, radius + SPACING, SPACING)
        points = centre + np.stack(np.meshgrid(ticks, ticks, indexing="ij"), axis=-1).reshape(-1, 2)
        free = self.free(points) & self.stands(points)  # way points are goals of navigation functions
        first = np.vstack([self.start[:2], self.goal[:2], *self._gaps()])
        ids = np.full(len(points), -1)
        ids[free] = len(first) + np.arange(free.sum())
        return ids.reshape(len(ticks), len(ticks)), np.vstack([first, points[free]])

    def _gaps(self) -> list[Array]:
        """Middles (2,) of what two discs, or a disc and a bound, leave between them where that is narrow."""
        middles = []
        for (a, r), (b, s) in combinations(self._discs, 2):
            apart = float(np.linalg.norm(b - a))
            if 0.0 <= apart - r - s < NARROW:
                middles.append(a + (b - a) * (r + apart - s) / (2.0 * apart))
        for (a, r), (b, s) in product(self._discs, self._bounds):
            apart = float(np.linalg.norm(a - b))
            if 0.0 <= s - apart - r < NARROW and apart > 0.0:
                middles.append(b + (a - b) * (apart + r + s) / (2.0 * apart))
        points = np.array(middles).reshape(-1, 2)
        return list(points[self.free(points) & self.stands(points)])

    def _edges(self, ids: Array, nodes: Array) -> csr_array:
        """Between lattice points up to a knight's move apart, and from all others to the points near them."""
        rows, columns = [], []
        for dx, dy in _MOVES:
            here = ids[max(0, -dx) : ids.shape[0] - max(0, dx), max(0, -dy) : ids.shape[1] - max(0, dy)]
            there = ids[max(0, dx) : ids.shape[0] + min(0, dx), max(0, dy) : ids.shape[1] + min(0, dy)]
            both = (here >= 0) & (there >= 0)
            rows.append(here[both])
            columns.append(there[both])
        for end in range(len(nodes) - int((ids >= 0).sum())):
            gaps = np.linalg.norm(nodes - nodes[end], axis=1)
            near = [i for i in np.flatnonzero(gaps < IN_SIGHT) if i != end and self.straight(nodes[end], nodes[i])]
            rows.append(np.full(len(near), end))
            columns.append(np.array(near, dtype=int))
        row, column = np.concatenate(rows), np.concatenate(columns)
        lengths = np.linalg.norm(nodes[row] - nodes[column], axis=1)
        graph = csr_array((lengths, (row, column)), shape=(len(nodes), len(nodes)))
        return graph.maximum(graph.T)


def _is_clear(points: Array, discs: list[_Disc], bounds: list[_Disc]) -> Array:
    clear = np.ones(len(points), dtype=bool)
    for centre, radius in discs:
        clear &= ((points - centre) ** 2).sum(axis=1) >= (radius - 1e-9) ** 2
    for centre, radius in bounds:
        clear &= ((points - centre) ** 2).sum(axis=1) <= (radius + 1e-9) ** 2
    return clear


_START, _GOAL = 0, 1
_MOVES = [move for move in product(range(-2, 3), repeat=2) if np.gcd(*move) == 1]
