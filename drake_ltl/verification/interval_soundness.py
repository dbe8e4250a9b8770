"""Whether a recording's intervals fit its steps: of V only what the actions of its step move can be a function."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np

from drake_ltl.errors import Mistake
from drake_ltl.execution.recording import IntervalRecord, Recording
from drake_ltl.scenario.table import LARGEST, shown
from drake_ltl.verification.spans import interval_samples

LONGEST_NAME = 40
"""That is said as it is."""
_REMEDY = "make a new recording with `simulate`"


def interval_mistakes(recording: Recording) -> Iterator[Mistake]:
    """Everything that does not fit, of a recording whose steps are sound."""
    before = (-1, -1)
    for index, interval in enumerate(recording.intervals):
        where = f"recording.intervals[{index}]"
        if not 0 <= interval.step < len(recording.steps) or interval.phase < 0:
            what = f"step {interval.step}, phase {interval.phase} is none of the {len(recording.steps)} steps'"
            yield Mistake(where, what, _REMEDY)
            continue
        key = (interval.step, interval.phase)
        if key <= before:
            what = "is of the same step and phase as another" if key == before else "is earlier than the one before it"
            yield Mistake(where, what, _REMEDY)
        before = key
        if not interval_samples(recording, interval).any():
            yield Mistake(where, "has no samples", _REMEDY)
        for what in chain(_strangers(recording, interval), _misfits(recording, interval)):
            yield Mistake(where, what, _REMEDY)


def _strangers(recording: Recording, interval: IntervalRecord) -> Iterator[str]:
    """Names of what no action of the step moves in this way."""
    if not interval.travels and not interval.transports:
        yield "moves nothing"
    actions = recording.steps[interval.step].actions
    carried = [action["object"] for action in actions if action["kind"] == "transport"]
    driving = [name for action in actions if action["kind"] != "transport" for name in action["agents"]]
    reaching = [name for action in actions if action["kind"] in ("grasp", "release") for name in action["agents"]]
    for names, allowed, what in (
        (interval.travels, driving, "does not travel"),
        (interval.transports, carried, "is not carried"),
        (interval.waiting, carried, "does not wait to be carried"),
        (interval.reaches, reaching, "does not reach"),
    ):
        for name in names:
            if name not in allowed:
                yield f"{_said(name)} {what} in step {interval.step}"
    for name in set(interval.transports) & set(interval.waiting):
        yield f"{_said(name)} is carried and waits at once"
    for name in set(interval.travels) & set(interval.reaches):
        yield f"{_said(name)} travels and reaches at once"


def _misfits(recording: Recording, interval: IntervalRecord) -> Iterator[str]:
    """Goals of wrong lengths, and of what are no numbers."""
    joints = {name: recording.q[name].shape[1] for name in recording.agents}
    for name, goal in interval.travels.items():
        yield from _unfit(_said(name), goal, joints.get(name))
    for name, goal in interval.transports.items():
        yield from _unfit(_said(name), goal, 3)
    for name, ends in interval.reaches.items():
        if len(ends) != 2:
            yield f"the way of {_said(name)} has {len(ends)} ends, not 2"
        for goal in ends:
            yield from _unfit(_said(name), goal, joints.get(name))


def _said(name: str) -> str:
    """A member's name; whatever else stands in its place, so that it can be printed."""
    return name if name.isprintable() and len(name) <= LONGEST_NAME else shown(name)


def _unfit(name: str, goal: Sequence[float], length: int | None) -> Iterator[str]:
    if length is not None and len(goal) != length:
        yield f"the goal of {name} has {len(goal)} numbers, not {length}"
    elif not all(isinstance(x, (int, float, np.number)) and abs(x) <= LARGEST for x in goal):
        yield f"the goal of {name} is not of finite numbers"
