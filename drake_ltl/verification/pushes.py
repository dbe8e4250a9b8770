"""Objects that a fault pushes: as fast as its impulse makes them, and slower from then on.

Nothing else gives energy to an object that nobody holds: but where it is pushed, its kinetic energy and m g z may only
fall. A crate that has come to rest on an edge may rock.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.scenario.model import Scenario
from drake_ltl.verification.befallen import COMES_WITHIN, since
from drake_ltl.verification.mechanics import Mechanics
from drake_ltl.verification.roles import Roles
from drake_ltl.verification.spans import Span
from drake_ltl.verification.violations import Violation, where_bad

G = 9.81
"""[m/s^2]"""
UNNOTICED = 0.05
"""Speed that nobody notices [m/s]. A crate's that was pushed rose by 1.4 mm/s as it came to rest."""


def push_violations(
    recording: Recording, scenario: Scenario, mechanics: Mechanics, spans: Sequence[Span], roles: Sequence[Roles]
) -> Iterator[Violation]:
    """Objects that are faster than their pushes explain, in steps that are halted because they moved by themselves."""
    for span, step in zip(spans, roles, strict=True):
        for obj in [name for name in recording.objects if name in span.faulty and name not in step.carried]:
            pushes = _pushes(recording, scenario, mechanics, obj)
            speed = np.linalg.norm(recording.velocity[obj][span.samples, 3:], axis=1)
            time, height = recording.time[span.samples], G * recording.pose[obj][span.samples, 6]
            energy = mechanics.kinetic[obj][span.samples] / mechanics.mass[obj] + height
            most = explained(pushes, time, speed, energy, height) + UNNOTICED
            what = f"{obj} is faster than its push explains"
            violation = Violation("object", (obj,), what, step=span.number, unit="m/s")
            yield from where_bad(violation, speed > most, speed, time)


def _pushes(recording: Recording, scenario: Scenario, mechanics: Mechanics, obj: str) -> list[tuple[float, float]]:
    """(since when at the earliest [s], by how much faster it makes the object [m/s]), in order of time."""
    own = [fault for fault in scenario.faults if fault.who == obj]
    mass = mechanics.mass[obj] * math.prod(fault.values["factor"] for fault in own if fault.kind == "mass")
    return sorted(
        (since(fault, recording), math.hypot(*fault.values["impulse"]) / mass) for fault in own if fault.kind == "push"
    )


def explained(
    pushes: Sequence[tuple[float, float]], time: np.ndarray, speed: np.ndarray, energy: np.ndarray, height: np.ndarray
) -> np.ndarray:
    """(n,) how fast an object can be [m/s]; infinite before the first push, for which others answer.

    Args:
        pushes: (when [s], by how much faster it makes the object [m/s]), in order of time.
        time: (n,) [s].
        speed: (n,) [m/s].
        energy: (n,) all its energy, for each kg [J/kg].
        height: (n,) of this what its height makes [J/kg].
    """
    most = np.full(len(time), np.inf)
    bounds = [*np.searchsorted(time, [when for when, _ in pushes]).tolist(), len(time)]
    for number, (first, after) in enumerate(pairwise(bounds)):
        if first < after:
            faster = sum(by for _, by in pushes[: number + 1])
            at_once = energy[first] + speed[first] * faster + 0.5 * faster**2
            has_come = time[first:after] >= pushes[number][0] + COMES_WITHIN
            least = np.minimum.accumulate(np.where(has_come, energy[first:after], at_once))
            most[first:after] = np.sqrt(2.0 * np.maximum(least - height[first:after], 0.0))
    return most
