"""The relations of one plan step: the list of collision functions beta of the paper, as data.

Nine kinds keep bodies apart or in the workspace: agent-agent, agent-object, agent-team, team-team,
team-object, agent-region, team-region, agent-workspace, team-workspace. Two more keep a body that travels
within one region there: agent-inside, team-inside.

Left out are all pairs in which nothing moves, which would be constants. Among them are all (agent, object it
grasps) pairs but those of a team and its load, and these are one sphere: the members' own spheres and the
carried object's take no part.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.navigation.relations import Apart, Array, Inside, Label, Relations
from drake_ltl.planning.geometry import Vector3


@dataclass(frozen=True)
class RegionBall:
    """A region pi_k."""

    name: str
    centre: Vector3
    radius: float


@dataclass(frozen=True)
class Traveller:
    """An agent z in Z on its way from region k_z to k'_z, which may be the same."""

    name: str
    radius: float
    """r_z."""
    start_region: str
    goal_region: str
    p_WC_start: Vector3
    """Centre of its bounding sphere at the start of the step, in W."""
    p_WC_goal: Vector3
    """... and at its goal."""


@dataclass(frozen=True)
class Transport:
    """A team T_m that carries an object from region k_Tm to k'_Tm, a sphere about the object's origin."""

    object: str
    agents: tuple[str, ...]
    """Members of the team."""
    radius: float
    """r_{T,j}."""
    start_region: str
    goal_region: str
    p_WO_start: Vector3
    """Origin of the object at the start of the step, in W."""
    p_WO_goal: Vector3
    """... and at its goal."""


@dataclass(frozen=True)
class StaticBody:
    """An agent that idles or holds, or an object that nobody carries."""

    name: str
    radius: float
    p_W: Vector3
    """Centre of its bounding sphere, in W."""


@dataclass(frozen=True)
class Reach:
    """An agent that grasps or releases: it stands, for the others, at both ends of its approach at once.

    So the potential does not depend on where it is on its way, and no motion outside the potential raises V.
    """

    name: str
    p_W_ends: tuple[Vector3, Vector3]
    """Centres of its bounding sphere at the stand-off and at the grasp, in W."""
    radii: tuple[float, float]


@dataclass(frozen=True)
class StepRelations:
    """Relations of a step, and where each named point stands in the array of points (P, 3)."""

    relations: Relations
    points: tuple[str, ...]
    """Name of each point. Movers come first: travellers by their name, teams by their object's; then static
    agents, ends of reaches (`a2 at the stand-off`, `a2 at the grasp`), static objects and region centres."""
    n_movers: int
    start: Array
    """All points at the start of the step (P, 3)."""
    goal: Array
    """All points when every mover is at its goal (P, 3)."""

    @property
    def movers(self) -> tuple[str, ...]:
        """Names of the moving points."""
        return self.points[: self.n_movers]

    def index(self, name: str) -> int:
        """Where the point called `name` stands; KeyError if there is none."""
        if name not in self.points:
            raise KeyError(f"no point {name!r} in this step; points are {', '.join(self.points)}")
        return self.points.index(name)

    def at(self, p_movers: Array) -> Array:
        """All points (..., P, 3), the movers at `p_movers` (..., n_movers, 3)."""
        p = np.empty((*np.shape(p_movers)[:-2], *self.start.shape))
        p[..., : self.n_movers, :] = p_movers
        p[..., self.n_movers :, :] = self.start[self.n_movers :]
        return p


Role = Literal["agent", "object", "team", "region"]


@dataclass(frozen=True)
class _Point:
    """One point of the step with all that its relations need."""

    name: str
    role: Role
    radius: float
    start: Vector3
    goal: Vector3
    regions: frozenset[str] = frozenset()
    """Where a mover may be: regions k and k'."""

    @property
    def moves(self) -> bool:
        return bool(self.regions)


def step_relations(
    *,
    travellers: Sequence[Traveller] = (),
    transports: Sequence[Transport] = (),
    static_agents: Sequence[StaticBody] = (),
    reaches: Sequence[Reach] = (),
    static_objects: Sequence[StaticBody] = (),
    regions: Sequence[RegionBall] = (),
    workspace_radius: float,
) -> StepRelations:
    """Relations of a step in which `travellers` and `transports` move and everything else stands.

    Lengths are in m, positions in the world frame W, at whose origin the workspace's ball is centred.

    Raises:
        InvalidInputError: if a body is named twice (a member of a team also as a static agent, say), a region
            is unknown, or the workspace or a region that a mover must stay in is smaller than the mover.
    """
    balls = {region.name: region for region in regions}
    points = [
        *_movers(travellers, transports),
        *_standing(static_agents, reaches, static_objects),
        *(_Point(ball.name, "region", ball.radius, ball.centre, ball.centre) for ball in regions),
    ]
    _check(travellers, transports, static_agents, reaches, static_objects, points, balls, workspace_radius)
    relations = Relations(len(points), tuple(_apart(points)), tuple(_inside(points, balls, workspace_radius)))
    return StepRelations(
        relations=relations,
        points=tuple(point.name for point in points),
        n_movers=sum(point.moves for point in points),
        start=np.array([point.start for point in points], dtype=float).reshape(-1, 3),
        goal=np.array([point.goal for point in points], dtype=float).reshape(-1, 3),
    )


def _movers(travellers: Sequence[Traveller], transports: Sequence[Transport]) -> Iterable[_Point]:
    for z in travellers:
        regions = frozenset((z.start_region, z.goal_region))
        yield _Point(z.name, "agent", z.radius, z.p_WC_start, z.p_WC_goal, regions)
    for team in transports:
        regions = frozenset((team.start_region, team.goal_region))
        yield _Point(team.object, "team", team.radius, team.p_WO_start, team.p_WO_goal, regions)


def _standing(
    agents: Sequence[StaticBody], reaches: Sequence[Reach], objects: Sequence[StaticBody]
) -> Iterable[_Point]:
    for agent in agents:
        yield _Point(agent.name, "agent", agent.radius, agent.p_W, agent.p_W)
    for reach in reaches:
        for end, p_W, radius in zip(("stand-off", "grasp"), reach.p_W_ends, reach.radii, strict=True):
            yield _Point(f"{reach.name} at the {end}", "agent", radius, p_W, p_W)
    for obj in objects:
        yield _Point(obj.name, "object", obj.radius, obj.p_W, obj.p_W)


def _apart(points: Sequence[_Point]) -> Iterable[Apart]:
    """Every pair with a mover, in the order of the points, but a mover and the regions it may be in."""
    for (a, first), (b, second) in combinations(enumerate(points), 2):
        at_home = second.role == "region" and second.name in first.regions
        if first.moves and not at_home:  # movers come first: where the first stands, both do
            pair = (second, first) if (first.role, second.role) == ("team", "agent") else (first, second)
            label = Label("-".join(point.role for point in pair), tuple(point.name for point in pair))
            yield Apart(a, b, first.radius + second.radius, label)


def _inside(points: Sequence[_Point], balls: Mapping[str, RegionBall], r_0: float) -> Iterable[Inside]:
    """Every mover inside the workspace; one that travels within a region inside that one too."""
    for a, mover in enumerate(points):
        if not mover.moves:
            continue
        yield Inside(a, (0.0, 0.0, 0.0), r_0 - mover.radius, Label(f"{mover.role}-workspace", (mover.name,)))
        if len(mover.regions) == 1:
            ball = balls[next(iter(mover.regions))]
            label = Label(f"{mover.role}-inside", (mover.name, ball.name))
            yield Inside(a, ball.centre, ball.radius - mover.radius, label)


def _check(
    travellers: Sequence[Traveller],
    transports: Sequence[Transport],
    static_agents: Sequence[StaticBody],
    reaches: Sequence[Reach],
    static_objects: Sequence[StaticBody],
    points: Sequence[_Point],
    balls: Mapping[str, RegionBall],
    workspace_radius: float,
) -> None:
    mistakes = []
    bodies = [body.name for body in (*travellers, *static_agents, *reaches, *static_objects)]
    bodies += [name for team in transports for name in (*team.agents, team.object)]
    bodies += balls
    for name in sorted({name for name in bodies if bodies.count(name) > 1}):
        mistakes.append(Mistake(name, "takes part more than once", "give each name one role in a step"))
    for mover in points:
        for region in sorted(mover.regions - balls.keys()):
            mistakes.append(Mistake(mover.name, f"unknown region {region!r}", f"use one of {sorted(balls)}"))
        if mover.moves and not mover.radius < workspace_radius:
            what = f"radius {mover.radius} is not below the workspace's {workspace_radius}"
            mistakes.append(Mistake(mover.name, what, "make the workspace larger"))
        if len(mover.regions) == 1 and not mover.radius < min(
            (balls[region].radius for region in mover.regions & balls.keys()), default=np.inf
        ):
            what = f"radius {mover.radius} does not fit in the region it must stay in"
            mistakes.append(Mistake(mover.name, what, "make the region larger"))
    if mistakes:
        raise InvalidInputError(mistakes)
