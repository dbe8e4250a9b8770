"""Differential drives: they move along their headings alone, and arrive with those that the scenario says."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.scenario.model import Scenario
from drake_ltl.verification.roles import Roles
from drake_ltl.verification.spans import Span
from drake_ltl.verification.violations import Violation, where_bad

SLIDE = 0.01
"""Speed across the heading [m/s]: what regularised friction lets creep is a thousandth of it."""
YAW = 2
"""Place of the heading in q, behind x and y."""


def slides(recording: Recording, scenario: Scenario) -> dict[str, np.ndarray]:
    """Drive -> its speed across its heading (T,) [m/s].

    Across the heading at the begin of each step of the plant: that is what tyres' friction acts on; by its end the
    heading has turned.
    """
    return {name: _slide(recording.q[name], recording.qd[name]) for name in _drives(scenario)}


def _slide(q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    heading = np.concatenate([q[:1, YAW], q[:-1, YAW]])
    return np.abs(np.cos(heading) * qd[:, 1] - np.sin(heading) * qd[:, 0])


def arrival_turns(
    recording: Recording, scenario: Scenario, spans: Sequence[Span], roles: Sequence[Roles]
) -> dict[tuple[int, str], float]:
    """(step, drive) -> angle [rad] at the end of its travel from the heading that it should have there."""
    drives, turns = _drives(scenario), {}
    for span, step in zip(spans, roles, strict=True):
        for travel in step.travels if span.finished and not span.halted else ():
            if travel.name in drives:
                agent = drives[travel.name]
                should = agent.headings.get(travel.goal, agent.heading)
                turn = recording.q[agent.name][span.end, YAW] - should
                turns[span.number, agent.name] = float(abs(np.angle(np.exp(1j * turn))))
    return turns


def drive_violations(
    recording: Recording,
    scenario: Scenario,
    spans: Sequence[Span],
    aside: dict[str, np.ndarray],
    turns: dict[tuple[int, str], float],
) -> Iterator[Violation]:
    """Drives that slide, and drives that do not face as they should when they have arrived."""
    for span in spans:
        time = recording.time[span.own]
        for name, speed in aside.items():
            violation = Violation("drive", (name,), f"{name} moves across its heading", step=span.number, unit="m/s")
            yield from where_bad(violation, speed[span.own] > SLIDE, speed[span.own], time)
            if (span.number, name) in turns:
                off = np.array([turns[span.number, name]])
                what = f"{name} does not face as it should where it arrives"
                violation = Violation("drive", (name,), what, step=span.number, unit="rad")
                end = recording.time[span.end : span.end + 1]
                yield from where_bad(violation, off > turn_limit(scenario), off, end)


def turn_limit(scenario: Scenario) -> float:
    """Of `arrival_turns` [rad]: travels end with joints within the tolerance; what still turns then creeps on."""
    return scenario.tolerances.joint + CREEP


CREEP = 2e-3
"""Between the look that ends a step and the step's last sample [rad]."""


def _drives(scenario: Scenario) -> dict:
    return {agent.name: agent for agent in scenario.agents if not agent.has_arm}
