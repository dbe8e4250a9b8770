"""What a run comes to."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace

import pytest

from drake_ltl.sweep.drawing import Drawn
from drake_ltl.sweep.outcome import judged, outcome_from_json, outcome_to_json
from drake_ltl.verification.clearances import KINDS
from drake_ltl.verification.verdict import Verdict
from drake_ltl.verification.violations import Violation

DRAWN = Drawn({"a1": (0.1, 0.2)}, {"force": 40.0}, {})


def outcome_of(violations: int, reason: str = "", **clearances: float):
    """Of a run of two steps, of which the second does not end if there is a reason."""
    steps = tuple(SimpleNamespace(number=n, duration=1.5 + n, finished=not (reason and n)) for n in range(2))
    verdict = Verdict(
        satisfied=not violations,
        violations=tuple(Violation("rest", (), f"what {n}", time=float(n)) for n in range(violations)),
        word=(),
        steps=steps,
        min_clearance=dict.fromkeys(KINDS) | clearances,
        max_lyapunov_increase=math.inf if violations else 0.0,
        max_weld_error=0.0,
        max_weld_angle=0.0,
        max_tilt=0.0,
        simulated_seconds=4.0,
    )
    return judged(7, DRAWN, 2.5, SimpleNamespace(completed=not reason, reason=reason), verdict, 1.0)


@pytest.mark.parametrize(
    ("violations", "early", "status", "reason"),
    [
        (0, "", "satisfied", ""),
        (1, "", "violated", "0.000 s: what 0"),
        (3, "", "violated", "0.000 s: what 0 (and 2 more)"),
        (2, "step 2 did not finish", "stalled", "the run ended early: step 2 did not finish"),
    ],
)
def test_status_and_reason(violations, early, status, reason):
    outcome = outcome_of(violations, early)
    assert (outcome.run, outcome.status, outcome.reason) == (7, status, reason)
    assert outcome.durations == ((1.5,) if early else (1.5, 2.5))
    assert outcome_from_json(json.loads(json.dumps(outcome_to_json(outcome), allow_nan=False))) == outcome


@pytest.mark.parametrize(
    ("clearances", "collided"),
    [
        ({}, False),
        ({"agent_agent": 1e-9}, False),
        ({"agent_agent": 0.0}, True),
        ({"agent_object": 0.1, "team_other": -0.1}, True),
        ({"forbidden_region": -0.1, "workspace": -0.1}, False),  # no bodies touch there
    ],
)
def test_collisions(clearances, collided):
    assert outcome_of(0, **clearances).collided is collided
