"""Clearances over time as the verdict sees them, for drawing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.scenario.model import Scenario
from drake_ltl.verification.clearances import step_clearances
from drake_ltl.verification.expected import Expected, expectations
from drake_ltl.verification.regions import found_at
from drake_ltl.verification.roles import step_roles
from drake_ltl.verification.spans import step_spans


@dataclass(frozen=True)
class Curve:
    """The smallest clearance of one kind during one step."""

    kind: str
    """One of `drake_ltl.verification.clearances.KINDS`."""
    time: np.ndarray
    """(n,) [s]"""
    value: np.ndarray
    """(n,) [m]"""


def clearance_curves(recording: Recording, scenario: Scenario) -> list[Curve]:
    """A curve for each step and each kind of which there is a pair; their minima are those of the verdict."""
    return list(_curves(recording, scenario)) if len(recording.time) else []


def _curves(recording: Recording, scenario: Scenario) -> Iterator[Curve]:
    spans = step_spans(recording)
    # Of what stands where, clearances ask only who grasps what.
    start = Expected(*map(dict.fromkeys, (recording.agents, recording.objects, recording.agents)))
    opened = np.zeros(recording.grasp.shape, dtype=bool)  # only the models know of grasps that are broken
    expected = expectations(start, spans, lambda sample: found_at(recording, scenario, sample))
    for before, span in zip(expected, spans, strict=False):
        least: dict[str, np.ndarray] = {}
        for clearance in step_clearances(recording, scenario, span, step_roles(before, span), opened):
            known = least.get(clearance.kind, clearance.value)
            least[clearance.kind] = np.minimum(known, clearance.value)
        for kind, value in least.items():
            yield Curve(kind, recording.time[span.samples], value)
