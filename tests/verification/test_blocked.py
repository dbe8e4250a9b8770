"""Whoever comes into a region after it had to be known that it is blocked is found out."""

from __future__ import annotations

import dataclasses
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from drake_ltl.scenario import loads
from drake_ltl.verification import verify
from drake_ltl.verification.blocked import NOTICED_WITHIN, blocked_violations
from drake_ltl.verification.left_alone import BRAKING
from drake_ltl.verification.spans import step_spans


def entering(recording, text: str, fault: str, halted: int | None = None) -> list[tuple[str, int]]:
    """(who, step) of each violation."""
    spans = [dataclasses.replace(span, halted=span.number == halted) for span in step_spans(recording)]
    scenario = loads(f"{text}\nfaults:\n  - {fault}\n")
    return [(violation.who[0], violation.step) for violation in blocked_violations(recording, scenario, spans)]


@pytest.mark.parametrize(
    ("fault", "found"),
    [
        ("{kind: blocked_region, region: pi1, time: 0.0}", [("a1", 2), ("a2", 2), ("a2", 5), ("o1", 2)]),
        ("{kind: blocked_region, region: pi1, step: 4}", [("a2", 5)]),  # it leaves in step 5 and comes back
        ("{kind: blocked_region, region: pi1, step: 6}", [("a2", 5)]),
        ("{kind: blocked_region, region: pi1, step: 7}", []),  # all leave
        ("{kind: blocked_region, region: pi1, step: 99}", []),  # the run does not come so far
        ("{kind: blocked_region, region: pi4, time: 0.0}", []),  # who is there stays
        ("{kind: push, object: o1, time: 0.0, impulse: [1, 0]}", []),
    ],
)
def test_who_enters_is_named(recording, scenario_text, fault, found):
    assert sorted(entering(recording, scenario_text, fault)) == found


def test_it_is_part_of_the_verdict(recording, scenario_text):
    text = f"{scenario_text}\nfaults:\n  - {{kind: blocked_region, region: pi3, step: 5}}\n"
    verdict = verify(dataclasses.replace(recording, scenario=text))
    assert "a2 enters pi3, which is blocked" in [violation.what for violation in verdict.violations]


def test_a_team_that_is_halted_within_a_region_may_let_go_in_the_next_step(recording, scenario_text):
    """Its welds open at the sample at which the halted step ends: it held until then."""
    text = f"{scenario_text}\nfaults:\n  - {{kind: blocked_region, region: pi4, time: 0.0}}\n"
    steps = [dataclasses.replace(step, halted="a door" * (step.number == 2)) for step in recording.steps]
    ended = dataclasses.replace(recording, completed=False, reason="early")  # no halted step repeats
    verdict = verify(dataclasses.replace(ended, scenario=text, steps=tuple(steps)))
    assert not [violation.what for violation in verdict.violations if violation.kind == "action"]


R, RADIUS, DT = 3.0, 0.5, 0.01
"""Of the region at the origin [m], of a1 [m], between samples [s]."""


def came(way: list[float], halted: bool = False, parts: int = 1) -> bool:
    """Whether a1 enters the region by way of these distances from its centre; blocked so that the first counts.

    Args:
        way: [m].
        halted: whether by faults.
        parts: how many steps of the same length these are.
    """
    distance = np.repeat(way, 2)
    recording = SimpleNamespace(
        agents=("a1",),
        objects=(),
        centre={"a1": distance[:, None] * [1.0, 0.0, 0.0]},
        agent_radius={"a1": RADIUS},
        time=NOTICED_WITHIN + DT * np.arange(len(distance)),
        steps=(),
    )
    fault = SimpleNamespace(kind="blocked_region", who="yard", time=0.0, step=None)
    region = SimpleNamespace(name="yard", centre=(0.0, 0.0, 0.0), radius=R)
    scenario = SimpleNamespace(faults=(fault,), region=lambda name: region)
    ends = np.linspace(0, len(distance) - 1, parts + 1).astype(int).tolist()
    spans = [SimpleNamespace(first=a, end=b, number=0, halted=halted) for a, b in pairwise(ends)]
    return bool(list(blocked_violations(recording, scenario, spans)))


@pytest.mark.parametrize(
    ("way", "entered"),
    [
        ([5.0, 3.6, 5.0], False),
        ([3.6, 3.4], True),  # touches
        ([3.4, 3.2, 3.6], False),  # was on the border, leaves
        ([3.4, 2.4], True),  # was on the border, goes in
        ([3.4, 3.6, 3.4], True),  # has left, comes back
        ([1.0, 2.5, 0.0], False),  # within it may move
        ([1.0, 3.0, 4.0], False),
        ([1.0, 3.0, 2.0], True),  # was on its way out
    ],
)
def test_borders(way, entered):
    assert came(way) == entered


@pytest.mark.parametrize(
    ("way", "entered"),
    [
        ([3.4, 3.4 - 0.9 * BRAKING], False),
        ([3.4, 3.4 - 1.1 * BRAKING], True),
        ([9.0, 3.5 - 0.9 * BRAKING], False),
        ([9.0, 3.5 - 1.1 * BRAKING], True),
        ([2.0, 0.0], False),
    ],
)
def test_a_mover_that_is_halted_brakes(way, entered):
    assert came(way, halted=True) == entered


@pytest.mark.parametrize(
    ("share", "entered"), [([0.5, 0.5], False), ([0.9, 0.9], True), ([0.9, 0.0], False), ([0.6, 0.6], True)]
)
def test_all_halted_steps_together_are_braked_in_once(share, entered):
    """First so far, then so much farther."""
    first, second = (0.98 * BRAKING * part for part in share)
    assert came([3.6, 3.5 - first, 3.5 - first - second], halted=True, parts=2) == entered
