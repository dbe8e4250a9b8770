"""What makes one placement better than another: short ways, no detours, room to grasp from all sides."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drake_ltl.planning.backjumping import Assignment, Cost
from drake_ltl.planning.places import Places, Quantity
from drake_ltl.planning.spheres import Array, norm
from drake_ltl.planning.stays import Stay

_DETOUR = 100.0
"""Cost of driving to the stand-off when it is time to grasp, rather than at once [m]: an extra phase of the step."""

_OFF_CENTRE = 4.0
"""Cost of each metre that an object to be grasped stands from its region's centre."""


def costs(places: Places) -> list[Cost]:
    """Lengths of all ways [m] and the like. Shortest ways of several agents do not cross."""
    timeline = places.stays.timeline
    found: list[Cost] = []
    for move, actions in enumerate(timeline.moves):
        after = timeline.after(move)
        for action in actions:
            if action.kind == "travel":
                agent = action.agents[0]
                found.append(_length(places.agent(agent, move), places.agent(agent, after)))
            elif action.kind == "transport":
                found.append(_length(places.object(action.object, move), places.object(action.object, after)))
            elif action.kind == "grasp":
                found += _approach(places, action.agents[0], move)
    return [*found, *_centring(places)]


def _length(start: Quantity, goal: Quantity) -> Cost:
    def value(values: Assignment) -> Array:
        return norm(start.value(values) - goal.value(values))

    return Cost(start.scope | goal.scope, value)


def _approach(places: Places, agent: str, move: int) -> Iterator[Cost]:
    after = places.stays.timeline.after(move)
    stand, hold = places.stays.of_agent(agent, move), places.stays.of_agent(agent, after)
    yield _length(places.agent(agent, move), places.standoff(hold, after))
    ready = places.at_standoff(stand, hold)
    yield Cost(ready.scope, lambda values: np.where(ready.value(values), 0.0, _DETOUR))


def _centring(places: Places) -> Iterator[Cost]:
    """An object stands near the centre if somebody will grasp it there."""
    for stay in places.stays.objects:
        if not stay.initial and _is_grasped(places, stay):
            place = places.object(stay.body, stay.times[0])
            centre = np.array(places.region(stay).centre)

            def value(values: Assignment, place: Quantity = place, centre: Array = centre) -> Array:
                return _OFF_CENTRE * norm(place.value(values) - centre)

            yield Cost(place.scope, value)


def _is_grasped(places: Places, stay: Stay) -> bool:
    moves = places.stays.timeline.moves
    return any(a.kind == "grasp" and a.object == stay.body for t in stay.times for a in moves[t])
