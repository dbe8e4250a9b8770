"""How far spheres are apart: members from each other, movers from regions that are none of theirs, and the border.

While an object is carried it and its team are one sphere of radius r_{T,j} about the object's origin, as in the
paper's list of functions beta; the members of one team are judged against each other as agents.

Between two samples bodies are taken to move straight, so that nothing slips through between them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.scenario.model import Region, Scenario
from drake_ltl.verification.freed import freed
from drake_ltl.verification.regions import centres, radius
from drake_ltl.verification.roles import Mover, Roles
from drake_ltl.verification.spans import Span
from drake_ltl.verification.violations import Violation, where_bad

KINDS = ("agent_agent", "agent_object", "object_object", "team_other", "forbidden_region", "workspace")


NEARER = 0.03
"""How much nearer than where it holds it an agent may come to what it grasps or lets go [m]: it may swing a little."""


@dataclass(frozen=True)
class Clearance:
    """What is left between two things during one step."""

    kind: str
    """One of KINDS, or `held`."""
    who: tuple[str, ...]
    what: str
    """What is wrong where the clearance is not positive."""
    step: int
    time: np.ndarray
    """(n,) [s]"""
    value: np.ndarray
    """(n,) [m], least between each sample and the next."""


@dataclass(frozen=True)
class _Ball:
    name: str
    role: str
    """`agent`, `object`, `team` or `region`."""
    centre: np.ndarray
    """(n, 3) [m] in W."""
    radius: float
    key: str
    """Name of the agent, of the object, or of the region."""


def step_clearances(
    recording: Recording, scenario: Scenario, span: Span, roles: Roles, opened: np.ndarray
) -> Iterator[Clearance]:
    """All clearances of one step, its start and its end included; `opened` as for `freed`."""
    time = recording.time[span.samples]
    balls = list(_balls(recording, span, roles))
    members = {agent: _agent(recording, span, agent) for agent in roles.carriers}
    pairs = [pair for pair in combinations(balls, 2) if (pair[0].key, pair[1].key) not in roles.exempt]
    yield from _held(recording, span, roles)
    for transport in roles.transports:
        pairs += combinations([members[agent] for agent in transport.team], 2)
    for a, b in pairs:
        value = least_distance(a.centre - b.centre) - a.radius - b.radius
        yield Clearance(_kind(a, b), (a.name, b.name), f"{a.name} and {b.name} overlap", span.number, time, value)
    for mover in roles.movers:
        (ball,) = (ball for ball in balls if ball.name == str(mover))
        yield from _from_regions(scenario, span, mover, ball, time)
    for ball in balls:
        value = scenario.workspace_radius - ball.radius - np.linalg.norm(ball.centre, axis=1)
        yield Clearance("workspace", (ball.name,), f"{ball.name} leaves the workspace", span.number, time, value)
    for agent, first in freed(recording, span, roles, opened).items():
        (team,) = (transport for transport in roles.transports if agent in transport.team)
        others = [ball for ball in balls if (agent, ball.key) not in roles.exempt]
        others += [_region(region, span) for region in scenario.regions if region.name not in (team.start, team.goal)]
        yield from _alone(span, members[agent], first - span.first, others, time)


def _alone(span: Span, ball: _Ball, first: int, others: Iterable[_Ball], time: np.ndarray) -> Iterator[Clearance]:
    """Of a carrier that becomes an agent like any other in the midst of its step; until then all counts as apart as it
    is then. Its sphere may reach out of its team's: whom it touches already it does not come nearer."""
    for other in others:
        value = least_distance(ball.centre - other.centre) - ball.radius - other.radius
        value[:first] = value[first]
        if value[first] <= 0.0:
            value += NEARER - value[first]
        kind, what = _kind(ball, other), f"{ball.name} and {other.name} overlap"
        yield Clearance(kind, (ball.name, other.name), what, span.number, time, value)


def _region(region: Region, span: Span) -> _Ball:
    centre = np.tile(region.centre, (span.end + 1 - span.first, 1))
    return _Ball(region.name, "region", centre, region.radius, region.name)


def _held(recording: Recording, span: Span, roles: Roles) -> Iterator[Clearance]:
    """Who grasps, holds or releases an object never comes nearer to it than where it holds it."""
    time = recording.time[span.samples]
    for agent, obj in sorted(roles.exempt):
        offset = centres(recording, agent) - centres(recording, obj)
        welded = recording.grasp[:, recording.agents.index(agent)] == recording.objects.index(obj)
        if welded.any():
            holding = float(np.linalg.norm(offset[welded], axis=1).min())
            value = least_distance(offset[span.samples]) - holding + NEARER
            what = f"{agent} is nearer to {obj} than where it holds it"
            yield Clearance("held", (agent, obj), what, span.number, time, value)


def least_distance(offset: np.ndarray) -> np.ndarray:
    """(n,) distance from the origin to the straight way from each row (n, 3) to the next; the last row stands."""
    step = np.diff(offset, axis=0, append=offset[-1:])
    length = np.einsum("ij,ij->i", step, step)
    along = -np.einsum("ij,ij->i", offset, step)
    fraction = np.clip(np.divide(along, length, out=np.zeros(len(offset)), where=length > 0.0), 0.0, 1.0)
    return np.linalg.norm(offset + fraction[:, None] * step, axis=1)


def least_of_each_kind(clearances: Iterable[Clearance]) -> dict[str, float | None]:
    """[m]; None for a kind of which there was no pair."""
    least: dict[str, float | None] = dict.fromkeys(KINDS)
    for clearance in clearances:
        if clearance.kind not in least:
            continue
        value, known = float(clearance.value.min()), least[clearance.kind]
        least[clearance.kind] = value if known is None else min(value, known)
    return least


def clearance_violations(clearances: Iterable[Clearance]) -> Iterator[Violation]:
    """Where spheres touch or overlap."""
    for c in clearances:
        kind = c.kind if c.kind in ("forbidden_region", "workspace") else "clearance"
        violation = Violation(kind, c.who, c.what, step=c.step, unit="m")
        yield from where_bad(violation, c.value <= 0.0, -c.value, c.time)


def _balls(recording: Recording, span: Span, roles: Roles) -> Iterator[_Ball]:
    """Agents before objects, so that a pair of both is (agent, object)."""
    for agent in recording.agents:
        if agent not in roles.carriers:
            yield _agent(recording, span, agent)
    for obj in recording.objects:
        if obj not in roles.carried:
            yield _Ball(obj, "object", centres(recording, obj)[span.samples], radius(recording, obj), obj)
    for mover in roles.transports:
        centre = centres(recording, mover.name)[span.samples]
        yield _Ball(str(mover), "team", centre, recording.team_radius[mover.name], mover.name)


def _agent(recording: Recording, span: Span, agent: str) -> _Ball:
    return _Ball(agent, "agent", centres(recording, agent)[span.samples], radius(recording, agent), agent)


def _kind(a: _Ball, b: _Ball) -> str:
    if b.role == "region":
        return "forbidden_region"
    return "team_other" if "team" in (a.role, b.role) else f"{a.role}_{b.role}"


def _from_regions(scenario: Scenario, span: Span, mover: Mover, ball: _Ball, time: np.ndarray) -> Iterator[Clearance]:
    """Spheres on their way touch no region but those they start and end in (Defs. 1 and 4)."""
    for region in scenario.regions:
        if region.name not in (mover.start, mover.goal):
            value = least_distance(ball.centre - np.array(region.centre)) - ball.radius - region.radius
            what = f"{ball.name} touches {region.name} on the way to {mover.goal}"
            yield Clearance("forbidden_region", (ball.name, region.name), what, span.number, time, value)
