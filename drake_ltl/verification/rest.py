"""At rest at step ends: the next step begins where this one has ended, not somewhere in motion."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.scenario.model import Tolerances
from drake_ltl.verification.spans import Span
from drake_ltl.verification.violations import Violation

SLACK = 2.0
"""A transport ends on the object's speed; the joints of its team, metres away from it, may be somewhat faster."""


def rest_violations(recording: Recording, span: Span, tolerances: Tolerances) -> Iterator[Violation]:
    """What moves faster than `tolerances.speed`, with slack, when the step ends.

    One number bounds m/s and rad/s alike: at an arm's length of a metre or two they mean the same.
    """
    if not span.finished:
        return
    limit = SLACK * tolerances.speed
    for member, velocity, unit in _velocities(recording):
        speed = float(np.abs(velocity[span.end]).max(initial=0.0))
        if speed > limit:
            what = f"{member} is not at rest when the step ends (at most {limit:.3g} {unit})"
            time = float(recording.time[span.end])
            yield Violation("rest", (member,), what, time, span.number, speed, time, unit)


def _velocities(recording: Recording) -> Iterator[tuple[str, np.ndarray, str]]:
    for agent in recording.agents:
        yield agent, recording.qd[agent], "m/s or rad/s"
    for obj in recording.objects:
        yield obj, recording.velocity[obj][:, :3], "rad/s"
        yield obj, np.linalg.norm(recording.velocity[obj][:, 3:], axis=1, keepdims=True), "m/s"
