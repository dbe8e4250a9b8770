"""Nobody hits who grasps the same object, nor the object: by the true geometry of their bodies, not by spheres.

Everybody else is kept apart by spheres. Around an object these give way to those who grasp it, so there distances are
worked out between the collision geometries themselves. Grippers against handles are exempt; they are to touch.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.verification.mechanics import Mechanics
from drake_ltl.verification.poses import rotations
from drake_ltl.verification.regions import radius
from drake_ltl.verification.roles import Roles
from drake_ltl.verification.spans import Span
from drake_ltl.verification.violations import Violation

SHARE = 0.1
"""The least distance of a pair is found to this share of itself; whether it is positive, for certain."""
RESOLUTION = 1e-4
"""... or to this [m], where it is less."""


@dataclass(frozen=True)
class Nearest:
    """Where two of one team come nearest to each other in a step."""

    who: tuple[str, str]
    """An agent, then another one or the object."""
    step: int
    time: float
    """[s]"""
    distance: float
    """Signed [m]; at most `multibody.pair_distance.FAR`."""


def inside_teams(
    recording: Recording, mechanics: Mechanics, spans: Sequence[Span], roles: Sequence[Roles]
) -> list[Nearest]:
    """For every step, all pairs among an object and those who hold, grasp or release it."""
    found = []
    for span, step in zip(spans, roles, strict=True):
        for a, b in _pairs(step):
            moved = _way(recording, a, b, span.samples)

            def distance(row: int, a: str = a, b: str = b, first: int = span.first) -> float:
                return mechanics.distance(a, b, first + row)

            row, least = nearest(distance, moved)
            found.append(Nearest((a, b), span.number, float(recording.time[span.first + row]), least))
    return found


def inside_team_violations(found: Sequence[Nearest]) -> Iterator[Violation]:
    """Who hits whom."""
    for pair in found:
        if pair.distance <= 0.0:
            what = f"{pair.who[0]} hits {pair.who[1]}"
            time, worst = pair.time, -pair.distance
            yield Violation("clearance", pair.who, what, time, pair.step, worst, time, "m")


def nearest(distance: Callable[[int], float], moved: np.ndarray) -> tuple[int, float]:
    """The sample at which a distance is least, and the distance.

    Between two samples a distance can fall by no more than the bodies move: `moved` (n,), by how much they can have
    come nearer since the first sample [m], rises. So only a few samples need be looked at (branch and bound).
    """
    last = len(moved) - 1
    values = {sample: distance(sample) for sample in dict.fromkeys((0, last))}
    best = min(values, key=values.__getitem__)

    def bound(i: int, k: int) -> float:
        return (values[i] + values[k] - (moved[k] - moved[i])) / 2.0

    waiting = [(bound(0, last), 0, last)]
    while waiting:
        lowest, i, k = heapq.heappop(waiting)
        if lowest >= values[best] - max(RESOLUTION, SHARE * values[best]) and (lowest > 0.0 or values[best] <= 0.0):
            break
        if k - i < 2:
            continue
        middle = (i + k) // 2
        values[middle] = distance(middle)
        best = min(best, middle, key=values.__getitem__)
        for pair in ((i, middle), (middle, k)):
            heapq.heappush(waiting, (bound(*pair), *pair))
    return best, values[best]


def _pairs(roles: Roles) -> Iterator[tuple[str, str]]:
    for obj in sorted({obj for _, obj in roles.exempt}):
        members = sorted(agent for agent, held in roles.exempt if held == obj)
        yield from ((agent, obj) for agent in members)
        yield from combinations(members, 2)


def _way(recording: Recording, agent: str, other: str, rows: slice) -> np.ndarray:
    """(n,) by how much the two can have come nearer since the first of some samples [m].

    Bases and objects move against each other; a joint moves no point of its agent by more than its turn times the
    diameter of the bounding sphere, nor by more than its way if it slides.
    """
    shifts = [np.diff(_origin(recording, name)[rows], axis=0) for name in (agent, other)]
    way = np.linalg.norm(shifts[0] - shifts[1], axis=1)
    for name in (agent, other):
        reach = radius(recording, name)
        if name in recording.agents:
            way += max(1.0, 2.0 * reach) * np.abs(np.diff(recording.q[name][rows, 2:], axis=0)).sum(axis=1)
        else:
            turned = rotations(recording.pose[name][rows])
            way += reach * (turned[1:] * turned[:-1].inv()).magnitude()
    return np.concatenate([[0.0], np.cumsum(way)])


def _origin(recording: Recording, name: str) -> np.ndarray:
    """(T, 3) of an agent's base, or of an object [m]."""
    if name in recording.agents:
        return np.pad(recording.q[name][:, :2], ((0, 0), (0, 1)))
    return recording.pose[name][:, 4:]
