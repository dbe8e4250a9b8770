"""Goals of navigation functions can be reached, and are: else V could fall towards anything on any way."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.scenario.model import Scenario
from drake_ltl.verification.bodies import BEYOND
from drake_ltl.verification.drives import YAW
from drake_ltl.verification.spans import Span, interval_samples
from drake_ltl.verification.violations import Violation

SLACK = 0.01
"""Added to the scenario's tolerances [m, rad]: a mover creeps on while what it has reached is looked at."""
DEVIATIONS = 6.0
"""... and so many standard deviations of the noise with which a fault makes it seen."""
BASE = slice(0, 2)
"""x and y in q."""


def arrival_violations(
    recording: Recording, scenario: Scenario, spans: Sequence[Span], limits: Mapping[str, tuple[np.ndarray, np.ndarray]]
) -> Iterator[Violation]:
    """Goals beyond joints' limits, and movers that are not at the goal of their last interval in a step when it ends.

    Steps that a fault halts end anywhere, and so do those that have not finished.

    Args:
        limits: agent -> lower and upper limits of its joints (n_i,) [m, rad].
    """
    for record in recording.intervals:
        for name, goal in record.travels.items():
            lower, upper = limits[name]
            beyond = float(np.maximum(lower - goal, goal - upper).max())
            if beyond > BEYOND:
                what = f"V falls towards a goal of {name} that is beyond the limits of its joints (m or rad)"
                yield Violation("lyapunov", (name,), what, step=record.step, worst=beyond)
    slack = SLACK + DEVIATIONS * max(
        (fault.values.get("position_noise", 0.0) for fault in scenario.faults), default=0.0
    )
    most = {"m": scenario.tolerances.position + slack, "rad": scenario.tolerances.joint + slack}
    drives = {agent.name for agent in scenario.agents if not agent.has_arm}
    for span in (span for span in spans if span.finished and not span.halted):
        for name, (goal, sample) in _ends(recording, span).items():
            for unit, off in _off(recording, name, np.array(goal), sample, name in drives):
                if off > most[unit]:
                    what = f"{name} has not reached the goal of V where its way ends"
                    time = float(recording.time[sample])
                    yield Violation("lyapunov", (name,), what, time, span.number, off, time, unit)


def _ends(recording: Recording, span: Span) -> dict[str, tuple[tuple[float, ...], int]]:
    """Mover -> goal of its last interval in a step, and the sample that shows the interval's end."""
    found = {}
    for record in (record for record in recording.intervals if record.step == span.number):
        rows = np.flatnonzero(interval_samples(recording, record))
        for name, goal in ({**record.travels, **record.transports}).items() if len(rows) else ():
            found[name] = goal, min(int(rows[-1]) + 1, len(recording.time) - 1)
    return found


def _off(recording: Recording, name: str, goal: np.ndarray, sample: int, is_drive: bool) -> Iterator[tuple[str, float]]:
    """Distances from the goal, with their units: of what is carried in space, of agents on the floor and in joints."""
    if name in recording.objects:
        yield "m", float(np.linalg.norm(recording.pose[name][sample, 4:] - goal))
        return
    error = recording.q[name][sample] - goal
    yield "m", float(np.linalg.norm(error[BASE]))
    yield (
        "rad",
        float(abs(np.angle(np.exp(1j * error[YAW]))) if is_drive else np.abs(error[BASE.stop :]).max(initial=0.0)),
    )
