"""Spheres in regions: which region a member is in, and whether it is the one it should be in.

Bodies count as spheres, not as points: A_i(q_i) and O_j in pi_k of Defs. 1 to 4 are balls within balls.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drake_ltl.execution.recording import NOTHING, Recording
from drake_ltl.scenario.model import Region, Scenario
from drake_ltl.verification.expected import Expected
from drake_ltl.verification.roles import Roles
from drake_ltl.verification.spans import Span
from drake_ltl.verification.violations import Violation, where_bad

ROUNDING = 1e-9
"""A ball that touches its region's border from inside is inside, whatever the last digits say [m]."""


def centres(recording: Recording, member: str) -> np.ndarray:
    """(T, 3) c_i of an agent or p_WO of an object, in W [m]."""
    return recording.centre[member] if member in recording.agents else recording.pose[member][:, 4:]


def radius(recording: Recording, member: str) -> float:
    """r_i or r_j^O [m]."""
    return recording.agent_radius[member] if member in recording.agents else recording.object_radius[member]


def excess(recording: Recording, member: str, region: Region) -> np.ndarray:
    """(T,) how far the member's sphere reaches out of the region [m]; not positive where it is inside."""
    distance = np.linalg.norm(centres(recording, member) - np.array(region.centre), axis=1)
    return distance + radius(recording, member) - region.radius


def region_at(recording: Recording, scenario: Scenario, member: str, sample: int) -> str | None:
    """The region that contains the member's sphere at a sample. Regions do not overlap, so there is one or none."""
    for region in scenario.regions:
        out = np.linalg.norm(centres(recording, member)[sample] - np.array(region.centre))
        if out + radius(recording, member) - region.radius <= ROUNDING:
            return region.name
    return None


def found_at(recording: Recording, scenario: Scenario, sample: int) -> Expected:
    """Regions and grasps as a sample shows them."""
    names = [None if index == NOTHING else recording.objects[index] for index in recording.grasp[sample].tolist()]
    return Expected(
        agents={agent: region_at(recording, scenario, agent, sample) for agent in recording.agents},
        objects={obj: region_at(recording, scenario, obj, sample) for obj in recording.objects},
        grasps=dict(zip(recording.agents, names, strict=True)),
    )


def start_violations(recording: Recording, start: Expected) -> Iterator[Violation]:
    """Members that begin in no region."""
    for member in (*recording.agents, *recording.objects):
        if start.region(member) is None:
            yield Violation("region", (member,), f"{member} begins outside every region", float(recording.time[0]), 0)


def region_violations(
    recording: Recording, scenario: Scenario, span: Span, roles: Roles, before: Expected, after: Expected
) -> Iterator[Violation]:
    """Movers must be in their goal region when the step ends, unless a fault halted it; everybody else in their own
    all the time."""
    for member in (*recording.agents, *recording.objects):
        moves = member in roles.moving
        name = after.region(member) if moves else before.region(member)
        if name is None or (moves and (span.halted or not span.finished)):
            continue
        samples = slice(span.end, span.end + 1) if moves else span.samples
        out = excess(recording, member, scenario.region(name))[samples]
        what = f"{member} has not come to {name}" if moves else f"{member} is not in {name}"
        violation = Violation("region", (member, name), what, step=span.number, unit="m")
        yield from where_bad(violation, out > ROUNDING, out, recording.time[samples])
