"""Carriers that are of no team any more before their step ends."""

from __future__ import annotations

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.verification.roles import Roles
from drake_ltl.verification.spans import Span


def freed(recording: Recording, span: Span, roles: Roles, opened: np.ndarray) -> dict[str, int]:
    """Who carries in a step that a fault has halted, and from which sample on not any more: it has let go in safe mode,
    or its grasp is broken. From then on it is a body like any other.

    Args:
        opened: (T, N), see `grasps.WeldErrors.open`.
    """
    found: dict[str, int] = {}
    for mover in roles.transports if span.halted else ():
        for agent in mover.team:
            column = recording.agents.index(agent)
            held = (recording.grasp[:, column] == recording.objects.index(mover.name)) & ~opened[:, column]
            if not held[span.own].all():
                found[agent] = span.first + int(np.argmin(held[span.own]))
    return found
