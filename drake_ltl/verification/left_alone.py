"""Nobody moves by itself: a navigation function moves it, or it stands, but for the way between stand-off and grasp.

Without this V could be made to fall by leaving out who moves.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.verification.freed import freed
from drake_ltl.verification.regions import centres, radius
from drake_ltl.verification.roles import Roles
from drake_ltl.verification.spans import Span, interval_samples
from drake_ltl.verification.violations import Violation, where_bad

STAND = 0.06
"""How far somebody goes while no navigation function moves it: it brakes, and is let go or held [m]."""
BRAKING = 0.5
"""... and if a fault halts its step: at 2 m/s a hold brakes within 20 cm, a fault can be noticed late [m]."""
APPROACH = 0.25
"""... on the straight way between stand-off and grasp, for which a gripper needs so much [m] ..."""
GAP = 0.07
"""... or more, so that the spheres of agent and object are apart by so much at the stand-off [m] ..."""
SLANT = 1.2
"""... if it is straight from where it holds. It leads past the object's axis where a gripper points beside it."""


def left_alone_violations(
    recording: Recording,
    spans: Sequence[Span],
    roles: Sequence[Roles],
    opened: np.ndarray,
    stopped: Mapping[str, float],
) -> Iterator[Violation]:
    """Who moves without a navigation function.

    Args:
        opened: (T, N), see `grasps.WeldErrors.open`.
        stopped: agent -> since when a fault may have put it out of service [s]; it may creep to rest.
    """
    for span, step in zip(spans, roles, strict=True):
        driven = _driven(recording, span, step, opened)
        reach = {
            agent: _reach(recording, agent, action["object"])
            for action in span.actions
            if action["kind"] in ("grasp", "release")
            for agent in action["agents"]
        }
        for name in (*recording.agents, *sorted(step.carried)):
            acts = name in step.moving or name in reach
            late = stopped.get(name, np.inf) <= recording.time[span.end]
            most = BRAKING if late or (span.halted and acts) else STAND
            most = max(most, STAND + reach.get(name, 0.0))
            yield from _left_alone(recording, span, name, driven[name], most)


def _driven(recording: Recording, span: Span, step: Roles, opened: np.ndarray) -> dict[str, np.ndarray]:
    """member -> (T,) whether a navigation function moves it; carriers as long as they hold what they carry. Who lets go
    of something has nowhere else to go."""
    driven = {name: np.zeros(len(recording.time), dtype=bool) for name in (*recording.agents, *recording.objects)}
    for record in recording.intervals:
        if record.step == span.number:
            for name in {*record.travels, *record.transports} & (step.moving | step.grasping.keys()):
                driven[name] |= interval_samples(recording, record)
    alone = freed(recording, span, step, opened)
    for mover in step.transports:
        for agent in mover.team:
            driven[agent] = driven[mover.name] & (np.arange(len(recording.time)) < alone.get(agent, np.inf))
    return driven


def _reach(recording: Recording, agent: str, obj: str) -> float:
    """The way between stand-off and grasp [m]; if it is never held, that from where the object is."""
    held = recording.grasp[:, recording.agents.index(agent)] == recording.objects.index(obj)
    offset = centres(recording, agent)[held] - centres(recording, obj)[held]
    holding = float(np.linalg.norm(offset, axis=1).min()) if held.any() else 0.0
    return max(APPROACH, SLANT * (radius(recording, agent) + radius(recording, obj) + GAP - holding))


def _left_alone(recording: Recording, span: Span, name: str, driven: np.ndarray, most: float) -> Iterator[Violation]:
    """Somebody may not move in samples in which it is not driven."""
    driven, time = driven[span.own], recording.time[span.own]
    where = centres(recording, name)[span.own]
    last = np.maximum.accumulate(np.where(driven, np.arange(len(driven)), 0))  # when it was last driven
    way = np.linalg.norm(where - where[last], axis=1)
    what = f"{name} moves by more than {100 * most:.3g} cm under no navigation function"
    violation = Violation("lyapunov", (name,), what, step=span.number, unit="m")
    yield from where_bad(violation, way > most, way, time)
