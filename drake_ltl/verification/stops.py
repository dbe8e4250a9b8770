"""Agents that a fault has stopped, with their brakes on: nothing of them moves any more."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.scenario.faults import LIMP
from drake_ltl.scenario.model import Scenario
from drake_ltl.verification.befallen import COMES_WITHIN, since
from drake_ltl.verification.left_alone import BRAKING
from drake_ltl.verification.violations import Violation, where_bad

CREEP = 0.01
"""Of a joint whose brake is on [m, rad]: under the pull of a whole team joints were measured to creep by 3e-6."""


def stop_violations(recording: Recording, scenario: Scenario) -> Iterator[Violation]:
    """Joints of an arm and its base that go on, and wheeled bases that skid farther than robots may brake.

    Whether the run says that it noticed or not. Of who is limp as well nothing is said: friction takes the brakes'
    place.
    """
    stops = [fault for fault in scenario.faults if fault.kind == "agent_stops"]
    limp = {fault.who for fault in stops if fault.values["how"] == LIMP}
    for fault in (fault for fault in stops if fault.who not in limp):
        first = int(np.searchsorted(recording.time, since(fault, recording) + COMES_WITHIN))
        has_arm = next(agent.has_arm for agent in scenario.agents if agent.name == fault.who)
        where = (recording.q if has_arm else recording.centre)[fault.who][first:]
        off = where - where[:1]
        way = np.abs(off).max(axis=1) if has_arm else np.linalg.norm(off, axis=1)
        most, shown_as = (CREEP, "1 cm or 0.01 rad") if has_arm else (BRAKING, f"{100 * BRAKING:.3g} cm")
        what = f"{fault.who} moves by more than {shown_as} after a fault has stopped it"
        violation = Violation("motion", (fault.who,), what, unit="" if has_arm else "m")
        yield from where_bad(violation, way > most, way, recording.time[first:])
