"""Objects stay where they are put: nothing moves or turns them but those that carry them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.scenario.model import Tolerances
from drake_ltl.verification.left_alone import BRAKING
from drake_ltl.verification.poses import rotations
from drake_ltl.verification.roles import Roles
from drake_ltl.verification.spans import Span
from drake_ltl.verification.violations import Violation, where_bad

DRIFT = 2e-3
"""Way of an object that is not carried [m]: what welds made at 1 mm pull it, and contact lets it creep."""
STOPPING_TIME = 0.25
"""What is still moving, at the tolerated speed, when its transport ends, stops within this time [s]."""
TURN = np.deg2rad(1.0)
"""Turn of an object that is not carried [rad]."""
SETTLING = 0.05
"""Way of what is let go of in a step that a fault has halted [m]: with a grasp broken it hangs askew ...; the way down
on which others of its team set it down is none."""
SETTLING_TURN = np.deg2rad(10.0)
"""... and comes to stand by itself [rad]."""


def broken_grasp_violations(recording: Recording, opened: np.ndarray, span: Span, roles: Roles) -> Iterator[Violation]:
    """Transports that go on after a fault has broken a grasp: with the team none any more, all brake.

    Args:
        opened: (T, N), see `grasps.WeldErrors.open`.
    """
    for mover in roles.transports:
        columns = [recording.agents.index(agent) for agent in mover.team]
        none_any_more = opened[span.own][:, columns].any(axis=1)
        rows = slice(span.first + int(np.argmax(none_any_more)), span.end + 1)
        position = recording.pose[mover.name][rows, 4:]
        way = np.linalg.norm(position - position[0], axis=1) * none_any_more.any()
        what = f"{mover.name} moves by more than {100 * BRAKING:.3g} cm after a grasp of it has broken"
        violation = Violation("object", (mover.name,), what, step=span.number, unit="m")
        yield from where_bad(violation, way > BRAKING, way, recording.time[rows])


def object_violations(
    recording: Recording,
    spans: Sequence[Span],
    roles: Sequence[Roles],
    tolerances: Tolerances,
    pushed: Mapping[str, float],
    breaks: Collection[str] = (),
) -> Iterator[Violation]:
    """Judged against the pose in which the object was last put down, so that creeping adds up.

    Args:
        pushed: object -> since when a fault may have pushed it [s]; in a step that is halted for it, it may move.
        breaks: agents whose grasps a fault may have broken; in a step that is halted for it they hold nothing up.
    """
    usual = DRIFT + STOPPING_TIME * tolerances.speed
    for obj in recording.objects:
        put = 0
        for span, step in zip(spans, roles, strict=True):
            first, end, settles = span.first, span.end, span.halted and obj in step.carried
            limit, most = (SETTLING, SETTLING_TURN) if settles else (usual, TURN)
            if obj in step.carried:
                first = put = _let_go(recording, obj, span, step)
            elif span.halted and obj in span.faulty and pushed.get(obj, np.inf) <= recording.time[span.end]:
                end = int(np.searchsorted(recording.time, pushed[obj])) - 1  # from then on see `pushes`
            time, pose = recording.time[first : end + 1], recording.pose[obj][first : end + 1]
            off = pose[:, 4:] - recording.pose[obj][put, 4:]
            if settles:
                broken = set(span.faulty).intersection(breaks)
                off[:, 2] = _risen_or_fallen(recording, obj, slice(first, end + 1), broken)
            way = np.linalg.norm(off, axis=1)
            what = f"{obj} moves by more than {1e3 * limit:.3g} mm though nobody carries it"
            yield from where_bad(Violation("object", (obj,), what, step=span.number, unit="m"), way > limit, way, time)
            turn = _angle(pose[:, :4], recording.pose[obj][put, :4])
            what = f"{obj} turns by more than {np.rad2deg(most):.3g} degrees though nobody carries it"
            yield from where_bad(
                Violation("object", (obj,), what, step=span.number, unit="rad"), turn > most, turn, time
            )
            put = span.end if settles or end < span.end else put


def _let_go(recording: Recording, obj: str, span: Span, step: Roles) -> int:
    """The sample at which a team is none any more: somebody has let go in safe mode, where all rest; else the end."""
    (team,) = (mover.team for mover in step.transports if mover.name == obj)
    columns = [recording.agents.index(agent) for agent in team]
    held = (recording.grasp[span.own][:, columns] == recording.objects.index(obj)).all(axis=1)
    return span.end if not span.halted or held.all() else span.first + int(np.argmin(held))


def _risen_or_fallen(recording: Recording, obj: str, rows: slice, broken: Collection[str]) -> np.ndarray:
    """(n,) [m] what an object has risen since somebody of its team let go of it, while others hold it whose grasp is
    not broken, for they may set it down; then how much higher or lower it is than where the last one let go."""
    z = recording.pose[obj][rows, 6]
    sound = [column for column, agent in enumerate(recording.agents) if agent not in broken]
    held = np.flatnonzero((recording.grasp[rows][:, sound] == recording.objects.index(obj)).any(axis=1))
    last = int(held[-1]) if len(held) else 0
    return np.where(np.arange(len(z)) < last, np.maximum(z - z[0], 0.0), z - z[last])


def largest_tilt(recording: Recording) -> float:
    """Largest angle [rad] between the vertical and the axis of an object that was vertical when the run began."""
    up = np.array([0.0, 0.0, 1.0])
    upright = [
        (turned := rotations(pose)).apply(turned[0].inv().apply(up))[:, 2].min() for pose in recording.pose.values()
    ]
    return float(np.arccos(np.clip(min(upright, default=1.0), -1.0, 1.0)))


def _angle(quaternions: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """(n,) [rad] between each orientation (n, 4) and the reference (4,)."""
    cosine = np.abs(quaternions @ reference) / (np.linalg.norm(quaternions, axis=1) * np.linalg.norm(reference))
    return 2.0 * np.arccos(np.clip(cosine, 0.0, 1.0))
