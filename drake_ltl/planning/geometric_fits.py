"""The predicate P_{s,0} by geometry: what stands in a region fits if a packing of its spheres is found."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations, product

from drake_ltl.planning.fits import Content
from drake_ltl.planning.geometry import Geometry, GraspOption, Vector3
from drake_ltl.planning.packing import Group, Packed, Sphere, pack
from drake_ltl.planning.spheres import LEAST_MARGIN
from drake_ltl.scenario.model import Region, Scenario


@dataclass(frozen=True)
class Packing:
    """One way for a content to stand in a region, all positions in W [m]."""

    agents: Mapping[str, Vector3]
    """Centre of each agent's sphere."""
    objects: Mapping[str, Vector3]
    """Origin of each object."""
    options: Mapping[str, str] = field(default_factory=dict)
    """Name of the grasp option of each agent that holds."""


class GeometricFits:
    """Whether the spheres of a region's content fit; the answer yes comes with a packing.

    Free agents are taken in their first posture. An object stands with its holders around it, each at the grasp
    of one of its options; one that is carried is in addition a sphere of radius r_{T,j}. Answers depend on the
    scenario's seed alone, and are kept.
    """

    def __init__(self, scenario: Scenario, geometry: Geometry):
        self._seed, self._geometry = scenario.seed, geometry
        self._answers: dict[tuple[float, float, tuple[Group, ...]], Packed | None] = {}

    @staticmethod
    def of_region(region: Region) -> tuple[float, float]:
        """Its radius and the height of its centre [m]."""
        return region.radius, region.centre[2]

    def __call__(self, region: Region, content: Content) -> bool:
        """P_{s,0}."""
        return self.packing(region, content) is not None

    def packing(self, region: Region, content: Content) -> Packing | None:
        """P_{s,1}: a way to place the content in the region, or None if none was found."""
        ways = {obj: self._ways_to_hold(obj, content) for obj in content.objects}
        groups = {name: self._free(name) for name in content.free_agents}
        groups |= {obj: self._held(obj, content, ways[obj]) for obj in content.objects}
        order = sorted(groups, key=lambda name: repr(groups[name]))  # alike contents share an answer
        packed = self._pack(*self.of_region(region), tuple(groups[name] for name in order))
        return None if packed is None else self._named(region, content, ways, order, packed)

    def _pack(self, radius: float, height: float, groups: tuple[Group, ...]) -> Packed | None:
        """What does not fit with one group less does not fit: so most refusals cost nothing."""
        key = (radius, height, groups)
        if key not in self._answers:
            fewer = (groups[:k] + groups[k + 1 :] for k in range(len(groups)))
            hopeless = any(self._pack(radius, height, less) is None for less in dict.fromkeys(fewer))
            self._answers[key] = None if hopeless else pack(groups, radius, height, seed=self._seed)
        return self._answers[key]

    def _free(self, agent: str) -> Group:
        postures = self._geometry.postures.get(agent) or {"": (0.0, 0.0, 0.0)}
        height = next(iter(postures.values()))[2]
        return Group(((Sphere((0.0, 0.0, height), self._geometry.agent_radius[agent]),),))

    def _ways_to_hold(self, obj: str, content: Content) -> Sequence[Mapping[str, GraspOption]]:
        """Choices of an option for each holder with which all holders are apart."""
        holders = [agent for agent, held in content.holds if held == obj]
        options = [self._geometry.grasps.get((agent, obj), ()) for agent in holders]
        ways = (dict(zip(holders, choice, strict=True)) for choice in product(*options))
        return [way for way in ways if self._are_apart(way)]

    def _are_apart(self, way: Mapping[str, GraspOption]) -> bool:
        radius = self._geometry.agent_radius
        return all(
            math.dist(p.p_OoC_grasp, q.p_OoC_grasp) >= radius[a] + radius[b] + LEAST_MARGIN
            for (a, p), (b, q) in combinations(way.items(), 2)
        )

    def _held(self, obj: str, content: Content, ways: Sequence[Mapping[str, GraspOption]]) -> Group:
        height, radius = self._geometry.object_height[obj], self._geometry.object_radius
        spheres = [Sphere((0.0, 0.0, height), radius[obj])]
        if obj in content.carried:
            spheres.append(Sphere((0.0, 0.0, height), self._geometry.team_radius[obj]))
        return Group(tuple((*spheres, *self._members(way, height)) for way in ways))

    def _members(self, way: Mapping[str, GraspOption], height: float) -> Sequence[Sphere]:
        return [
            Sphere(_raised(option.p_OoC_grasp, height), self._geometry.agent_radius[agent])
            for agent, option in way.items()
        ]

    def _named(
        self,
        region: Region,
        content: Content,
        ways: Mapping[str, Sequence[Mapping[str, GraspOption]]],
        order: Sequence[str],
        packed: Packed,
    ) -> Packing:
        x, y, _ = region.centre
        at = {name: (x + u, y + v) for name, (u, v) in zip(order, packed.origins, strict=True)}
        chosen = dict(zip(order, packed.alternatives, strict=True))
        heights = {name: self._free(name).alternatives[0][0].offset[2] for name in content.free_agents}
        agents = {name: (*at[name], height) for name, height in heights.items()}
        objects = {obj: (*at[obj], self._geometry.object_height[obj]) for obj in content.objects}
        options: dict[str, str] = {}
        for obj, origin in objects.items():
            for agent, option in ways[obj][chosen[obj]].items():
                dx, dy, dz = option.p_OoC_grasp
                agents[agent] = (origin[0] + dx, origin[1] + dy, origin[2] + dz)
                options[agent] = option.name
        return Packing(agents, objects, options)


def _raised(offset: Vector3, height: float) -> Vector3:
    return offset[0], offset[1], offset[2] + height
