"""Radii that a scenario leaves open are those of its models, which cover the bodies in every posture."""

from __future__ import annotations

from collections.abc import Iterator

from drake_ltl.execution.recording import Recording
from drake_ltl.verification.mechanics import Mechanics
from drake_ltl.verification.violations import Violation

ROUNDING = 2e-3
"""A recorded radius may be this much smaller [m]: some are searched for, all rounded to millimetres."""


def radius_violations(recording: Recording, mechanics: Mechanics) -> Iterator[Violation]:
    """Agents and objects whose recorded spheres are smaller than their models, in whatever posture they are seen."""
    recorded = recording.agent_radius | recording.object_radius
    for name, measured in mechanics.measured_radius.items():
        short = measured - recorded[name]
        if short > ROUNDING:
            what = f"the recorded radius of {name}, {recorded[name]:.4g} m, is smaller than its model's"
            yield Violation("body", (name,), what, worst=short, unit="m")
