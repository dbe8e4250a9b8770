"""Whether a recording is one at all: of this scenario, complete, and in agreement with itself.

What fails here cannot be judged; it is bad input, not a violation.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping

import numpy as np

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.execution.recording import NOTHING, Recording, StepRecord
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.table import LARGEST, listing, shown
from drake_ltl.verification.halt_soundness import halt_mistakes
from drake_ltl.verification.interval_soundness import interval_mistakes

CARRIES = 3
"""The mode of an agent that carries the first object."""
ACTION_KINDS = ("travel", "grasp", "release", "transport")
SAME_TIME = 1e-9
"""Times this close [s] are one: records and samples are of the same clock."""
AT_ONCE = 4
"""Steps after a halt that may take no time: carrying ends, holders release, all go to a region, the new plan begins."""
_REMEDY = "make a new recording with `simulate`"


def check_sound(recording: Recording, scenario: Scenario) -> None:
    """Raises InvalidInputError with everything that makes the recording unusable."""
    mistakes = [*_names(recording, scenario)]
    mistakes = mistakes or [
        *_radii(recording, scenario),
        *_shapes(recording),
        *(mistake for step in recording.steps for mistake in (*_actions(step, scenario), *_twice(step))),
        *_outcome(recording),
    ]
    mistakes = mistakes or [*_indices(recording), *_grasping_drives(recording, scenario)]
    mistakes = mistakes or [*_records(recording), *interval_mistakes(recording), *halt_mistakes(recording, scenario)]
    if mistakes:
        raise InvalidInputError(mistakes)


def _names(recording: Recording, scenario: Scenario) -> Iterator[Mistake]:
    for where, names, known in (
        ("agents", recording.agents, scenario.agent_names),
        ("objects", recording.objects, scenario.object_names),
    ):
        if names != known:
            remedy = f"its scenario has {', '.join(known)}"
            yield Mistake(f"recording.{where}", f"are {', '.join(map(str, names))}", remedy)


def _radii(recording: Recording, scenario: Scenario) -> Iterator[Mistake]:
    """Every radius is there, and the scenario's where it states one."""
    stated = {
        "agent_radius": {agent.name: agent.radius for agent in scenario.agents},
        "object_radius": {obj.name: obj.radius for obj in scenario.objects},
        "team_radius": {obj.name: obj.team_radius for obj in scenario.objects},
    }
    for field, radii in stated.items():
        recorded: Mapping[str, float] = getattr(recording, field)
        for name in sorted(set(recorded) - set(radii)):
            remedy = f"its scenario has {', '.join(radii) or 'none'}"
            yield Mistake(f"recording.{field}", f"names {shown(name)}", remedy)
        for name, known in radii.items():
            radius = recorded.get(name)
            if not isinstance(radius, (int, float)) or not 0.0 < radius <= LARGEST:
                yield Mistake(f"recording.{field}.{name}", f"{shown(radius)} is not a radius", _REMEDY)
            elif known is not None and not np.isclose(radius, known, rtol=1e-9, atol=0.0):
                yield Mistake(f"recording.{field}.{name}", f"is {shown(radius)}", f"its scenario says {known!r}")


def _shapes(recording: Recording) -> Iterator[Mistake]:
    samples, num_agents = len(recording.time), len(recording.agents)
    shapes: dict[str, tuple[np.ndarray, tuple[int, ...]]] = {
        field: (getattr(recording, field), (samples,)) for field in ("time", "step", "phase", "lyapunov")
    }
    for field in ("mode", "grasp", "effort", "manipulability"):
        shapes[field] = (getattr(recording, field), (samples, num_agents))
    for name in recording.agents:
        shapes[f"centre.{name}"] = (recording.centre[name], (samples, 3))
        shapes[f"qd.{name}"] = (recording.qd[name], np.shape(recording.q[name]))
        shapes[f"q.{name}"] = (recording.q[name], (samples, *np.shape(recording.q[name])[1:2]))
    for name in recording.objects:
        shapes[f"pose.{name}"] = (recording.pose[name], (samples, 7))
        shapes[f"velocity.{name}"] = (recording.velocity[name], (samples, 6))
    for where, (array, shape) in shapes.items():
        if array.shape != shape:
            yield Mistake(f"recording.{where}", f"has shape {array.shape}, not {shape}", _REMEDY)
    if recording.prefix_length < 0 or recording.suffix_length < 1:
        what = f"prefix of {recording.prefix_length} and suffix of {recording.suffix_length} states"
        yield Mistake("recording", what, "a run repeats at least one state")


def _actions(step: StepRecord, scenario: Scenario) -> Iterator[Mistake]:
    where = f"recording.steps.{step.number}"
    if step.halted and not scenario.faults:
        yield Mistake(where, "was halted by a fault", "its scenario has no `faults`")
    if strangers := set(step.faulty) - {*scenario.agent_names, *scenario.object_names}:
        yield Mistake(where, f"a fault befell {listing(sorted(strangers))}", "use the names of its scenario")
    for action in step.actions:
        if set(action) != {"kind", "agents", "object", "from", "to"} or action["kind"] not in ACTION_KINDS:
            yield Mistake(where, f"{shown(action)} is no action", f"kinds are {', '.join(ACTION_KINDS)}")
            continue
        unknown = [name for name in action["agents"] if name not in scenario.agent_names]
        unknown += [name for name in (action["from"], action["to"]) if name not in scenario.region_names]
        if unknown or not action["agents"]:
            what = f"{shown(action)} names {shown(unknown) if unknown else 'no agent'}"
            yield Mistake(where, what, "use the names of its scenario")
        if (action["object"] is None) != (action["kind"] == "travel"):
            yield Mistake(where, f"{shown(action)} is incomplete", "all actions but a travel have an object")
        elif action["object"] is not None and action["object"] not in scenario.object_names:
            yield Mistake(where, f"{shown(action)} names no object", "use the names of its scenario")


def _twice(step: StepRecord) -> Iterator[Mistake]:
    """Nobody has two actions in a step, and what is carried is in no other."""
    agents = [name for action in step.actions for name in action["agents"]]
    carried = [action["object"] for action in step.actions if action["kind"] == "transport"]
    objects = [action["object"] for action in step.actions]
    twice = [*(name for name in agents if agents.count(name) > 1)]
    twice += [name for name in carried if objects.count(name) > 1]
    for name in dict.fromkeys(twice):
        yield Mistake(f"recording.steps.{step.number}", f"{name} has several actions", "one at a time is possible")


def _outcome(recording: Recording) -> Iterator[Mistake]:
    if recording.completed and recording.reason:
        what = f"is completed, and ended early: {recording.reason.splitlines()[0]!r}"
        yield Mistake("recording", what, _REMEDY)
    if not recording.completed and not recording.reason:
        yield Mistake("recording", "is not completed, and has no reason", _REMEDY)


def _indices(recording: Recording) -> Iterator[Mistake]:
    """Steps are numbered from 0 and the samples agree with them."""
    numbers = [step.number for step in recording.steps]
    if numbers != list(range(len(numbers))):
        yield Mistake("recording.steps", f"are numbered {numbers}", _REMEDY)
    step, grasp = recording.step, recording.grasp
    if not len(step):
        return
    if np.any(np.diff(step) < 0) or step[0] < 0 or step[-1] > len(numbers) or step[-1] < len(numbers) - 1:
        yield Mistake("recording.step", f"does not count the {len(numbers)} recorded steps", _REMEDY)
    if grasp.min() < NOTHING or grasp.max() >= len(recording.objects):
        yield Mistake("recording.grasp", "names objects that do not exist", _REMEDY)
    if recording.phase.min() < 0:
        yield Mistake("recording.phase", "is less than 0", _REMEDY)
    if recording.mode.min() < 0 or recording.mode.max() > CARRIES + len(recording.objects) - 1:
        yield Mistake("recording.mode", "is of no kind of motion", _REMEDY)
    if np.any((np.diff(step) == 0) & (np.diff(recording.phase) < 0)):
        yield Mistake("recording.phase", "falls within a step", _REMEDY)
    yield from _of_no_time(recording)


def _grasping_drives(recording: Recording, scenario: Scenario) -> Iterator[Mistake]:
    """Agents without an arm hold nothing, whatever the samples or actions say."""
    for column, agent in enumerate(scenario.agents):
        acts = [a["kind"] for step in recording.steps for a in step.actions if agent.name in a["agents"]]
        if not agent.has_arm and (np.any(recording.grasp[:, column] != NOTHING) or set(acts) - {"travel"}):
            yield Mistake("recording", f"{agent.name} grasps, and has no arm", _REMEDY)


def _of_no_time(recording: Recording) -> Iterator[Mistake]:
    """Steps without samples are the first of the run, if all wait in it, or of those that follow a halt.

    The first step of a plan and those that make a new plan possible can be done as soon as they begin; a step number
    that faults wait for is not to be reached by steps that never were.
    """
    left, counts = 1, Counter(recording.step.tolist())
    for record in recording.steps:
        samples = counts[record.number]
        left -= not samples
        if left < 0 or (not samples and record.number == 0 and record.actions):
            yield Mistake(f"recording.steps.{record.number}", "has no samples", _REMEDY)
        elif samples:
            left = AT_ONCE if record.halted else left if record.number else 0


def _records(recording: Recording) -> Iterator[Mistake]:
    """Steps begin and end with their samples. Times that are none are another matter (`data`)."""
    time, step = recording.time, recording.step
    if not len(step):
        return
    if abs(time[0]) > SAME_TIME:
        yield Mistake("recording.time", f"begins at {time[0]:g} s, not at 0", _REMEDY)
    for record in recording.steps:
        # A step shorter than the sampling has no sample of its own: it begins and ends with the next.
        first, after = np.searchsorted(step, [record.number, record.number + 1])
        finished = bool(after < len(step))
        start, end = float(time[first]), float(time[after if finished else -1])
        where = f"recording.steps.{record.number}"
        if abs(record.start - start) > SAME_TIME:
            yield Mistake(f"{where}.start", f"is {record.start:g} s, its first sample's time {start:g} s", _REMEDY)
        if abs(record.duration - (end - start)) > SAME_TIME:
            yield Mistake(f"{where}.duration", f"is {record.duration:g} s, of its samples {end - start:g} s", _REMEDY)
        if record.finished != finished:
            samples = "go on" if finished else "do not go on"
            yield Mistake(f"{where}.finished", f"is {record.finished}, but samples {samples} after it", _REMEDY)
