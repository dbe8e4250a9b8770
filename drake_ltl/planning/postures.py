"""Arm postures along a plan: an agent keeps the posture it has until it goes to the stand-off of a grasp."""

from __future__ import annotations

from drake_ltl.planning.geometry import Geometry, turned_posture
from drake_ltl.planning.headings import Headings
from drake_ltl.planning.stays import Stay, Stays
from drake_ltl.scenario.starts import Starts

Source = Stay | str
"""What sets a posture: the option of a hold, or (by name) the posture at the start."""


class Postures:
    """The postures that each stand can have. `start` says which one each agent begins with."""

    def __init__(self, geometry: Geometry, start: Starts, stays: Stays, headings: Headings):
        self._geometry, self._start, self._stays, self._headings = geometry, start, stays, headings

    def sources(self, stand: Stay) -> tuple[Source, ...]:
        """What sets the posture of a stand. Several where the loop closes: then all must agree."""
        found: dict[Source, None] = {}
        seen: set[Stay] = set()
        waiting = [stand]
        while waiting:
            current = waiting.pop(0)
            if current in seen:
                continue
            seen.add(current)
            if current.initial:
                found[self._start.agents[current.body].posture] = None
            released = self._stays.released(current)
            if released and not current.initial:
                found[released[0][1]] = None  # whoever else comes here comes to that stand-off, and its posture
                continue
            waiting += [origin for _, origin in self._stays.entries(current) if origin.held is None]
        return tuple(found)

    def names(self, agent: str, source: Source) -> tuple[str, ...]:
        """The posture for each option of the hold, as its object is turned when the hold ends, or the one posture."""
        if isinstance(source, str):
            return (source,)
        end = self._stays.exit(source)
        turn = 0.0 if end is None else self._headings.turn(source.held, end[0])
        options = self._geometry.grasps.get((agent, source.held), ())
        return tuple(turned_posture(option.standoff_posture, turn) for option in options)

    def heights(self, agent: str, source: Source) -> tuple[float, ...]:
        """z [m] of the centre of the agent's sphere for each posture of `names`."""
        if isinstance(source, str):
            return (float(self._start.agents[agent].p_WC[2]),)
        postures = self._geometry.postures[agent]
        return tuple(float(postures[name][2]) for name in self.names(agent, source))
