"""Positions and velocities belong together: nothing is at one place now and at another at the next sample.

The plant steps x_{k+1} = x_k + dt v_{k+1} (semi-implicit Euler), so recorded positions must follow from recorded
velocities to rounding. What jumps, stands still while its velocity says otherwise, or has its velocities removed, was
not simulated.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.verification.data import SAME_INSTANT
from drake_ltl.verification.poses import rotations
from drake_ltl.verification.spans import Span
from drake_ltl.verification.violations import Violation, where_bad

ROUNDING = 1e-6
"""Way between two samples that no velocity needs to explain [m, rad]."""


INSTANT_ROUNDING = 1e-12
"""... and between two samples of one instant: else any number of them would add up to a way."""
FASTEST = 50.0
"""No joint and no object is faster than this [m/s, rad/s]: robots leave narrow places at ten or so."""


def motion_violations(recording: Recording, spans: Sequence[Span]) -> Iterator[Violation]:
    """Members that are not where their velocities bring them, or too fast for any machine."""
    for name, velocity in (recording.qd | recording.velocity).items():
        speed = np.abs(velocity).max(axis=1, initial=0.0)
        for span in spans:
            what = f"{name} is faster than {FASTEST:g} m/s or rad/s"
            violation = Violation("motion", (name,), what, step=span.number)
            yield from where_bad(violation, speed[span.own] > FASTEST, speed[span.own], recording.time[span.own])
    gaps = {name: (_gap(recording, name), None) for name in recording.agents}
    gaps |= {name: (_gap(recording, name), _turn_gap(recording, name)) for name in recording.objects}
    allowed = np.where(np.diff(recording.time, prepend=-np.inf) > SAME_INSTANT, ROUNDING, INSTANT_ROUNDING)
    for name, (gap, turn_gap) in gaps.items():
        for off, unit in ((gap, "m"), (turn_gap, "rad")):
            if off is not None:
                yield from _in_steps(recording, spans, name, off, allowed, unit)


def _in_steps(
    recording: Recording, spans: Sequence[Span], name: str, off: np.ndarray, allowed: np.ndarray, unit: str
) -> Iterator[Violation]:
    for span in spans:
        rows = slice(span.first + 1, span.end + 1)  # the row of a step's first sample belongs to the step before
        violation = Violation(
            "motion", (name,), f"{name} is not where its velocity brings it", step=span.number, unit=unit
        )
        yield from where_bad(violation, off[rows] > allowed[rows], off[rows], recording.time[rows])


def _gap(recording: Recording, name: str) -> np.ndarray:
    """(T,) largest |x_k - x_{k-1} - dt v_k| over a member's joints [m or rad], or of an object's origin [m]."""
    agent = name in recording.agents
    x = recording.q[name] if agent else recording.pose[name][:, 4:]
    v = recording.qd[name] if agent else recording.velocity[name][:, 3:]
    dt = np.diff(recording.time)
    gap = np.abs(np.diff(x, axis=0) - dt[:, None] * v[1:]).max(axis=1, initial=0.0)
    return np.concatenate([[0.0], gap])


def _turn_gap(recording: Recording, name: str) -> np.ndarray:
    """(T,) [rad] between the recorded turn of an object and omega dt.

    A normalised first-order step of a quaternion turns by 2 atan(omega dt / 2); the difference, (omega dt)^3 / 12 and
    less, is not counted.
    """
    turned = rotations(recording.pose[name])
    between = (turned[1:] * turned[:-1].inv()).as_rotvec()
    expected = np.diff(recording.time)[:, None] * recording.velocity[name][1:, :3]
    allowed = np.linalg.norm(expected, axis=1) ** 3 / 12.0
    gap = np.linalg.norm(between - expected, axis=1) - allowed
    return np.concatenate([[0.0], np.maximum(gap, 0.0)])
