"""Who does what in a step: the sets Z, T_m and G of the paper, with what they exempt from each other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from drake_ltl.verification.expected import Expected
from drake_ltl.verification.spans import Span


@dataclass(frozen=True)
class Mover:
    """An agent that travels, or an object with the team that carries it."""

    name: str
    """Of the agent or the object."""
    team: tuple[str, ...]
    """Agents that carry; empty for a traveller."""
    start: str
    goal: str

    def __str__(self) -> str:
        return f"{self.name} with {' and '.join(self.team)}" if self.team else self.name


@dataclass(frozen=True)
class Roles:
    """What each member does in one step; who is not mentioned idles."""

    travels: tuple[Mover, ...]
    transports: tuple[Mover, ...]
    grasping: Mapping[str, str]
    """agent g in G -> the object."""
    exempt: frozenset[tuple[str, str]]
    """(agent, object) pairs that touch by intention: held when the step begins (and perhaps released), or grasped."""

    @property
    def movers(self) -> tuple[Mover, ...]:
        return self.travels + self.transports

    @property
    def carriers(self) -> frozenset[str]:
        return frozenset(agent for transport in self.transports for agent in transport.team)

    @property
    def carried(self) -> frozenset[str]:
        return frozenset(transport.name for transport in self.transports)

    @property
    def moving(self) -> frozenset[str]:
        """All members that leave their place."""
        return self.carriers | self.carried | {travel.name for travel in self.travels}


def step_roles(before: Expected, span: Span) -> Roles:
    """The roles of a step that begins as `before`."""
    of_kind = {kind: [a for a in span.actions if a["kind"] == kind] for kind in ("travel", "grasp", "transport")}
    grasping = {agent: action["object"] for action in of_kind["grasp"] for agent in action["agents"]}
    held = {agent: obj for agent, obj in before.grasps.items() if obj is not None}
    return Roles(
        travels=tuple(Mover(agent, (), a["from"], a["to"]) for a in of_kind["travel"] for agent in a["agents"]),
        transports=tuple(Mover(a["object"], tuple(a["agents"]), a["from"], a["to"]) for a in of_kind["transport"]),
        grasping=grasping,
        exempt=frozenset([*held.items(), *grasping.items()]),
    )
