"""Which way objects face: as the scenario says at the start, and, level, at the end of every transport."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from drake_ltl.execution.recording import Recording, StepRecord
from drake_ltl.scenario.model import Scenario, TransportObject
from drake_ltl.verification.objects import TURN
from drake_ltl.verification.poses import rotations
from drake_ltl.verification.roles import Roles
from drake_ltl.verification.spans import Span
from drake_ltl.verification.violations import Violation, where_bad


def orientation(obj: TransportObject, heading: float) -> Rotation:
    """R_WO of the object when it stands with a heading [rad]."""
    return Rotation.from_euler("xyz", [*obj.orientation[:2], heading])  # turns about the world's axes, in this order


def headings(scenario: Scenario, steps: Sequence[StepRecord]) -> list[dict[str, float]]:
    """Heading [rad] that each object should have before each step, and after the last (K + 1)."""
    goals = {obj.name: obj.headings for obj in scenario.objects}
    found = [{obj.name: obj.heading for obj in scenario.objects}]
    for step in steps:
        now = dict(found[-1])
        for action in step.actions:
            if action["kind"] == "transport":
                obj = action["object"]
                now[obj] = goals[obj].get(action["to"], now[obj])
        found.append(now)
    return found


def heading_errors(
    recording: Recording, scenario: Scenario, spans: Sequence[Span], roles: Sequence[Roles]
) -> dict[tuple[int, str], float]:
    """(step, object) -> angle [rad] from the orientation that it should have at a transport's end: it has its heading,
    and stands as level as at the start, not on an edge."""
    should, objects = headings(scenario, recording.steps), {obj.name: obj for obj in scenario.objects}
    errors = {}
    for span, step in zip(spans, roles, strict=True):
        for name in sorted(step.carried) if span.finished and not span.halted else ():
            is_now = rotations(recording.pose[name][span.end : span.end + 1])
            goal = orientation(objects[name], should[span.number + 1][name])
            errors[span.number, name] = float((is_now * goal.inv()).magnitude()[0])
    return errors


def limit(scenario: Scenario) -> float:
    """Of these errors [rad]: transports end within the tolerance, and what is set down then may creep."""
    return scenario.tolerances.angle + TURN


def heading_violations(
    recording: Recording, scenario: Scenario, spans: Sequence[Span], errors: dict[tuple[int, str], float]
) -> Iterator[Violation]:
    """Objects that transports did not turn as they should, or turned though they should not."""
    for (number, name), error in errors.items():
        (span,) = (span for span in spans if span.number == number)
        what = f"{name} does not stand or face as it should"
        violation = Violation("heading", (name,), what, step=number, unit="rad")
        off = np.array([error])
        yield from where_bad(violation, off > limit(scenario), off, recording.time[span.end : span.end + 1])
