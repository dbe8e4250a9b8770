"""Grasps: made, held and let go exactly as the actions say, and firmly."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drake_ltl.execution.recording import NOTHING, Recording
from drake_ltl.scenario.model import Tolerances
from drake_ltl.verification.expected import Expected
from drake_ltl.verification.roles import Roles
from drake_ltl.verification.spans import Span
from drake_ltl.verification.violations import Violation, where_bad

HELD_GAP = 3e-3
"""Farther apart a grasp does not count as held [m]. Welds are made at 1 mm and are slightly soft: dozens of newtons
open them by tenths of a millimetre. A gripper that slips is centimetres off at once."""
HELD_ANGLE = np.deg2rad(0.5)
"""... or turned by more [rad]; welds are made at 0.1 degree."""


def grasp_violations(
    recording: Recording, span: Span, roles: Roles, before: Expected, after: Expected
) -> Iterator[Violation]:
    """Who is welded to what during one step: AG_{i,j} of Defs. 2 to 4."""
    time = recording.time[span.own]
    for column, agent in enumerate(recording.agents):
        welded = recording.grasp[span.own, column]
        old, new = (_index(recording, expected.grasps[agent]) for expected in (before, after))
        stray = np.flatnonzero(~np.isin(welded, (old, new)))
        switches = np.flatnonzero(np.diff(welded)) + 1
        if len(stray):
            what = f"{agent} is welded to {_named(recording, welded[stray[0]])} instead of {_named(recording, old)}"
            yield Violation("grasp", (agent,), what, float(time[stray[0]]), span.number)
        elif len(switches) > 1:
            what = f"{agent} changes its grasp {len(switches)} times in one step"
            yield Violation("grasp", (agent,), what, float(time[switches[1]]), span.number)
        elif span.finished and old != new and welded[-1] == old:
            verb = "grasped" if agent in roles.grasping else "released"
            what = f"{agent} has not {verb} {recording.objects[max(old, new)]}"
            yield Violation("grasp", (agent,), what, float(time[-1]), span.number)


def weld_violations(recording: Recording, span: Span, tolerances: Tolerances) -> Iterator[Violation]:
    """Welds that gape. None counts as open at what the scenario lets it be made with."""
    time = recording.time[span.own]
    limits = (
        (recording.weld_gap, max(HELD_GAP, tolerances.weld_position), "m", "mm", 1e3),
        (recording.weld_angle, max(HELD_ANGLE, tolerances.weld_angle), "rad", "degrees", 180.0 / np.pi),
    )
    for column, agent in enumerate(recording.agents):
        welded = recording.grasp[span.own, column] != NOTHING
        for error, limit, unit, shown_in, scale in limits:
            what = f"the weld of {agent} is off by more than {scale * limit:.3g} {shown_in}"
            violation = Violation("weld", (agent,), what, step=span.number, unit=unit)
            off = error[span.own, column]
            yield from where_bad(violation, welded & (off > limit), off, time)


def largest_weld_error(recording: Recording, error: np.ndarray) -> float:
    """Of `weld_gap` [m] or `weld_angle` [rad] over all that is welded; 0 if nothing ever is."""
    return float(error[recording.grasp != NOTHING].max(initial=0.0))


def _index(recording: Recording, obj: str | None) -> int:
    return NOTHING if obj is None else recording.objects.index(obj)


def _named(recording: Recording, index: int) -> str:
    return "nothing" if index == NOTHING else recording.objects[index]
