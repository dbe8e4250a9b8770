"""The judgement of a run as data, and as JSON."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from drake_ltl.execution.recording import StepRecord
from drake_ltl.execution.recording_versions import VERSION
from drake_ltl.scenario.model import Scenario
from drake_ltl.shown import Shown
from drake_ltl.verification.violations import Violation

if TYPE_CHECKING:
    from rich.console import RenderableType

JSON_CLEARANCES = ("agent_agent", "agent_object", "team_other", "forbidden_region")


@dataclass(frozen=True)
class Verdict(Shown):
    """Whether a run did what its scenario demands, and the numbers that show how well."""

    satisfied: bool
    violations: tuple[Violation, ...]
    """In order of time; empty iff satisfied."""
    word: tuple[tuple[str, ...], ...]
    """One letter for the start and one for each finished step: `member.proposition`, sorted."""
    steps: tuple[StepRecord, ...]
    min_clearance: Mapping[str, float | None]
    """Least clearance of each of `clearances.KINDS` [m]; None where the run has no such pair."""
    max_lyapunov_increase: float
    """Largest rise of V above its lowest value so far, relative to V at the begin of its (step, phase)."""
    max_weld_error: float
    """Largest gap of a weld [m]."""
    max_weld_angle: float
    """[rad]"""
    max_tilt: float
    """Largest angle between the vertical and an object's axis that was vertical at the start [rad]."""
    simulated_seconds: float
    detours: tuple[int, ...] = ()
    """Numbers of the steps in which movers stalled and were led around, one by one."""
    max_effort: Mapping[str, float] = field(default_factory=dict)
    """agent -> largest torque asked of a joint, relative to its effort limit; beyond 1 the plant cut it off, and the
    motion was not that of the control laws."""
    min_manipulability: Mapping[str, float] = field(default_factory=dict)
    """agent -> least manipulability on its way; 0 is a kinematic singularity."""
    min_inside_teams: float | None = None
    """Least signed distance between the collision geometries of an object and those who grasp it, and between these
    [m], grippers against handles excepted; None if nobody grasps."""
    max_heading_error: float | None = None
    """Largest angle of an object from how it should stand at the end of a transport [rad]; None without transports."""
    max_arrival_turn: float | None = None
    """Largest angle of a differential drive from its heading where it arrives [rad]; None if none travels."""
    max_slide: float | None = None
    """Largest speed of a differential drive across its heading [m/s]; None without any."""
    exchanges: tuple[int, ...] = ()
    """Numbers of the steps in which movers stalled and took each other's places."""
    version_of_V: int = VERSION
    """Version of recordings whose V was judged: today's, or that of the time in which an older file was written."""
    scenario: Scenario | None = field(default=None, compare=False)
    """What was demanded, as far as it is known: tables show it."""

    def __repr__(self) -> str:
        count = len(self.violations)
        head = "satisfied" if self.satisfied else f"violated {count} time{'s' * (count != 1)}"
        return f"Verdict({head}, {len(self.steps)} steps, {self.simulated_seconds:.1f} s simulated)"

    def __rich__(self) -> RenderableType:
        from drake_ltl.verification.table import verdict_table

        return verdict_table(self, self.scenario)


def to_json(verdict: Verdict, wall_seconds: float | None = None) -> dict[str, Any]:
    """What `simulate --json` writes. Numbers that are not known or not finite are null.

    Args:
        wall_seconds: how long the run took by the wall's clock, which no recording knows.
    """
    faster = verdict.simulated_seconds / wall_seconds if wall_seconds else None
    return {
        "satisfied": verdict.satisfied,
        "violations": [str(violation) for violation in verdict.violations],
        "word": [list(letter) for letter in verdict.word],
        "steps": [
            {"actions": [dict(action) for action in step.actions], "start": step.start, "duration": step.duration}
            for step in verdict.steps
        ],
        "min_clearance": {kind: _finite(verdict.min_clearance[kind]) for kind in JSON_CLEARANCES},
        "max_lyapunov_increase": _finite(verdict.max_lyapunov_increase),
        "max_weld_error": _finite(verdict.max_weld_error),
        "simulated_seconds": _finite(verdict.simulated_seconds),
        "wall_seconds": _finite(wall_seconds),
        "realtime_factor": _finite(faster),
    }


def _finite(number: float | None) -> float | None:
    return None if number is None or not math.isfinite(number) else float(number)
