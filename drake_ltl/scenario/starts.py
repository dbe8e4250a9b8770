"""Where all members stand at the start: in which region, and with which arm posture."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.scenario.model import Agent, Region, Scenario, TransportObject

if TYPE_CHECKING:
    from drake_ltl.planning.geometry import Geometry, Vector3

UNMEASURED_POSTURE = "start"
"""Posture of an agent of whose arm nothing is known; its sphere is centred on the base's origin."""

ROOM = 0.05
"""Postures that leave less between a sphere and its region's border come last [m]: who must stay in the region is
driven off the border the harder the closer it is."""


@dataclass(frozen=True)
class AgentStart:
    """An agent at the start."""

    region: str
    posture: str
    """Key into `Geometry.postures`."""
    p_WC: Vector3
    """Centre of its bounding sphere in W."""


@dataclass(frozen=True)
class ObjectStart:
    """An object at the start."""

    region: str
    p_WO: Vector3
    """Its origin, the centre of its bounding sphere, in W."""


@dataclass(frozen=True)
class Starts:
    """All members at the start, by name: init(i) and init_O(j) with the configurations."""

    agents: Mapping[str, AgentStart]
    objects: Mapping[str, ObjectStart]


@dataclass(frozen=True)
class _Candidate:
    """One way in which a member can stand at the start."""

    posture: str
    centre: Vector3
    radius: float
    region: str | None
    """None where its sphere lies in no region."""

    def gap(self, other: _Candidate) -> float:
        """Distance between the two spheres; negative where they overlap."""
        return math.dist(self.centre, other.centre) - self.radius - other.radius


def check_starts(scenario: Scenario, geometry: Geometry) -> Starts:
    """The start of every member: each sphere inside a region, no two touching.

    An agent whose joints the file leaves open takes the first of its postures with which this is possible, those
    that leave ROOM before all others and earlier agents choosing first; otherwise its first posture is the one the
    file gives.

    Raises:
        InvalidInputError: with every sphere that lies in no region, and every pair that touches.
    """
    members = (*scenario.agents, *scenario.objects)
    options = {member.name: _options(scenario, geometry, member) for member in members}
    mistakes = [
        _outside(scenario, member, options[member.name]) for member in members if options[member.name][0].region is None
    ]
    chosen: dict[str, _Candidate] = {}
    for group in _groups(options):
        choice = next(_choices(group, options), None)
        if choice is None:
            mistakes += _touching(scenario, group, options)
        else:
            chosen |= choice
    if mistakes:
        raise InvalidInputError(mistakes)
    agents = {name: chosen[name] for name in scenario.agent_names}
    objects = {name: chosen[name] for name in scenario.object_names}
    return Starts(
        {name: AgentStart(one.region or "", one.posture, one.centre) for name, one in agents.items()},
        {name: ObjectStart(one.region or "", one.centre) for name, one in objects.items()},
    )


def _options(scenario: Scenario, geometry: Geometry, member: Agent | TransportObject) -> tuple[_Candidate, ...]:
    """Ways to stand inside a region, in order of preference; all ways if there is none inside a region."""
    x, y = member.position
    if isinstance(member, Agent):
        radius = geometry.agent_radius[member.name]
        postures = dict(geometry.postures.get(member.name, {})) or {UNMEASURED_POSTURE: (0.0, 0.0, 0.0)}
        if member.joints is not None:
            postures = dict(itertools.islice(postures.items(), 1))
    else:
        radius = geometry.object_radius[member.name]
        postures = {UNMEASURED_POSTURE: (0.0, 0.0, geometry.object_height.get(member.name, 0.0))}
    candidates, excess = [], {}
    for posture, (dx, dy, dz) in postures.items():
        centre = (x + dx, y + dy, dz)
        nearest = _nearest(scenario, centre)
        excess[posture] = _excess(nearest, centre, radius)
        candidates.append(_Candidate(posture, centre, radius, nearest.name if excess[posture] <= 0 else None))
    inside = [one for one in candidates if one.region is not None]
    return tuple(sorted(inside, key=lambda one: excess[one.posture] > -ROOM)) or tuple(candidates)


def _excess(region: Region, centre: Vector3, radius: float) -> float:
    """How far a sphere reaches out of `region` [m]; not positive where it is inside."""
    return math.dist(centre, region.centre) + radius - region.radius


def _nearest(scenario: Scenario, centre: Vector3) -> Region:
    """The region that a sphere at `centre`, of whatever radius, leaves least."""
    return min(scenario.regions, key=lambda region: _excess(region, centre, 0.0))


def _groups(options: Mapping[str, Sequence[_Candidate]]) -> Iterator[list[str]]:
    """Members that can touch each other, directly or through others: groups are independent choices."""
    touching = [
        (first, second)
        for first, second in itertools.combinations(options, 2)
        if any(one.gap(other) <= 0 for one, other in itertools.product(options[first], options[second]))
    ]
    if not touching:
        yield from ([name] for name in options)
        return
    import networkx as nx  # loading it takes longer than most plans

    graph = nx.Graph(touching)
    graph.add_nodes_from(options)
    for group in nx.connected_components(graph):
        yield [name for name in options if name in group]


def _choices(group: Sequence[str], options: Mapping[str, Sequence[_Candidate]]) -> Iterator[dict[str, _Candidate]]:
    """All ways to let the group stand apart, in order of preference (backtracking with look-ahead)."""
    if not group:
        yield {}
        return
    first, *rest = group
    for candidate in options[first]:
        left = {name: [one for one in options[name] if one.gap(candidate) > 0] for name in rest}
        if all(left.values()):
            for choice in _choices(rest, left):
                yield {first: candidate, **choice}


def _outside(scenario: Scenario, member: Agent | TransportObject, options: Sequence[_Candidate]) -> Mistake:
    """Says by how much the member's best start misses a region."""
    best = min(options, key=lambda one: _excess(_nearest(scenario, one.centre), one.centre, one.radius))
    region = _nearest(scenario, best.centre)
    excess = _excess(region, best.centre, best.radius)
    what = (
        f"the bounding sphere at {_point(best.centre)} of radius {best.radius:.4g} m lies in no region: "
        f"it reaches {excess:.4g} m out of the nearest, {region.name} at {_point(region.centre)}"
    )
    return Mistake(_where(member), what, f"move it towards the centre of {region.name}")


def _touching(scenario: Scenario, group: Sequence[str], options: Mapping[str, Sequence[_Candidate]]) -> list[Mistake]:
    """Says which pairs of the group touch in their preferred starts: at least one, or there were a choice."""
    pairs = list(itertools.combinations(group, 2))
    gaps = {pair: options[pair[0]][0].gap(options[pair[1]][0]) for pair in pairs}
    where = {member.name: _where(member) for member in (*scenario.agents, *scenario.objects)}
    return [
        Mistake(
            where[second],
            f"the bounding spheres of {first} and {second} overlap by {abs(gap):.4g} m",
            f"move them apart: their centres must be more than {_reach(options, first, second):.4g} m apart",
        )
        for (first, second), gap in gaps.items()
        if gap <= 0
    ]


def _reach(options: Mapping[str, Sequence[_Candidate]], first: str, second: str) -> float:
    return options[first][0].radius + options[second][0].radius


def _where(member: Agent | TransportObject) -> str:
    return f"{'agents' if isinstance(member, Agent) else 'objects'}.{member.name}.position"


def _point(p: Vector3) -> str:
    return f"({p[0]:.4g}, {p[1]:.4g}, {p[2]:.4g})"
