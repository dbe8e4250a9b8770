"""Whether agents that stand elsewhere in a region can get to the stand-offs from which they grasp.

They may not leave the region meanwhile, and a region full of bodies has no room to pass. What is asked is sufficient,
not necessary: in some order, one after the other, each goes around its object in an arc, from the distance at which
it stands to that of its stand-off, clear of all others as they stand then.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from drake_ltl.planning.backjumping import Assignment, Constraint
from drake_ltl.planning.places import Places, Quantity
from drake_ltl.planning.plan import Action
from drake_ltl.planning.spheres import Array, norm

SAMPLES = np.linspace(0.0, 1.0, 18)[1:-1]
"""Of an arc; its ends are checked as states are."""
CLEARANCE = 0.02
"""On the way [m]."""
MOST_IN_TURN = 3
"""With more agents on their way at once, one order alone is tried."""


def passage_constraints(places: Places, move: int) -> Iterator[tuple[object, Constraint]]:
    """One for each region in which agents grasp in this move."""
    grasps: dict[str, list[Action]] = {}
    for action in places.stays.timeline.moves[move]:
        if action.kind == "grasp":
            grasps.setdefault(action.start, []).append(action)
    for region, actions in grasps.items():
        yield ("passage", region, move), _constraint(places, move, region, actions)


@dataclass(frozen=True)
class _Walker:
    """An agent that grasps, from where it stands to its stand-off around its object."""

    radius: float
    start: Quantity
    goal: Quantity
    around: Quantity
    ready: Quantity
    """Mask: it stands at its stand-off already."""

    @property
    def scope(self) -> frozenset[int]:
        return self.start.scope | self.goal.scope | self.around.scope | self.ready.scope


def _constraint(places: Places, move: int, region: str, actions: list[Action]) -> Constraint:
    walkers = [_walker(places, move, action) for action in actions]
    others = _others(places, move, region, actions)
    centre, room = np.array(places.regions[region].centre), places.regions[region].radius
    orders = list(permutations(range(len(walkers)))) if len(walkers) <= MOST_IN_TURN else [tuple(range(len(walkers)))]

    def slack(values: Assignment) -> Array:
        return np.max([in_turn(order, values) for order in orders], axis=0)

    def in_turn(order: tuple[int, ...], values: Assignment) -> Array:
        least = np.array(np.inf)
        for turn, index in enumerate(order):
            walker = walkers[index]
            standing = [(walkers[i].goal, walkers[i].radius) for i in order[:turn]]
            standing += [(walkers[i].start, walkers[i].radius) for i in order[turn + 1 :]]
            gap = np.max([arc(walker, side, standing + others, values) for side in (1.0, -1.0)], axis=0)
            least = np.minimum(least, np.where(walker.ready.value(values), np.inf, gap))
        return least

    def arc(walker: _Walker, side: float, standing: list[tuple[Quantity, float]], values: Assignment) -> Array:
        way = _arc(*(q.value(values) for q in (walker.start, walker.goal, walker.around)), side)
        gap = (room - walker.radius - norm(way - centre)).min(axis=-1)
        for body, radius in standing:
            apart = norm(way - np.asarray(body.value(values))[..., None, :]) - (walker.radius + radius)
            gap = np.minimum(gap, apart.min(axis=-1))
        return gap - CLEARANCE

    names = ", ".join(action.agents[0] for action in actions)
    scope = frozenset().union(*(walker.scope for walker in walkers), *(body.scope for body, _ in others))
    bodies = frozenset(action.agents[0] for action in actions) | {action.object for action in actions}
    text = f"{names} could not get to where they grasp from, within {region}"
    return Constraint(scope, slack, move, text, region, frozenset(filter(None, bodies)), spacing=False)


def _walker(places: Places, move: int, action: Action) -> _Walker:
    agent, after = action.agents[0], places.stays.timeline.after(move)
    hold = places.stays.of_agent(agent, after)
    return _Walker(
        places.geometry.agent_radius[agent],
        places.agent(agent, move),
        places.standoff(hold, after),
        places.object(hold.held, move),
        places.at_standoff(places.stays.of_agent(agent, move), hold),
    )


def _others(places: Places, move: int, region: str, actions: list[Action]) -> list[tuple[Quantity, float]]:
    """All that stands in the region and stays there: who leaves goes first, who comes comes last."""
    timeline, geometry = places.stays.timeline, places.geometry
    moving = {
        name for action in timeline.moves[move] if action.kind in ("travel", "transport") for name in action.agents
    }
    moving |= {action.object for action in timeline.moves[move] if action.kind == "transport"}
    moving |= {action.agents[0] for action in actions} | {action.object for action in actions}
    here = [name for name in (*timeline.agents, *timeline.objects) if timeline.region(name, move) == region]
    radius = dict(geometry.agent_radius) | dict(geometry.object_radius)
    at = {name: places.agent if name in timeline.agents else places.object for name in here}
    return [(at[name](name, move), radius[name]) for name in here if name not in moving]


def _arc(start: Array, goal: Array, around: Array, side: float) -> Array:
    """Points (..., samples, 3) of a spiral from start to goal (..., 3) around a point, to the left for side > 0."""
    start, goal, around = np.broadcast_arrays(start, goal, around)
    a, b = start - around, goal - around
    from_angle = np.arctan2(a[..., 1], a[..., 0])
    turn = side * np.mod(side * (np.arctan2(b[..., 1], b[..., 0]) - from_angle), 2.0 * np.pi)
    angle = from_angle[..., None] + SAMPLES * turn[..., None]
    far, near = np.hypot(a[..., 0], a[..., 1])[..., None], np.hypot(b[..., 0], b[..., 1])[..., None]
    distance = far + SAMPLES * (near - far)
    height = a[..., 2:] + SAMPLES * (b[..., 2:] - a[..., 2:])
    return around[..., None, :] + np.stack([distance * np.cos(angle), distance * np.sin(angle), height], axis=-1)
