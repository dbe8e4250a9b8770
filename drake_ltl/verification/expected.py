"""Where everything should be: the start, changed by the recorded actions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from drake_ltl.scenario.model import Scenario
from drake_ltl.verification.spans import Span
from drake_ltl.verification.violations import Violation


@dataclass(frozen=True)
class Expected:
    """Regions and grasps between two steps; a region is None after a start outside every region, and where a fault has
    halted who was on its way."""

    agents: Mapping[str, str | None]
    objects: Mapping[str, str | None]
    grasps: Mapping[str, str | None]
    between: Mapping[str, frozenset[str]] = field(default_factory=dict)
    """member that a fault has halted in no region -> those that it was on its way from and to."""

    def region(self, member: str) -> str | None:
        """Of an agent or an object."""
        return self.agents[member] if member in self.agents else self.objects[member]

    def holders(self, obj: str) -> frozenset[str]:
        """Agents that grasp the object."""
        return frozenset(agent for agent, held in self.grasps.items() if held == obj)


def expectations(
    start: Expected, spans: Sequence[Span], found: Callable[[int], Expected] | None = None
) -> list[Expected]:
    """Before each span and after the last one (K + 1). After a fault, who acted is `found` at the sample of the end,
    and who did not is still where it was, and holds what it held at the last sample before: at the end welds already
    belong to the next step. Runs without faults need no such look."""
    expected = [start]
    for span in spans:
        before = expected[-1]
        if span.halted:
            ended = replace(found(span.end), grasps=found(span.last).grasps)
            expected.append(_halted(before, ended, span))
        else:
            expected.append(_after(before, span.actions))
    return expected


def _halted(before: Expected, found: Expected, span: Span) -> Expected:
    """How far those who acted came shows in what is found alone."""
    ends = {
        name: frozenset((action["from"], action["to"]))
        for action in span.actions
        for name in (*action["agents"], action["object"])
    }
    acted = ends.keys() | set(span.faulty)

    def joined(was: Mapping[str, str | None], now: Mapping[str, str | None]) -> dict[str, str | None]:
        return {name: now[name] if name in acted else value for name, value in was.items()}

    agents, objects = joined(before.agents, found.agents), joined(before.objects, found.objects)
    between = {
        name: before.between.get(name) or ends.get(name, frozenset([before.region(name)]))
        for name, region in (agents | objects).items()
        if region is None
    }
    return Expected(agents, objects, found.grasps, between)


CanCarry = Callable[[str, frozenset[str]], bool]
"""Lambda: (name of the object, names of the team) -> whether the team can carry it."""


def powers_add_up(scenario: Scenario) -> CanCarry:
    """Lambda of a scenario file: the powers of the team add up to what the object needs."""
    power = {agent.name: agent.power for agent in scenario.agents}
    needed = {obj.name: obj.power_needed for obj in scenario.objects}
    return lambda obj, team: math.fsum(power[agent] for agent in team) >= needed[obj]


def action_violations(
    expected: Sequence[Expected], spans: Sequence[Span], time: Sequence[float], can_carry: CanCarry
) -> Iterator[Violation]:
    """Actions that could not begin as things stood (the premises of Defs. 1 to 4)."""
    for before, span in zip(expected, spans, strict=False):
        for action in span.actions:
            if action["kind"] == "transport" and not can_carry(action["object"], frozenset(action["agents"])):
                what = f"{' and '.join(action['agents'])} cannot carry {action['object']}: they are too weak"
                yield Violation("action", (action["object"],), what, float(time[span.first]), span.number)
            for who, fault in _faults(before, action):
                yield Violation("action", who, fault, float(time[span.first]), span.number)
        for who, fault in _clashes(span.actions):
            yield Violation("action", who, fault, float(time[span.first]), span.number)


def _after(before: Expected, actions: Iterable[dict]) -> Expected:
    agents, objects, grasps = dict(before.agents), dict(before.objects), dict(before.grasps)
    for action in actions:
        obj = action["object"]
        for agent in action["agents"]:
            if action["kind"] in ("grasp", "release"):  # it stays where it is
                grasps[agent] = obj if action["kind"] == "grasp" else None
            else:
                agents[agent] = action["to"]
        if action["kind"] == "transport":
            objects[obj] = action["to"]
    where = agents | objects
    between = {name: ends for name, ends in before.between.items() if where[name] is None}
    return Expected(agents, objects, grasps, between)


def _faults(before: Expected, action: dict) -> Iterator[tuple[tuple[str, ...], str]]:
    kind, obj, start = action["kind"], action["object"], action["from"]
    for member in (*action["agents"], *([] if obj is None else [obj])):
        if not _may_begin(before, member, kind, start):
            yield (member,), f"{kind} of {member} begins in {start}, where it is not"
    needed = obj if kind in ("release", "transport") else None
    for agent in action["agents"]:
        if before.grasps[agent] != needed:
            yield (agent,), f"{kind} by {agent}, which {_grasping(before.grasps[agent])}"
    if kind == "transport" and before.holders(obj) != set(action["agents"]):
        yield (obj,), f"{obj} is carried by others than those that grasp it"
    if kind in ("grasp", "release") and action["to"] != start:
        yield tuple(action["agents"]), f"{kind} that begins in {start} and ends in {action['to']}"


def _may_begin(before: Expected, member: str, kind: str, start: str) -> bool:
    """Whether an action of a member may begin in a region. Who was halted on its way from one to another goes on from
    either, or lets go where it is; whose start was wrong (another violation) may be anywhere."""
    if before.region(member) is not None:
        return before.region(member) == start
    ends = before.between.get(member)
    return ends is None or kind == "release" or (kind != "grasp" and start in ends)


def _clashes(actions: Sequence[dict]) -> Iterator[tuple[tuple[str, ...], str]]:
    agents = [agent for action in actions for agent in action["agents"]]
    for agent in sorted({agent for agent in agents if agents.count(agent) > 1}):
        yield (agent,), f"{agent} takes part in two actions of one step"
    moved = [action["object"] for action in actions if action["kind"] == "transport"]
    handled = [action["object"] for action in actions]
    for obj in sorted({obj for obj in moved if handled.count(obj) > 1}):
        yield (obj,), f"{obj} is carried while something else is done to it"


def _grasping(obj: str | None) -> str:
    return "grasps nothing" if obj is None else f"grasps {obj}"
