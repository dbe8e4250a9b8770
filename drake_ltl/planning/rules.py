"""What a placement must obey so that the continuous half can carry it out, as constraints on the unknowns.

At every state all bodies are apart and inside their regions. During a move, before and after the movers move
alike, two things are larger than the bodies themselves: a team with its load is one sphere of radius r_{T,j}, and
an agent that approaches or withdraws occupies its whole way, covered by a sphere at each end.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from drake_ltl.planning.backjumping import Assignment, Constraint
from drake_ltl.planning.exits import exit_constraints
from drake_ltl.planning.passages import passage_constraints
from drake_ltl.planning.places import Places, Quantity, constant
from drake_ltl.planning.plan import Action
from drake_ltl.planning.spheres import LEAST_MARGIN, REGION_MARGIN, Array, norm
from drake_ltl.planning.stays import Stay
from drake_ltl.scenario.model import Region

_NO_TOUCH = 1e-9
"""Bodies at their given starts may be closer than any margin, but must not touch [m]."""


@dataclass(frozen=True)
class _Ball:
    """Something round at some moment: a body, an end of an agent's approach, or a team with its load."""

    name: str
    centre: Quantity
    radius: Quantity
    own: float
    """Radius without what covers the way of an approach [m]."""
    members: frozenset[str]
    """The bodies it stands for."""
    object: str | None = None
    """What the agent holds, will hold next, or has just held, if it is near it."""
    touches: bool = False
    """Whether it is in touch with that object, so that these two need not be apart."""
    special: bool = False
    """Whether it is more than a body as it stands at a state."""
    given: bool = False
    """Whether it stands where the scenario puts it."""
    present: Quantity | None = None
    """Mask: whether it is there at all; None means always."""
    load: str | None = None
    """What a team carries: its sphere is the same whoever carries it."""

    @property
    def bodies(self) -> frozenset[str]:
        """Who is to blame if there is no place for it."""
        return self.members if self.load is None else frozenset({self.load})

    @property
    def scope(self) -> frozenset[int]:
        present = self.present.scope if self.present else frozenset()
        return self.centre.scope | self.radius.scope | present


class Rules:
    """All constraints of a placement in which bodies keep `margin` [m] apart."""

    def __init__(self, places: Places, workspace_radius: float, margin: float):
        self._places, self._workspace_radius, self._margin = places, workspace_radius, margin
        self._timeline, self._geometry = places.stays.timeline, places.geometry

    def constraints(self) -> list[Constraint]:
        """Every rule once, labelled with the first move that it concerns, in the order of moves."""
        found: dict[Hashable, Constraint] = {}
        for key, constraint in (*self._closing(), *self._at_state(0, 0)):
            found.setdefault(key, constraint)
        for move in range(len(self._timeline.moves)):
            after = self._timeline.after(move)
            ways = (*passage_constraints(self._places, move), *exit_constraints(self._places, move))
            for key, constraint in (*self._in_move(move), *self._at_state(after, move), *ways):
                found.setdefault(key, constraint)
        return sorted(found.values(), key=lambda constraint: constraint.step)

    # ---- at a state

    def _at_state(self, time: int, move: int) -> Iterator[tuple[Hashable, Constraint]]:
        balls = self._bodies(time)
        for a, b in combinations(balls, 2):
            yield from self._apart(a, b, move, time)
        for ball in balls:
            if not ball.given:
                yield self._inside(ball, self._region(ball, time), move, self._region(ball, time).name)

    def _bodies(self, time: int) -> list[_Ball]:
        agents = [self._agent(name, time) for name in self._timeline.agents]
        return agents + [self._object(name, time) for name in self._timeline.objects]

    def _agent(self, name: str, time: int) -> _Ball:
        stay, radius = self._places.stays.of_agent(name, time), self._geometry.agent_radius[name]
        return _Ball(
            name,
            self._places.agent(name, time),
            constant(radius),
            radius,
            frozenset({name}),
            object=stay.held or self._neighbour(stay, time),
            touches=stay.held is not None,
            given=stay.initial,
        )

    def _neighbour(self, stand: Stay, time: int) -> str | None:
        """The object at whose stand-off a stand is, or may be."""
        stays = self._places.stays
        if stand.initial:
            return None
        approaches = stays.approaches(stand)
        if approaches is not None:
            return approaches.held
        for move, hold in stays.released(stand):
            if stays.of_object(hold.held, time) == stays.of_object(hold.held, move):
                return hold.held
        return None

    def _object(self, name: str, time: int) -> _Ball:
        radius, given = self._geometry.object_radius[name], self._places.stays.of_object(name, time).initial
        centre = self._places.object(name, time)
        return _Ball(name, centre, constant(radius), radius, frozenset({name}), given=given)

    # ---- in a move

    def _in_move(self, move: int) -> Iterator[tuple[Hashable, Constraint]]:
        for time in (move, self._timeline.after(move)):
            for a, b in combinations(self._occupied(move, time), 2):
                if a.special or b.special:
                    yield from self._apart(a, b, move, time)
        for action in self._timeline.moves[move]:
            if action.kind == "transport":
                yield from self._transport(action, move)
            elif action.kind == "grasp":
                standoff = self._reach(action, move, self._timeline.after(move))[0]
                yield self._inside(standoff, self._places.regions[action.start], move, action.start)

    def _occupied(self, move: int, time: int) -> list[_Ball]:
        """All that is in the way in a move, `time` being the state before or after it."""
        reaching = {a.agents[0]: a for a in self._timeline.moves[move] if a.kind in ("grasp", "release")}
        balls = [ball for ball in self._bodies(time) if ball.name not in reaching]
        for action in reaching.values():
            balls += self._reach(action, move, time)
        carried = (action for action in self._timeline.moves[move] if action.kind == "transport")
        return balls + [self._team(action, time) for action in carried]

    def _reach(self, action: Action, move: int, time: int) -> list[_Ball]:
        """Both ends of an approach or a withdrawal, the stand-off first.

        An agent that must drive to its stand-off first is a mover: before, it occupies no more than its stand.
        """
        places, agent = self._places, action.agents[0]
        holding = move if action.kind == "release" else self._timeline.after(move)
        hold = places.stays.of_agent(agent, holding)
        standoff = replace(
            self._agent(agent, holding),
            centre=places.standoff(hold, holding),
            radius=places.reach_radius(hold),
            special=True,
        )
        grasp = replace(standoff, centre=places.hold(hold, holding))
        if action.kind == "release" or time != move:
            return [standoff, grasp]
        ready = places.at_standoff(places.stays.of_agent(agent, move), hold)
        ends = [replace(end, present=ready) for end in (standoff, grasp)]
        return [*ends, self._agent(agent, move)]

    def _team(self, action: Action, time: int) -> _Ball:
        radius = self._geometry.team_radius[action.object]
        centre = self._places.object(action.object, time)
        name, members = (
            f"{action.object} carried by {', '.join(action.agents)}",
            {action.object, *action.agents},
        )
        return _Ball(name, centre, constant(radius), radius, frozenset(members), special=True, load=action.object)

    def _transport(self, action: Action, move: int) -> Iterator[tuple[Hashable, Constraint]]:
        """A team's sphere is inside its goal region, and at its start clear of all but the region it leaves."""
        start, goal = self._team(action, move), self._team(action, self._timeline.after(move))
        workspace = Region("the workspace", (0.0, 0.0, 0.0), self._workspace_radius)
        yield self._inside(goal, self._places.regions[action.goal], move, action.goal)
        yield self._inside(start, workspace, move, action.start)
        for region in self._places.regions.values():
            if region.name != action.start:
                yield self._outside(start, region, move, action.start)

    # ---- relations

    def _apart(self, a: _Ball, b: _Ball, move: int, time: int) -> Iterator[tuple[Hashable, Constraint]]:
        at_its_object = a.object == b.name or b.object == a.name
        if a.members & b.members or (at_its_object and (a.touches or b.touches)):
            return
        margin = self._margin
        partners = a.object is not None and a.object == b.object
        if partners:  # their ways are straight lines from the object: what matters is how they stand at the ends
            a, b = (replace(ball, radius=constant(ball.own)) for ball in (a, b))
        if partners or at_its_object:
            margin = min(margin, LEAST_MARGIN)
        if a.given and b.given:
            margin = _NO_TOUCH
        where = self._region(a, time).name
        text = f"{a.name} and {b.name} would be less than {margin:.2f} m apart in {where}"
        present = [ball.present for ball in (a, b) if ball.present is not None]

        def slack(values: Assignment) -> Array:
            gap = norm(a.centre.value(values) - b.centre.value(values))
            gap = gap - (a.radius.value(values) + b.radius.value(values) + margin)
            for mask in present:
                gap = np.where(mask.value(values), gap, np.inf)
            return gap

        spacing = not (partners or at_its_object)
        key = (_key(a), _key(b), partners)
        yield key, Constraint(a.scope | b.scope, slack, move, text, where, a.bodies | b.bodies, spacing)

    def _inside(self, ball: _Ball, region: Region, move: int, where: str) -> tuple[Hashable, Constraint]:
        room = region.radius - ball.own - REGION_MARGIN
        text = f"{ball.name} would not be inside {region.name}"
        return self._distance(ball, region, text, lambda distance: room - distance, move, where)

    def _outside(self, ball: _Ball, region: Region, move: int, where: str) -> tuple[Hashable, Constraint]:
        reach = region.radius + ball.own + self._margin
        text = f"{ball.name} would be less than {self._margin:.2f} m from {region.name}"
        return self._distance(ball, region, text, lambda distance: distance - reach, move, where)

    def _distance(
        self, ball: _Ball, region: Region, text: str, slack: Callable[[Array], Array], move: int, where: str
    ) -> tuple[Hashable, Constraint]:
        centre = np.array(region.centre)

        def value(values: Assignment) -> Array:
            return slack(norm(ball.centre.value(values) - centre))

        return (_key(ball), text), Constraint(ball.centre.scope, value, move, text, where, ball.bodies, spacing=False)

    def _region(self, ball: _Ball, time: int) -> Region:
        return self._places.regions[self._timeline.region(min(ball.members), time)]

    # ---- what the loop closes, and what nobody can do

    def _closing(self) -> Iterator[tuple[Hashable, Constraint]]:
        stays, last = self._places.stays, len(self._timeline.moves) - 1
        for name, closes in self._places.headings.closing.items():
            if not closes:
                stay = stays.of_object(name, self._timeline.loop)
                yield self._never(stay, last, f"{name} would not come back to the same heading")
        for hold in stays.holds:
            if hold.initial or not self._places.options(hold):
                yield self._never(hold, hold.times[0], f"{hold.body} has no way to grasp {hold.held}")
        for stand in stays.stands:
            released = stays.released(stand)
            if stand.initial and released:
                yield self._never(stand, released[0][0], f"{stand.body} cannot come back to its given start")
            elif released:
                for move, hold in released[1:]:
                    yield self._same_standoff(stand, released[0], (move, hold))
            else:
                yield from self._same_posture(stand)

    def _same_standoff(
        self, stand: Stay, first: tuple[int, Stay], other: tuple[int, Stay]
    ) -> tuple[Hashable, Constraint]:
        """A stand with two ways in, both of them releases, is one place."""
        text = f"{stand.body} would not come back to the same stand-off"
        places = {self._places.stays.of_object(hold.held, move) for move, hold in (first, other)}
        if len(places) > 1:
            return self._never(stand, other[0], text)
        a, b = self._places.chosen(first[1]), self._places.chosen(other[1])

        def slack(values: Assignment) -> Array:
            return np.where(a.value(values) == b.value(values), 0.0, -1.0)

        where = self._places.region(stand).name
        return (stand, other), Constraint(
            a.scope | b.scope, slack, other[0], text, where, frozenset({stand.body}), spacing=False
        )

    def _same_posture(self, stand: Stay) -> Iterator[tuple[Hashable, Constraint]]:
        """A stand with two ways in has one posture, unless it is at a stand-off, which sets it."""
        places, postures = self._places, self._places.postures
        first, *others = postures.sources(stand)
        approaches = places.stays.approaches(stand) if places.travels(stand) else None
        direct = places.at_standoff(stand, approaches) if approaches is not None else constant(False)
        known: dict[str, int] = {}
        for other in others:
            numbers = [
                places.by_source(s, [known.setdefault(name, len(known)) for name in postures.names(stand.body, s)])
                for s in (first, other)
            ]

            def slack(values: Assignment, numbers: list[Quantity] = numbers) -> Array:
                same = numbers[0].value(values) == numbers[1].value(values)
                return np.where(same | direct.value(values), 0.0, -1.0)

            scope = direct.scope | numbers[0].scope | numbers[1].scope
            text = f"{stand.body} would come back in another posture"
            where = places.region(stand).name
            yield (
                (stand, other),
                Constraint(scope, slack, stand.times[-1], text, where, frozenset({stand.body}), spacing=False),
            )

    def _never(self, stay: Stay, move: int, text: str) -> tuple[Hashable, Constraint]:
        """What is impossible whatever is chosen."""
        where = self._places.region(stay).name
        bodies = frozenset({stay.body})
        return stay, Constraint(frozenset(), lambda values: np.array(-1.0), move, text, where, bodies, spacing=False)


def _key(ball: _Ball) -> Hashable:
    return (ball.name, id(ball.centre), ball.own, ball.special, ball.present is not None)
