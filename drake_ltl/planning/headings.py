"""Which way objects face at every state of a plan: a transport turns its object as the scenario says of its goal."""

from __future__ import annotations

from drake_ltl.planning.stays import Timeline
from drake_ltl.scenario.model import Scenario


class Headings:
    """Heading [rad] of every object at every state of a timeline."""

    def __init__(self, scenario: Scenario, timeline: Timeline):
        self._start = {obj.name: obj.heading for obj in scenario.objects}
        goals = {obj.name: obj.headings for obj in scenario.objects}
        self._at = {(name, 0): heading for name, heading in self._start.items()}
        closing = {}
        for move in range(len(timeline.moves)):
            after = timeline.after(move)
            for name in timeline.objects:
                heading, transport = self._at[name, move], timeline.transport(name, move)
                if transport is not None:
                    heading = goals[name].get(transport.goal, heading)
                if after > move:
                    self._at[name, after] = heading
                else:
                    closing[name] = heading == self._at[name, after]
        self.closing = closing
        """object -> whether the loop leads back to the heading with which it began."""

    def at(self, obj: str, time: int) -> float:
        """At a state."""
        return self._at[obj, time]

    def turn(self, obj: str, time: int) -> float:
        """What has been turned since the start [rad]."""
        return self._at[obj, time] - self._start[obj]
