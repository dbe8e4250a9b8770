"""Spheres are where the joints put them and cover the bodies they stand for; objects stand on the floor or are held.

Clearances between spheres are clearances between bodies only if this holds.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.verification.mechanics import Mechanics
from drake_ltl.verification.roles import Roles
from drake_ltl.verification.spans import Span
from drake_ltl.verification.violations import Violation, where_bad

ROUNDING = 1e-6
"""Difference between a recorded centre and that of the joints [m]."""
BEYOND = 0.05
"""How far a joint goes beyond its limits [m, rad]: its stops are slightly soft."""
SINK = 2e-3
"""How far an object may sink into the floor, or stand above it while nobody grasps it [m]: contact is slightly soft."""


def body_violations(
    recording: Recording, mechanics: Mechanics, span: Span, roles: Roles, breaks: Mapping[str, float]
) -> Iterator[Violation]:
    """What is wrong with the spheres and the objects of one step; `breaks` as for `grasps.weld_errors`."""
    yield from _centres(recording, mechanics, span)
    yield from _covered(recording, mechanics, span)
    yield from _teams_covered(recording, mechanics, span, roles, breaks)
    yield from _on_the_floor(recording, mechanics, span)
    yield from _within_limits(recording, mechanics, span)


def _centres(recording: Recording, mechanics: Mechanics, span: Span) -> Iterator[Violation]:
    for agent in recording.agents:
        off = np.linalg.norm(recording.centre[agent] - mechanics.centre[agent], axis=1)[span.samples]
        violation = Violation(
            "body",
            (agent,),
            f"the recorded sphere of {agent} is not where its joints put it",
            step=span.number,
            unit="m",
        )
        yield from where_bad(violation, off > ROUNDING, off, recording.time[span.samples])


def _covered(recording: Recording, mechanics: Mechanics, span: Span) -> Iterator[Violation]:
    for name, radius in (recording.agent_radius | recording.object_radius).items():
        reach = np.broadcast_to(mechanics.reach[name], mechanics.seen.shape)
        yield from _beyond(recording, mechanics, span, reach - radius, (name,), f"{name} reaches out of its sphere")


def _teams_covered(
    recording: Recording, mechanics: Mechanics, span: Span, roles: Roles, breaks: Mapping[str, float]
) -> Iterator[Violation]:
    objects, seen = recording.objects, recording.time[mechanics.seen]
    for mover in roles.transports:
        for agent in mover.team:
            beyond = mechanics.team_reach[mover.name, agent] - recording.team_radius[mover.name]
            what = f"{agent} reaches out of the sphere of the team that carries {mover.name}"
            if span.halted and agent in span.faulty and agent in breaks:  # it may have lost its grasp
                beyond = np.where(seen < breaks[agent], beyond, -np.inf)
            if span.halted:  # once it has let go it is no longer of the team
                held = recording.grasp[mechanics.seen, recording.agents.index(agent)] == objects.index(mover.name)
                beyond = np.where(held, beyond, -np.inf)
            yield from _beyond(recording, mechanics, span, beyond, (mover.name, agent), what)


def _beyond(
    recording: Recording, mechanics: Mechanics, span: Span, beyond: np.ndarray, who: tuple[str, ...], what: str
) -> Iterator[Violation]:
    now = (mechanics.seen >= span.first) & (mechanics.seen <= span.end)
    time = recording.time[mechanics.seen[now]]
    yield from where_bad(
        Violation("body", who, what, step=span.number, unit="m"), beyond[now] > ROUNDING, beyond[now], time
    )


def _within_limits(recording: Recording, mechanics: Mechanics, span: Span) -> Iterator[Violation]:
    for agent, (lower, upper) in mechanics.limits.items():
        q = recording.q[agent][span.samples]
        beyond = np.maximum(lower - q, q - upper).max(axis=1)
        violation = Violation("body", (agent,), f"a joint of {agent} is beyond its limits (m or rad)", step=span.number)
        yield from where_bad(violation, beyond > BEYOND, beyond, recording.time[span.samples])


def _on_the_floor(recording: Recording, mechanics: Mechanics, span: Span) -> Iterator[Violation]:
    time = recording.time[span.own]
    for column, obj in enumerate(recording.objects):
        height = mechanics.lowest[obj][span.own]
        violation = Violation("body", (obj,), f"{obj} is in the floor", step=span.number, unit="m")
        yield from where_bad(violation, height < -SINK, -height, time)
        free = (recording.grasp[span.own] != column).all(axis=1)
        violation = Violation("body", (obj,), f"{obj} is above the floor, held by nobody", step=span.number, unit="m")
        yield from where_bad(violation, free & (height > SINK), height, time)
