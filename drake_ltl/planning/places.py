"""Where every stay may be: the unknowns of a placement, and all positions as functions of them.

Three kinds of unknown: the place of an object for one of its stays, the grasp option of a hold, and the place of
an agent that travels to a region. All else follows: who holds stands at p_OoC_grasp of its option from its object,
who has just released and who is about to approach at p_OoC_standoff.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from drake_ltl.planning.backjumping import Assignment
from drake_ltl.planning.geometry import Geometry, GraspOption
from drake_ltl.planning.headings import Headings
from drake_ltl.planning.postures import Postures, Source
from drake_ltl.planning.spheres import Array, planar_reach, rings
from drake_ltl.planning.stays import Stay, Stays
from drake_ltl.scenario.model import Region, Scenario
from drake_ltl.scenario.starts import Starts

AT_STANDOFF = 0
"""Value of a stand's unknown that means the stand-off of the grasp that comes next, where there is one."""


@dataclass(frozen=True)
class Quantity:
    """An array as a function of some unknowns: positions (..., 3) in W [m], masks or numbers (...)."""

    scope: frozenset[int]
    value: Callable[[Assignment], Array]


def constant(value: object) -> Quantity:
    """What depends on no unknown."""
    array = np.asarray(value)
    return Quantity(frozenset(), lambda values: array)


class Places:
    """The unknowns of a placement, numbered in the order of time, and what follows from them.

    `start` says where all bodies are given at the first state.
    """

    def __init__(self, scenario: Scenario, geometry: Geometry, start: Starts, stays: Stays):
        self.geometry, self.start, self.stays = geometry, start, stays
        self.regions: Mapping[str, Region] = {region.name: region for region in scenario.regions}
        self.headings = Headings(scenario, stays.timeline)
        self.postures = Postures(geometry, start, stays, self.headings)
        unknowns = self._in_order_of_time()
        self._number = {stay: number for number, stay in enumerate(unknowns)}
        self._tables = {stay: self._table(stay) for stay in unknowns if stay.held is None}
        self.sizes = [len(self.options(s)) if s.held else len(self._tables[s]) for s in unknowns]
        self._cache: dict[object, Quantity] = {}

    def chosen(self, stay: Stay) -> Quantity:
        """The value of a stay's own unknown."""
        number = self._number[stay]
        return Quantity(frozenset({number}), lambda values: np.asarray(values[number]))

    def travels(self, stand: Stay) -> bool:
        """Whether the place of a stand is free to choose."""
        return not stand.initial and not self.stays.released(stand)

    def region(self, stay: Stay) -> Region:
        """Where a stand, or an object, stays."""
        return self.regions[self.stays.region(stay)]

    def options(self, hold: Stay) -> Sequence[GraspOption]:
        """The ways of grasping that a hold can choose from."""
        return self.geometry.grasps.get((hold.body, hold.held), ())

    def option(self, hold: Stay, values: Assignment, time: int) -> GraspOption:
        """The one it has chosen, as its object is turned at a state."""
        return self.options(hold)[values[self._number[hold]]].turned(self.headings.turn(hold.held, time))

    # ---- positions

    def object(self, name: str, time: int) -> Quantity:
        """Origin Oo of an object at a state."""
        stay = self.stays.of_object(name, time)
        return self._once(stay, lambda: self._lookup(stay, self._tables[stay]))

    def hold(self, hold: Stay, time: int) -> Quantity:
        """Centre of an agent that holds, where its object is at a state."""
        return self._around(hold, time, "p_OoC_grasp")

    def standoff(self, hold: Stay, time: int) -> Quantity:
        """Centre of an agent at the stand-off of a hold's option, where its object is at a state."""
        return self._around(hold, time, "p_OoC_standoff")

    def agent(self, name: str, time: int) -> Quantity:
        """Centre of an agent at a state."""
        stay = self.stays.of_agent(name, time)
        return self.hold(stay, time) if stay.held else self._once(stay, lambda: self._stand(stay))

    def at_standoff(self, stand: Stay, hold: Stay) -> Quantity:
        """Mask: whether a stand is already where the agent will approach its next hold from."""
        if self.travels(stand):
            return self._direct(stand) if self.stays.approaches(stand) == hold else constant(False)
        released = self.stays.released(stand)
        if stand.initial or self.stays.approaches(stand) != hold or released[0][1].held != hold.held:
            return constant(False)
        a, b = self.chosen(released[0][1]), self.chosen(hold)
        return Quantity(a.scope | b.scope, lambda values: a.value(values) == b.value(values))

    def reach_radius(self, hold: Stay) -> Quantity:
        """Radius [m] of two spheres, at the stand-off and at the grasp, that cover the way between them.

        A capsule of radius r about an axis of length 2 h lies in balls of radius sqrt(r^2 + h^2) at its ends.
        """
        ends = [np.subtract(option.p_OoC_standoff, option.p_OoC_grasp) for option in self.options(hold)]
        half = np.array([np.linalg.norm(end) / 2.0 for end in ends])
        return self._lookup(hold, np.hypot(self.geometry.agent_radius[hold.body], half))

    def posture(self, stay: Stay, values: Assignment, time: int) -> str:
        """Arm posture of an agent at a state of a stay, once all unknowns are set."""
        if stay.held:
            return self.option(stay, values, time).standoff_posture
        approaches = self.stays.approaches(stay)
        if self.travels(stay) and approaches and values[self._number[stay]] == AT_STANDOFF:
            return self.option(approaches, values, time).standoff_posture
        source = self.postures.sources(stay)[0]
        names = self.postures.names(stay.body, source)
        return names[values[self._number[source]]] if isinstance(source, Stay) else names[0]

    def by_source(self, source: Source, table: Sequence[object]) -> Quantity:
        """An entry of a table with one row for each posture that the source can set."""
        array = np.asarray(table)
        return self._lookup(source, array) if isinstance(source, Stay) else constant(array[0])

    # ---- how they are made

    def _once(self, key: object, make: Callable[[], Quantity]) -> Quantity:
        if key not in self._cache:
            self._cache[key] = make()
        return self._cache[key]

    def _lookup(self, stay: Stay, table: Array) -> Quantity:
        number = self._number[stay]
        return Quantity(frozenset({number}), lambda values: table[values[number]])

    def _around(self, hold: Stay, time: int, kind: str) -> Quantity:
        """`kind` of a GraspOption from the object's origin; an object is turned by nothing while it stays."""

        def make() -> Quantity:
            origin, turn = self.object(hold.held, time), self.headings.turn(hold.held, time)
            offsets = [getattr(option.turned(turn), kind) for option in self.options(hold)]
            offset = self._lookup(hold, np.array(offsets, dtype=float))
            return Quantity(origin.scope | offset.scope, lambda values: origin.value(values) + offset.value(values))

        return self._once((hold, self.stays.of_object(hold.held, time), kind), make)

    def _stand(self, stay: Stay) -> Quantity:
        if stay.initial:
            return constant(np.array(self.start.agents[stay.body].p_WC, dtype=float))
        if not self.travels(stay):
            move, hold = self.stays.released(stay)[0]
            return self.standoff(hold, self.stays.timeline.after(move))
        approaches, lattice = self.stays.approaches(stay), self._on_lattice(stay)
        if approaches is None:
            return lattice
        direct, standoff = self._direct(stay), self.standoff(approaches, stay.times[0])

        def choice(values: Assignment) -> Array:
            return np.where(direct.value(values)[..., None], standoff.value(values), lattice.value(values))

        return Quantity(direct.scope | standoff.scope | lattice.scope, choice)

    def _on_lattice(self, stay: Stay) -> Quantity:
        """Place from the stay's list, at the height of the posture in which the agent arrives."""
        source = self.postures.sources(stay)[0]
        rises = np.array([(0.0, 0.0, z) for z in self.postures.heights(stay.body, source)])
        place, rise = self._lookup(stay, self._tables[stay]), self.by_source(source, rises)
        return Quantity(place.scope | rise.scope, lambda values: place.value(values) + rise.value(values))

    def _direct(self, stay: Stay) -> Quantity:
        chosen = self.chosen(stay)
        return Quantity(chosen.scope, lambda values: chosen.value(values) == AT_STANDOFF)

    def _in_order_of_time(self) -> list[Stay]:
        """Stays with an unknown. A grasp option is chosen when the agent sets out to the object."""
        first = {stay: (stay.times[0], 0) for stay in self.stays.objects}
        first |= {stay: (stay.times[0], 1) for stay in self.stays.holds}
        for stand in filter(self.travels, self.stays.stands):
            first[stand] = (stand.times[0], 2)
            approaches = self.stays.approaches(stand)
            if approaches is not None:
                first[approaches] = min(first[approaches], (stand.times[0], 1))
        return sorted(first, key=first.__getitem__)

    def _table(self, stay: Stay) -> Array:
        return self._object_places(stay) if stay.body in self.start.objects else self._stand_places(stay)

    def _object_places(self, stay: Stay) -> Array:
        """Places (n, 3) of an object that a team brings; one if it is given."""
        if stay.initial:
            return np.array([self.start.objects[stay.body].p_WO], dtype=float)
        region, height = self.region(stay), self.geometry.object_height[stay.body]
        reach = planar_reach(region, self.geometry.team_radius[stay.body], height)
        return _about(region, rings(max(reach, 0.0), 24), height)

    def _stand_places(self, stay: Stay) -> Array:
        """Places (n, 3), heights to be added, of an agent that travels; AT_STANDOFF first where eligible."""
        region, radius = self.region(stay), self.geometry.agent_radius[stay.body]
        sources = self.postures.sources(stay)
        heights = sorted({z for source in sources for z in self.postures.heights(stay.body, source)})
        reaches = [max(planar_reach(region, radius, height), 0.0) for height in heights]
        places = [_about(region, rings(reach, 60), 0.0) for reach in reaches]
        if self.stays.approaches(stay) is not None:
            places.insert(AT_STANDOFF, np.zeros((1, 3)))
        return np.vstack(places)


def _about(region: Region, offsets: Array, height: float) -> Array:
    """Points (n, 3) at z = `height` from planar offsets (n, 2) about the region's axis."""
    centre = np.array(region.centre[:2])
    return np.column_stack([centre + offsets, np.full(len(offsets), height)])
