"""The run begins as its scenario says: everybody in place, turned as told and at rest."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.scenario.model import Agent, Scenario
from drake_ltl.verification.headings import orientation
from drake_ltl.verification.poses import rotations
from drake_ltl.verification.violations import Violation

TOLERANCE = 1e-6
"""Of places [m], angles [rad] and speeds: a simulation begins exactly where it is told to."""
SUNK = 2e-3
"""... but drives, who stand upright on wheels that have not turned, begin this deep in the floor at most [m, rad]."""


def start_pose_violations(recording: Recording, scenario: Scenario) -> Iterator[Violation]:
    """Who is not where the scenario puts it when the recording begins, or moves already."""
    for agent in scenario.agents:
        q = recording.q[agent.name][0]
        told = np.array([*agent.position, *_posture(agent)])
        off, askew = np.abs(q[: len(told)] - told).max(), 0.0 if agent.has_arm else np.abs(q[len(told) :]).max()
        speed = np.abs(recording.qd[agent.name][0]).max()
        yield from _off(recording, agent.name, max(off, askew if askew > SUNK else 0.0), speed)
    for obj in scenario.objects:
        pose = recording.pose[obj.name][:1]
        place = np.abs(pose[0, 4:6] - np.array(obj.position)).max()
        turned = (rotations(pose) * orientation(obj, obj.heading).inv()).magnitude()[0]
        yield from _off(recording, obj.name, max(place, turned), np.abs(recording.velocity[obj.name][0]).max())


def _posture(agent: Agent) -> tuple[float, ...]:
    """What the scenario says of the joints behind x and y: of a drive its heading, of an arm all or nothing."""
    return agent.joints or () if agent.has_arm else (agent.heading,)


def _off(recording: Recording, name: str, place: float, speed: float) -> Iterator[Violation]:
    time = float(recording.time[0])
    if place > TOLERANCE:
        what = f"{name} does not begin where its scenario puts it (off by m or rad)"
        yield Violation("start", (name,), what, time, 0, float(place), time)
    if speed > TOLERANCE:
        what = f"{name} moves already when the run begins (m/s or rad/s)"
        yield Violation("start", (name,), what, time, 0, float(speed), time)
