"""When faults of the scenario had happened by the recorded times, whatever the run's own record says of them."""

from __future__ import annotations

import math

from drake_ltl.execution.recording import Recording
from drake_ltl.scenario.faults import Fault
from drake_ltl.scenario.model import Scenario

NAMELESS = ("blocked_region", "sensors")
"""Kinds that befall no agent and no object. They move nothing by themselves: controllers do."""
COMES_WITHIN = 0.05
"""After so long a fault that is due has come [s]: one that waits for a step is looked for every 20 ms."""


def since(fault: Fault, recording: Recording) -> float:
    """When it happens at the earliest [s]; infinite if the run does not come so far."""
    if fault.step is None:
        return 0.0 if fault.time is None else fault.time
    return recording.steps[fault.step - 1].start if fault.step <= len(recording.steps) else math.inf


def befallen(recording: Recording, scenario: Scenario, kind: str) -> dict[str, float]:
    """Whom faults of a kind befall -> since when at the earliest [s]."""
    found: dict[str, float] = {}
    for fault in scenario.faults:
        if fault.kind == kind and fault.who is not None:
            found[fault.who] = min(since(fault, recording), found.get(fault.who, math.inf))
    return found


def moved_since(recording: Recording, scenario: Scenario) -> float:
    """Since when at the earliest faults may have moved bodies [s]; infinite if none can."""
    times = (since(fault, recording) for fault in scenario.faults if fault.kind not in NAMELESS)
    return min(times, default=math.inf)
