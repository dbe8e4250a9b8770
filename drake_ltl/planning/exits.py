"""Whether movers get out of where they start and into where they arrive, among all that stands there meanwhile.

Discs that a mover's centre must keep out of shut it in if they form a ring around it: a cycle in which each overlaps
the next, and that goes around the centre. In the plane that is all there is to it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from drake_ltl.planning.backjumping import Assignment, Constraint
from drake_ltl.planning.places import Places, Quantity
from drake_ltl.planning.plan import Action
from drake_ltl.planning.spheres import LEAST_MARGIN, Array

MOST_BODIES = 10
"""With more in a region no rings are looked for: it takes long, and regions for so many have room."""

Ball = tuple[Quantity, float]
"""Centre and radius [m]."""


def exit_constraints(places: Places, move: int) -> Iterator[tuple[object, Constraint]]:
    """One for each mover of a move and each region, of the two between which it moves, that others could shut."""
    timeline = places.stays.timeline
    actions = [action for action in timeline.moves[move] if action.kind in ("travel", "transport")]
    moving = {name for action in timeline.moves[move] if action.kind == "grasp" for name in action.agents}
    moving |= {name for action in actions for name in (*action.agents, action.object)}
    for action in actions:
        for time, region in ((move, action.start), (timeline.after(move), action.goal)):
            standing = _standing(places, move, region, moving)
            if 3 <= len(standing) <= MOST_BODIES and action.start != action.goal:
                yield ("exit", action, region, move), _constraint(places, action, standing, time, region, move)


def _constraint(
    places: Places, action: Action, standing: Sequence[Ball], time: int, region: str, move: int
) -> Constraint:
    mover, radius, name = _mover(places, action, time)
    scope = mover.scope.union(*(centre.scope for centre, _ in standing))
    margin = LEAST_MARGIN if scope else 0.0  # what is given may be as tight as it is

    def slack(values: Assignment) -> Array:
        p = np.asarray(mover.value(values))
        centres = [np.asarray(centre.value(values)) for centre, _ in standing]
        keep_out = [
            np.sqrt(np.maximum((radius + r + margin) ** 2 - (c[..., 2] - p[..., 2]) ** 2, 0.0))
            for c, (_, r) in zip(centres, standing, strict=True)
        ]
        return way_out(p[..., :2], [c[..., :2] for c in centres], keep_out)

    verb = "out of" if time == move else "into"
    text = f"{name} could not get {verb} {region} between what stands there"
    return Constraint(scope, slack, move, text, region, frozenset(action.agents), spacing=False)


def way_out(p: Array, centres: Sequence[Array], radii: Sequence[Array]) -> Array:
    """Width of the widest gap (...) [m] in the ring of discs that shuts a point (..., 2) in most tightly.

    Negative if some ring has none, inf without a ring. Discs (..., 2) with radii (...) do not contain the point.

    A closed walk from disc to disc goes around the point if it crosses a ray from there an odd number of times. So
    every disc is there twice, for even and odd; what leads from one to the other is found as Floyd and Warshall do.
    """
    shape = np.broadcast_shapes(p.shape[:-1], *(c.shape[:-1] for c in centres), *(r.shape for r in radii))
    centre = np.stack([np.broadcast_to(c, (*shape, 2)) for c in centres])
    radius = np.stack([np.broadcast_to(r, shape) for r in radii])
    bearing = np.arctan2((centre - p)[..., 1], (centre - p)[..., 0])
    gap = np.linalg.norm(centre[:, None] - centre[None], axis=-1) - (radius[:, None] + radius[None])
    crosses = np.abs(bearing[:, None] - bearing[None]) > np.pi
    even, odd = np.where(crosses, np.inf, gap), np.where(crosses, gap, np.inf)
    widest = np.concatenate([np.concatenate([even, odd], axis=1), np.concatenate([odd, even], axis=1)])
    for via in range(len(widest)):
        widest = np.minimum(widest, np.maximum(widest[:, via, None], widest[None, via, :]))
    count = len(centre)
    return np.min([widest[k, count + k] for k in range(count)], axis=0)


def _mover(places: Places, action: Action, time: int) -> tuple[Quantity, float, str]:
    if action.kind == "travel":
        (agent,) = action.agents
        return places.agent(agent, time), places.geometry.agent_radius[agent], agent
    radius = places.geometry.team_radius[action.object]
    return places.object(action.object, time), radius, f"{action.object} with {', '.join(action.agents)}"


def _standing(places: Places, move: int, region: str, moving: set[str | None]) -> list[Ball]:
    """What is in a region and does not leave it in the move."""
    timeline, geometry = places.stays.timeline, places.geometry
    balls = [
        (places.agent(name, move), geometry.agent_radius[name])
        for name in timeline.agents
        if name not in moving and timeline.region(name, move) == region
    ]
    return balls + [
        (places.object(name, move), geometry.object_radius[name])
        for name in timeline.objects
        if name not in moving and timeline.region(name, move) == region
    ]
