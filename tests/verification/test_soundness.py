"""Recordings that cannot be judged: refused with every reason, never a traceback from within."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from drake_ltl.errors import InvalidInputError
from drake_ltl.verification import verify


def complaints(recording) -> str:
    with pytest.raises(InvalidInputError) as caught:
        verify(recording)
    return str(caught.value)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"agents": ("a1", "a2")}, "recording.agents"),
        ({"agent_radius": {"a1": 0.5, "a2": 0.7, "a3": 0.7}}, "recording.agent_radius.a1: is 0.5"),
        ({"agent_radius": {"a1": 0.7, "a2": 0.7}}, "recording.agent_radius.a3"),
        ({"team_radius": {"o1": 1.0, "o2": 2.4}}, "recording.team_radius.o1"),
        ({"object_radius": {"o1": "0.4", "o2": 0.4}}, "is not a radius"),
        ({"suffix_length": 0}, "a run repeats at least one state"),
        ({"step": np.zeros(451, dtype=int)}, "does not count the 9 recorded steps"),
        ({"grasp": np.full((451, 3), 2)}, "recording.grasp"),
        ({"grasp": np.full((451, 2), -1)}, "recording.grasp: has shape (451, 2)"),
        ({"lyapunov": np.zeros(450)}, "recording.lyapunov"),
        ({"steps": ()}, "does not count the 0 recorded steps"),
        ({"scenario": "name: other"}, "is missing"),
    ],
)
def test_refused(recording, changes, words):
    assert words in complaints(dataclasses.replace(recording, **changes))


@pytest.mark.parametrize(
    "change",
    [
        {"kind": "jump"},
        {"agents": ["a9"]},
        {"agents": ["o1"]},
        {"agents": []},
        {"from": "a1"},
        {"to": "pi9"},
        {"object": "o1"},
        {"extra": 1},
    ],
)
def test_actions_of_another_world(recording, change):
    step = recording.steps[0]
    wrong = dataclasses.replace(step, actions=({**step.actions[0], **change},))
    assert "recording.steps.0" in complaints(dataclasses.replace(recording, steps=(wrong, *recording.steps[1:])))


def test_all_reasons_at_once(recording):
    wrong = dataclasses.replace(recording, suffix_length=0, team_radius={"o1": 1.0, "o2": 1.0})
    assert len(complaints(wrong).splitlines()) == 3
