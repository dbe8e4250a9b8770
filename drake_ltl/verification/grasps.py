"""Grasps: made, held and let go exactly as the actions say, and firmly."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from drake_ltl.execution.recording import NOTHING, Recording
from drake_ltl.scenario.model import Tolerances
from drake_ltl.verification import poses
from drake_ltl.verification.expected import Expected
from drake_ltl.verification.mechanics import Mechanics
from drake_ltl.verification.poses import matrices
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
        allowed = [old, new]
        if span.halted:  # in safe mode who holds, or has just grasped, lets go
            allowed += [NOTHING, _index(recording, roles.grasping.get(agent))]
        stray = np.flatnonzero(~np.isin(welded, allowed))
        switches = np.flatnonzero(np.diff(welded)) + 1
        if len(stray):
            what = f"{agent} is welded to {_named(recording, welded[stray[0]])} instead of {_named(recording, old)}"
            yield Violation("grasp", (agent,), what, float(time[stray[0]]), span.number)
        elif len(switches) > 1 and not (span.halted and _grasps_and_lets_go(welded[[0, *switches]])):
            what = f"{agent} changes its grasp {len(switches)} times in one step"
            yield Violation("grasp", (agent,), what, float(time[switches[1]]), span.number)
        elif span.finished and not span.halted and old != new and welded[-1] == old:
            verb = "grasped" if agent in roles.grasping else "released"
            what = f"{agent} has not {verb} {recording.objects[max(old, new)]}"
            yield Violation("grasp", (agent,), what, float(time[-1]), span.number)


def _grasps_and_lets_go(welded: np.ndarray) -> bool:
    """Whether somebody who holds nothing grasps, and lets go in safe mode: who has let go grasps nothing again."""
    return len(welded) == 3 and welded[0] == welded[2] == NOTHING


@dataclass(frozen=True)
class WeldErrors:
    """How well grippers keep to what they are welded to; zero while they are not."""

    gap: np.ndarray
    """(T, N) [m] between the gripper's frame and the grasp frame on the object."""
    angle: np.ndarray
    """(T, N) [rad]"""
    open: np.ndarray
    """(T, N) whether a grasp that a fault has broken holds no longer, whatever is recorded."""


def weld_errors(
    recording: Recording, mechanics: Mechanics, spans: Sequence[Span], breaks: Mapping[str, float]
) -> WeldErrors:
    """Worked out from joints and poses. A grasp frame is any turn of the object's ring frame about its axis; which
    one is held shows when the weld begins.

    Args:
        breaks: agent -> since when a fault may have broken its grasp [s]; in a step that is halted for it nothing is
            said of it from then on.
    """
    gap, angle = np.zeros(recording.grasp.shape), np.zeros(recording.grasp.shape)
    opened = np.zeros(recording.grasp.shape, dtype=bool)
    for column, agent in enumerate(recording.agents):
        for rows in _holds(recording, column):
            obj = recording.objects[recording.grasp[rows.start, column]]
            X_OE = np.linalg.inv(matrices(recording.pose[obj][rows])) @ mechanics.gripper[agent][rows]
            X_OR = _nearest_on_ring(mechanics.ring[obj], X_OE[0])
            gap[rows, column] = np.linalg.norm(X_OE[:, :3, 3] - X_OR[:3, 3], axis=1)
            angle[rows, column] = poses.angle(X_OR[:3, :3].T @ X_OE[:, :3, :3])
    for name, since in breaks.items():
        column, broken = recording.agents.index(name), int(np.searchsorted(recording.time, since))
        for span in (span for span in spans if span.halted and name in span.faulty):
            rows = slice(max(span.first, broken), span.last + 1)
            gapes = (gap[rows, column] > HELD_GAP) | (angle[rows, column] > HELD_ANGLE)
            opened[rows, column] = np.maximum.accumulate(gapes)
            gap[rows, column] = angle[rows, column] = 0.0
        first = next((hold for hold in _holds(recording, column) if hold.stop > broken), slice(0))
        opened[max(first.start or 0, broken) : first.stop, column] = True
    return WeldErrors(gap, angle, opened)


def _holds(recording: Recording, column: int) -> Iterator[slice]:
    """The samples of each grasp that an agent makes."""
    held = recording.grasp[:, column]
    bounds = [0, *(np.flatnonzero(np.diff(held)) + 1).tolist(), len(held)]
    return (slice(first, after) for first, after in pairwise(bounds) if held[first] != NOTHING)


def _nearest_on_ring(X_OG: np.ndarray, X_OE: np.ndarray) -> np.ndarray:
    """The grasp frame at the gripper's azimuth; a parallel gripper may be turned by half a turn about its own z."""
    azimuth = np.arctan2(X_OE[1, 3], X_OE[0, 3]) - np.arctan2(X_OG[1, 3], X_OG[0, 3])
    frames = [_turn(azimuth) @ X_OG @ _turn(flip) for flip in (0.0, np.pi)]
    return min(frames, key=lambda X_OR: poses.angle(X_OR[:3, :3].T @ X_OE[:3, :3]))


def _turn(angle: float) -> np.ndarray:
    X = np.eye(4)
    X[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return X


def weld_violations(
    recording: Recording, errors: WeldErrors, span: Span, tolerances: Tolerances
) -> Iterator[Violation]:
    """Welds that gape. None counts as open at what the scenario lets it be made with."""
    time = recording.time[span.own]
    limits = (
        (errors.gap, max(HELD_GAP, tolerances.weld_position), "m", "mm", 1e3),
        (errors.angle, max(HELD_ANGLE, tolerances.weld_angle), "rad", "degrees", 180.0 / np.pi),
    )
    for column, agent in enumerate(recording.agents):
        for error, limit, unit, shown_in, scale in limits:
            what = f"the weld of {agent} is off by more than {scale * limit:.3g} {shown_in}"
            violation = Violation("weld", (agent,), what, step=span.number, unit=unit)
            off = error[span.own, column]
            yield from where_bad(violation, off > limit, off, time)


def _index(recording: Recording, obj: str | None) -> int:
    return NOTHING if obj is None else recording.objects.index(obj)


def _named(recording: Recording, index: int) -> str:
    return "nothing" if index == NOTHING else recording.objects[index]
