"""Recordings that cannot be judged: refused with every reason, never a traceback from within."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from drake_ltl.errors import InvalidInputError
from drake_ltl.execution.recording import IntervalRecord, StepRecord
from drake_ltl.verification import verify
from drake_ltl.verification.soundness import check_sound


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
        ({"object_radius": {"o1": 0.4, "o2": 0.4, "é": 1.0}}, "recording.object_radius: names 'é'"),
        ({"suffix_length": 0}, "a run repeats at least one state"),
        ({"step": np.zeros(451, dtype=int)}, "does not count the 9 recorded steps"),
        ({"step": np.full(451, -1)}, "does not count the 9 recorded steps"),
        ({"step": np.full(451, 2**62)}, "does not count the 9 recorded steps"),
        ({"grasp": np.full((451, 3), 2)}, "recording.grasp"),
        ({"grasp": np.full((451, 2), -1)}, "recording.grasp: has shape (451, 2)"),
        ({"lyapunov": np.zeros(450)}, "recording.lyapunov"),
        ({"steps": ()}, "does not count the 0 recorded steps"),
        ({"scenario": "name: other"}, "is missing"),
        ({"team_radius": {"o1": 1e308, "o2": 2.4}}, "recording.team_radius.o1: 1e+308 is not a radius"),
        ({"reason": "the controller failed"}, "is completed, and ended early: 'the controller failed'"),
        ({"completed": False}, "is not completed, and has no reason"),
        ({"mode": np.full((451, 3), 5)}, "recording.mode"),
        ({"mode": np.full((451, 3), -1)}, "recording.mode"),
        ({"phase": np.full(451, -1)}, "recording.phase"),
        ({"time": 0.02 * np.arange(451) + 1e5}, "begins at 100000 s, not at 0"),
        ({"time": 0.02 * np.arange(451) - 1e3}, "begins at -1000 s, not at 0"),
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
        {"agents": [5000 * "x"]},
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
    said = complaints(dataclasses.replace(recording, steps=(wrong, *recording.steps[1:])))
    assert "recording.steps.0" in said
    assert all(len(line) < 500 for line in said.splitlines())


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"start": -7.0}, "recording.steps.3.start: is -7 s, its first sample's time 3 s"),
        ({"start": 3.0 + 1e-8}, "recording.steps.3.start"),
        ({"duration": 999.0}, "recording.steps.3.duration: is 999 s, of its samples 1 s"),
        ({"finished": False}, "recording.steps.3.finished: is False, but samples go on after it"),
    ],
)
def test_records_that_are_not_of_the_samples(recording, change, words):
    steps = list(recording.steps)
    steps[3] = dataclasses.replace(steps[3], **change)
    (line,) = complaints(dataclasses.replace(recording, steps=tuple(steps))).splitlines()
    assert words in line


def test_a_step_that_is_said_to_have_finished(draw):
    whole = draw(9)
    last = dataclasses.replace(whole, step=np.minimum(whole.step, 8))
    assert "recording.steps.8.finished: is True, but samples do not go on" in complaints(last)


def waiting_first(recording, times: int):
    """All wait in steps of no time before the run."""
    waits = [StepRecord(k, (), 0.0, 0.0, True) for k in range(times)]
    later = [dataclasses.replace(record, number=record.number + times) for record in recording.steps]
    intervals = [dataclasses.replace(record, step=record.step + times) for record in recording.intervals]
    changes = {"steps": (*waits, *later), "step": recording.step + times, "intervals": tuple(intervals)}
    return dataclasses.replace(recording, **changes)


def test_a_first_step_without_samples_is_sound(recording, scenario):
    """Shorter than the sampling, as a step in which all wait: it begins and ends with the next."""
    check_sound(waiting_first(recording, 1), scenario)
    wait, *others = waiting_first(recording, 1).steps
    late = dataclasses.replace(wait, duration=0.5)
    with pytest.raises(InvalidInputError, match=r"recording\.steps\.0\.duration"):
        check_sound(dataclasses.replace(waiting_first(recording, 1), steps=(late, *others)), scenario)


def test_more_steps_without_samples(recording):
    """They would bring a fault early that waits for a step."""
    assert complaints(waiting_first(recording, 2)).startswith("recording.steps.1: has no samples")
    assert complaints(dataclasses.replace(recording, step=np.where(recording.step == 3, 4, recording.step))).startswith(
        "recording.steps.3: has no samples"
    )


def test_phases_that_fall(recording):
    phase = recording.phase.copy()
    phase[10:20] = 1
    assert "recording.phase: falls within a step" in complaints(dataclasses.replace(recording, phase=phase))


@pytest.mark.parametrize("times", [0, 1])
def test_two_actions_at_once(recording, times):
    steps = list(recording.steps)
    travels, carry = steps[0].actions, steps[2].actions[0]
    steps[0] = dataclasses.replace(steps[0], actions=(*travels, *travels[:1] * times))
    assert (
        "a1 has several actions" in complaints(dataclasses.replace(recording, steps=tuple(steps), reason="x"))
    ) == times
    other = {**carry, "kind": "grasp", "agents": ["a3"]}
    steps[2] = dataclasses.replace(steps[2], actions=(carry, *(other,) * times))
    assert (
        "o1 has several actions" in complaints(dataclasses.replace(recording, steps=tuple(steps), reason="x"))
    ) == times


def test_grasps_without_an_arm(recording, scenario):
    *others, a3 = scenario.agents
    drives = dataclasses.replace(scenario, agents=(*others, dataclasses.replace(a3, has_arm=False)))
    check_sound(recording, drives)
    recording.grasp[100:110, 2] = 0
    with pytest.raises(InvalidInputError, match="a3 grasps, and has no arm"):
        check_sound(recording, drives)


STILL = {"travels": {}, "transports": {}, "waiting": (), "reaches": {}}
DRIVE = {"step": 0, "phase": 0, **STILL, "travels": {"a1": (0.0,) * 4}}
CARRY = {"step": 2, "phase": 0, **STILL, "transports": {"o1": (0.0,) * 3}}
MIXED = {"step": 4, "phase": 0, **STILL, "travels": {"a2": (0.0,) * 4}}


@pytest.mark.parametrize("sound", [DRIVE, CARRY, MIXED | {"reaches": {"a1": ((0.0,) * 4, (1.0,) * 4)}}])
def test_sound_intervals(recording, scenario, sound):
    check_sound(dataclasses.replace(recording, intervals=(IntervalRecord(**sound),)), scenario)


@pytest.mark.parametrize(
    ("interval", "words"),
    [
        (DRIVE | {"step": 9}, "step 9, phase 0 is none of the 9 steps'"),
        (DRIVE | {"step": -1}, "step -1, phase 0 is none"),
        (DRIVE | {"phase": -1}, "phase -1 is none"),
        (DRIVE | {"travels": {}}, "moves nothing"),
        (DRIVE | {"travels": {"a9": (0.0,) * 4}}, "a9 does not travel in step 0"),
        (DRIVE | {"travels": {"a3": (0.0,) * 4}}, "a3 does not travel in step 0"),
        (DRIVE | {"travels": {"\ud800": (0.0,) * 4}}, r"'\ud800' does not travel in step 0"),
        (DRIVE | {"step": 2}, "a1 does not travel in step 2"),  # it carries
        (DRIVE | {"travels": {"a1": (0.0,) * 3}}, "the goal of a1 has 3 numbers, not 4"),
        (DRIVE | {"travels": {"a1": tuple("abcd")}}, "the goal of a1 is not of finite numbers"),
        (DRIVE | {"travels": {"a1": (0.0, np.nan, 0.0, 0.0)}}, "the goal of a1 is not of finite numbers"),
        (DRIVE | {"travels": {"a1": (0.0, np.inf, 0.0, 0.0)}}, "the goal of a1 is not of finite numbers"),
        (DRIVE | {"transports": {"o1": (0.0,) * 3}}, "o1 is not carried in step 0"),
        (CARRY | {"transports": {"o9": (0.0,) * 3}}, "o9 is not carried"),
        (CARRY | {"transports": {"o2": (0.0,) * 3}}, "o2 is not carried"),
        (CARRY | {"transports": {"o1": (0.0,) * 2}}, "the goal of o1 has 2 numbers, not 3"),
        (CARRY | {"transports": {"o1": tuple("abc")}}, "the goal of o1 is not of finite numbers"),
        (CARRY | {"waiting": ("o2",)}, "o2 does not wait"),
        (CARRY | {"waiting": ("o1",)}, "o1 is carried and waits at once"),
        (DRIVE | {"reaches": {"a2": ((0.0,) * 4, (0.0,) * 4)}}, "a2 does not reach in step 0"),
        (MIXED | {"reaches": {"a9": ((0.0,) * 4, (0.0,) * 4)}}, "a9 does not reach in step 4"),
        (MIXED | {"reaches": {"a1": ((0.0,) * 4, (0.0,) * 3)}}, "the goal of a1 has 3 numbers, not 4"),
        (MIXED | {"reaches": {"a1": ((0.0,) * 4,)}}, "the way of a1 has 1 ends, not 2"),
    ],
)
def test_intervals_that_do_not_fit(recording, interval, words):
    (line,) = complaints(dataclasses.replace(recording, intervals=(IntervalRecord(**interval),))).splitlines()
    assert line.startswith("recording.intervals[0]: ")
    assert words in line


def test_intervals_twice(recording):
    twice = (IntervalRecord(**DRIVE), IntervalRecord(**DRIVE))
    assert "is of the same step and phase" in complaints(dataclasses.replace(recording, intervals=twice))


def test_intervals_out_of_order(recording):
    """The one that begins while somebody is on the way would be taken for the first."""
    phase = recording.phase.copy()
    phase[25:50] = 1
    first, *others = recording.intervals
    second = dataclasses.replace(first, phase=1)
    swapped = dataclasses.replace(recording, phase=phase, intervals=(second, first, *others))
    assert complaints(swapped).startswith("recording.intervals[1]: is earlier than the one before it")
    never = dataclasses.replace(recording, intervals=(first, second, *others))
    assert complaints(never).startswith("recording.intervals[1]: has no samples")


def test_actions_relabelled(recording):
    """What an interval carries is no longer carried."""
    carry = recording.steps[2]
    changed = dataclasses.replace(carry, actions=({**carry.actions[0], "kind": "release"},))
    wrong = dataclasses.replace(recording, steps=(*recording.steps[:2], changed, *recording.steps[3:]))
    assert "o1 is not carried in step 2" in complaints(dataclasses.replace(wrong, intervals=(IntervalRecord(**CARRY),)))


def test_all_reasons_at_once(recording):
    wrong = dataclasses.replace(recording, suffix_length=0, team_radius={"o1": 1.0, "o2": 1.0})
    assert len(complaints(wrong).splitlines()) == 3
