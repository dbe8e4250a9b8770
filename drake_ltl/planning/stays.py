"""Who stays where for how long: a plan cut into stays of objects, holds and stands of agents.

A body that nothing moves stays where it is, so what has to be placed is not every body at every state but every
stay. Time is a lasso: a stay may span the end of the loop and its beginning, and have two ways in.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from drake_ltl.planning.plan import Action, Plan, State


@dataclass(frozen=True)
class Stay:
    """A longest time in which a body stands (or an agent holds an object) without being moved."""

    body: str
    times: tuple[int, ...]
    """Indices of states, in the order of time along the lasso."""
    held: str | None = None
    """The object, if this is a hold of an agent."""

    @property
    def initial(self) -> bool:
        """Whether the body stands where it is given at the beginning."""
        return self.times[0] == 0


@dataclass(frozen=True)
class Timeline:
    """A plan's states and moves, the loop unrolled by some rounds; after the last move it goes on at `loop`."""

    states: tuple[State, ...]
    moves: tuple[tuple[Action, ...], ...]
    loop: int
    plan_moves: tuple[int, ...]
    """Index in the plan of each move."""
    agents: tuple[str, ...]
    objects: tuple[str, ...]

    @classmethod
    def of(cls, plan: Plan, agents: tuple[str, ...], objects: tuple[str, ...], *, rounds: int = 0) -> Timeline:
        """The plan with `rounds` rounds of its suffix taken as part of the prefix."""
        order = list(range(len(plan.states))) + rounds * list(range(plan.loop, len(plan.states)))
        return cls(
            tuple(plan.states[k] for k in order),
            tuple(plan.moves[k] for k in order),
            plan.loop + rounds * len(plan.suffix),
            tuple(order),
            agents,
            objects,
        )

    def after(self, time: int) -> int:
        """Index of the state that move `time` leads to."""
        return time + 1 if time + 1 < len(self.states) else self.loop

    def before(self, time: int) -> tuple[int, ...]:
        """Indices of the moves that lead to state `time`: two for the loop's first state, none for the start."""
        return tuple(t for t in range(len(self.states)) if self.after(t) == time)

    def region(self, body: str, time: int) -> str:
        """Region in which an agent or object is."""
        state = self.states[time]
        if body in self.objects:
            return state.objects[self.objects.index(body)]
        return state.agents[self.agents.index(body)]

    def held(self, agent: str, time: int) -> str | None:
        """Object that the agent grasps."""
        return self.states[time].grasps[self.agents.index(agent)]

    def action(self, agent: str, move: int) -> Action | None:
        """What the agent does in the move, if anything."""
        return next((action for action in self.moves[move] if agent in action.agents), None)

    def transport(self, obj: str, move: int) -> Action | None:
        """How the object is carried in the move, if it is."""
        carried = (action for action in self.moves[move] if action.kind == "transport")
        return next((action for action in carried if action.object == obj), None)


class Stays:
    """All stays of a timeline, found by body and time."""

    def __init__(self, timeline: Timeline):
        self.timeline = timeline
        self._object: dict[tuple[str, int], Stay] = {}
        self._agent: dict[tuple[str, int], Stay] = {}
        for obj in timeline.objects:
            self._object |= self._cut(obj, lambda t, obj=obj: timeline.transport(obj, t) is None, lambda t: None)
        for agent in timeline.agents:
            self._agent |= self._cut(
                agent,
                lambda t, agent=agent: self._remains(agent, t),
                lambda t, agent=agent: timeline.held(agent, t),
            )

    def of_object(self, obj: str, time: int) -> Stay:
        """Where the object stands at a state; one stay ends where the next transport begins."""
        return self._object[obj, time]

    def of_agent(self, agent: str, time: int) -> Stay:
        """The agent's hold at a state, which spans transports, or its stand."""
        return self._agent[agent, time]

    @property
    def objects(self) -> tuple[Stay, ...]:
        """All stays of objects."""
        return tuple(dict.fromkeys(self._object.values()))

    @property
    def holds(self) -> tuple[Stay, ...]:
        """All holds."""
        return tuple(stay for stay in dict.fromkeys(self._agent.values()) if stay.held is not None)

    @property
    def stands(self) -> tuple[Stay, ...]:
        """All stays of agents that hold nothing."""
        return tuple(stay for stay in dict.fromkeys(self._agent.values()) if stay.held is None)

    def entries(self, stay: Stay) -> tuple[tuple[int, Stay], ...]:
        """(move, stay it comes from) for each way into an agent's stay."""
        moves = (move for t in stay.times for move in self.timeline.before(t))
        origins = ((move, self.of_agent(stay.body, move)) for move in moves)
        return tuple((move, origin) for move, origin in origins if origin != stay)

    def exit(self, stay: Stay) -> tuple[int, Stay] | None:
        """(move, stay it leads to) of an agent's stay; None if it lasts for ever."""
        goals = ((move, self.of_agent(stay.body, self.timeline.after(move))) for move in stay.times)
        return next(((move, goal) for move, goal in goals if goal != stay), None)

    def released(self, stay: Stay) -> tuple[tuple[int, Stay], ...]:
        """(move, hold) for each release that leads into a stand."""
        return tuple((move, origin) for move, origin in self.entries(stay) if origin.held is not None)

    def approaches(self, stay: Stay) -> Stay | None:
        """The hold that ends a stand, if its object waits at one place for as long as the agent does."""
        leads = self.exit(stay)
        if leads is None or leads[1].held is None:
            return None
        hold = leads[1]
        regions = {self.timeline.region(hold.held, t) for t in stay.times}
        waits = {self.of_object(hold.held, t) for t in stay.times}
        return hold if len(waits) == 1 and regions == {self.region(stay)} else None

    def region(self, stay: Stay) -> str:
        """Region of a stand or of a stay of an object."""
        return self.timeline.region(stay.body, stay.times[0])

    def _remains(self, agent: str, move: int) -> bool:
        action = self.timeline.action(agent, move)
        return action is None or action.kind == "transport"

    def _cut(
        self, body: str, remains: Callable[[int], bool], held: Callable[[int], str | None]
    ) -> Mapping[tuple[str, int], Stay]:
        times = range(len(self.timeline.states))
        classes = _join(times, ((t, self.timeline.after(t)) for t in times if remains(t)))
        stays = {times_: Stay(body, times_, held(times_[0])) for times_ in dict.fromkeys(classes.values())}
        return {(body, t): stays[classes[t]] for t in times}


def _join(items: Iterable[int], pairs: Iterable[tuple[int, int]]) -> dict[int, tuple[int, ...]]:
    """The sets into which `pairs` join the items, as item -> sorted set."""
    member = {item: (item,) for item in items}
    for a, b in pairs:
        if member[a] is not member[b]:
            joined = tuple(sorted(member[a] + member[b]))
            member.update(dict.fromkeys(joined, joined))
    return member
