"""What one run came to, small enough to be kept for thousands of runs, as data and as JSON."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from drake_ltl.execution.recording import Recording
from drake_ltl.sweep.drawing import Drawn, drawn_from_json
from drake_ltl.verification.verdict import Verdict

SATISFIED = "satisfied"
VIOLATED = "violated"
"""Carried out to its end, and something did not hold."""
STALLED = "stalled"
"""Ended early: a step took too long, or a check failed."""
NO_PLAN = "no plan"
FAILED = "failed"
"""There is no verdict: an error, or a worker that ended in every attempt."""
STATUSES = (SATISFIED, VIOLATED, STALLED, NO_PLAN, FAILED)

BODIES = ("agent_agent", "agent_object", "object_object", "team_other")
"""Clearances that are lost in a collision; the others are those from regions and from the workspace's border."""


@dataclass(frozen=True)
class Outcome:
    """One line of a sweep's journal. Numbers are None where there is none."""

    run: int
    status: str
    reason: str = ""
    """The first violation, or why there is no verdict; empty if satisfied."""
    drawn: Drawn | None = None
    """None where it is not known: a worker that ended told nothing."""
    cost: float | None = None
    """J of the plan."""
    durations: tuple[float, ...] = ()
    """Of finished steps [s]."""
    detours: int = 0
    """Steps in which movers stalled and were led around."""
    simulated_seconds: float | None = None
    min_clearance: Mapping[str, float | None] = field(default_factory=dict)
    """Kind -> least of the run [m], see `verification.clearances`."""
    max_lyapunov_increase: float | None = None
    max_weld_error: float | None = None
    """[m]"""
    max_tilt: float | None = None
    """[rad]"""
    wall_seconds: float | None = None
    """Planning, simulation and verdict by the worker's clock: the one number that differs from time to time."""

    @property
    def collided(self) -> bool:
        """Whether bounding spheres touched."""
        clearances = (self.min_clearance.get(kind) for kind in BODIES)
        return any(clearance is not None and clearance <= 0.0 for clearance in clearances)


def judged(
    number: int, drawn: Drawn, cost: float, recording: Recording, verdict: Verdict, wall_seconds: float
) -> Outcome:
    """The outcome of a run that was carried out, to its end or not."""
    status = SATISFIED if verdict.satisfied else VIOLATED if recording.completed else STALLED
    return Outcome(
        run=number,
        status=status,
        reason=_reason(status, recording, verdict),
        drawn=drawn,
        cost=cost,
        durations=tuple(float(step.duration) for step in verdict.steps if step.finished),
        detours=len(verdict.detours),
        simulated_seconds=_finite(verdict.simulated_seconds),
        min_clearance={kind: _finite(value) for kind, value in verdict.min_clearance.items()},
        max_lyapunov_increase=_finite(verdict.max_lyapunov_increase),
        max_weld_error=_finite(verdict.max_weld_error),
        max_tilt=_finite(verdict.max_tilt),
        wall_seconds=wall_seconds,
    )


def _reason(status: str, recording: Recording, verdict: Verdict) -> str:
    if status == STALLED:
        return f"the run ended early: {recording.reason or 'no reason is recorded'}"
    first, more = "".join(map(str, verdict.violations[:1])), len(verdict.violations) - 1
    return f"{first} (and {more} more)" if more > 0 else first


def outcome_to_json(outcome: Outcome) -> dict[str, Any]:
    """Plain maps, lists, texts and finite numbers."""
    return dataclasses.asdict(outcome)


def outcome_from_json(data: Mapping[str, Any]) -> Outcome:
    """The inverse of `outcome_to_json`, after a way through JSON. Raises what malformed data cause."""
    drawn = data["drawn"] and drawn_from_json(data["drawn"])
    if not isinstance(data["run"], int) or data["status"] not in STATUSES:
        raise ValueError("neither the number of a run nor a status")
    return Outcome(**{**data, "drawn": drawn, "durations": tuple(data["durations"])})


def _finite(number: float | None) -> float | None:
    return None if number is None or not math.isfinite(number) else float(number)
