"""Who was halted on its way from one region to another, and from where it may go on."""

from __future__ import annotations

import pytest

from drake_ltl.verification.expected import Expected, action_violations, expectations
from drake_ltl.verification.spans import Span

SOMEWHERE = {"a1": None, "a2": "right"}


def action(kind: str, start: str, goal: str, obj: str | None = None) -> dict:
    return {"kind": kind, "agents": ["a1"], "object": obj, "from": start, "to": goal}


def span(number: int, *actions: dict, halted: bool = False) -> Span:
    return Span(number, actions, number, number, number + 1, True, halted, ())


def said(*later: dict, holds: str | None = None) -> list[str]:
    """Of the actions of later steps, after a1 was halted on its way from left to right."""
    start = Expected({"a1": "left", "a2": "right"}, {"o1": "left"}, {"a1": holds, "a2": None})
    found = Expected(SOMEWHERE, {"o1": "left"}, {"a1": holds, "a2": None})
    first = span(0, action("travel", "left", "right") if holds is None else action("transport", "left", "right", holds),
                 halted=True)  # fmt: skip
    spans = [first, *(span(number, act) for number, act in enumerate(later, 1))]
    expected = expectations(start, spans, lambda sample: found)
    violations = action_violations(expected, spans, range(len(spans)), lambda obj, team: True)
    return [violation.what for violation in violations if violation.step]


@pytest.mark.parametrize("start", ["left", "right"])
def test_it_goes_on_from_one_of_the_two(start):
    assert said(action("travel", start, "left")) == []


def test_it_does_not_go_on_from_elsewhere():
    assert said(action("travel", "yard", "left")) == ["travel of a1 begins in yard, where it is not"]


def test_it_grasps_nothing_there():
    assert said(action("grasp", "left", "left", "o1")) == ["grasp of a1 begins in left, where it is not"]


def test_it_lets_go_wherever_it_is_and_goes_on_from_one_of_the_two_all_the_same():
    """The region of a release between regions says nothing."""
    release = action("release", "left", "left", "o1")
    assert said(release, action("travel", "right", "left"), holds="o1") == []
    assert said(release, action("travel", "yard", "left"), holds="o1") == [
        "travel of a1 begins in yard, where it is not"
    ]


def test_once_it_has_arrived_it_is_where_it_is():
    there = action("travel", "left", "right")
    assert said(there, action("travel", "left", "yard")) == ["travel of a1 begins in left, where it is not"]
