"""The word of the run, read off the poses, and the formulas on it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from drake_ltl.execution.recording import NOTHING, Recording
from drake_ltl.scenario.formulas import canonical, labels, propositions
from drake_ltl.scenario.model import Scenario
from drake_ltl.verification.ltl import holds
from drake_ltl.verification.regions import region_at
from drake_ltl.verification.spans import Span, state_samples
from drake_ltl.verification.violations import Violation

Letter = frozenset[str]
"""Propositions `member.proposition` that hold at one position of the word."""


@dataclass(frozen=True)
class Reading:
    """One state of the run as the poses and the welds show it."""

    time: float
    """[s]"""
    regions: dict[str, str | None]
    """member -> the region that contains its sphere."""
    grasps: dict[str, str | None]
    letter: Letter


def readings(recording: Recording, scenario: Scenario, spans: Sequence[Span]) -> list[Reading]:
    """The start, then the end of each finished step; a member in no region is offered nothing."""
    members = (*recording.agents, *recording.objects)
    grasp_samples = [0, *(span.last for span in spans if span.finished)]
    found = []
    for sample, grasp_sample in zip(state_samples(spans), grasp_samples, strict=True):
        regions = {member: region_at(recording, scenario, member, sample) for member in members}
        welded = zip(recording.agents, recording.grasp[grasp_sample].tolist(), strict=True)
        grasps = {agent: None if index == NOTHING else recording.objects[index] for agent, index in welded}
        found.append(Reading(float(recording.time[sample]), regions, grasps, _letter(scenario, regions)))
    return found


def letter_at(recording: Recording, scenario: Scenario, sample: int) -> Letter:
    """What the poses of one sample show."""
    members = (*recording.agents, *recording.objects)
    return _letter(scenario, {member: region_at(recording, scenario, member, sample) for member in members})


def _letter(scenario: Scenario, regions: Mapping[str, str | None]) -> Letter:
    offered = [labels(scenario, member, region) for member, region in regions.items() if region is not None]
    return frozenset().union(*offered)


def last_round(recording: Recording, num_states: int) -> tuple[int, int] | None:
    """States in which the last round of the suffix begins and ends, wherever in the suffix; None if there is none.

    It ends with the last state, so that every state of the run is in the word.
    """
    begin = num_states - 1 - recording.suffix_length
    return (begin, num_states - 1) if begin >= recording.prefix_length else None


def word_violations(recording: Recording, scenario: Scenario, states: Sequence[Reading]) -> Iterator[Violation]:
    """The round must lead back to where it began; the word that repeats it must satisfy every formula."""
    loop = last_round(recording, len(states))
    if recording.completed:
        yield from _incomplete(recording, len(states) - 1)
    if loop is None:
        return
    begin, end = loop
    yield from _loop_violations(states[begin], states[end], end - 1)
    word = [state.letter for state in states]
    for member in (*scenario.agents, *scenario.objects):
        own = [_own(scenario, member.name, letter) for letter in word]
        if not holds(member.spec, own[:begin], own[begin:end]):
            yield Violation("formula", (member.name,), f"{member.name} does not satisfy its formula {member.spec}")
    if not holds(scenario.spec, word[:begin], word[begin:end]):
        yield Violation("formula", (), f"the run does not satisfy the global formula {scenario.spec}")


def _incomplete(recording: Recording, done: int) -> Iterator[Violation]:
    """What a run that is said to be completed lacks."""
    needed = recording.prefix_length + recording.suffix_length
    if done < needed:
        what = f"{done} of the {needed} steps to the end of one round of the suffix were carried out"
        yield Violation("run", (), what)
    elif done < len(recording.steps):
        yield Violation("run", (), "the run is completed, and its last step has not finished", step=done)


def _loop_violations(begin: Reading, end: Reading, step: int) -> Iterator[Violation]:
    for member, region in end.regions.items():
        if region != begin.regions[member]:
            what = f"the round ends with {member} in {_named(region)}, it began in {_named(begin.regions[member])}"
            yield Violation("loop", (member,), what, end.time, step)
    for agent, obj in end.grasps.items():
        if obj != begin.grasps[agent]:
            first = begin.grasps[agent] or "nothing"
            what = f"the round ends with {agent} grasping {obj or 'nothing'}, it began with {first}"
            yield Violation("loop", (agent,), what, end.time, step)


def _own(scenario: Scenario, member: str, letter: Letter) -> Letter:
    """The letter as the member experiences it, under the names its own formula uses."""
    return frozenset(name for name in propositions(scenario, member) if canonical(member, name) in letter)


def _named(region: str | None) -> str:
    return "no region" if region is None else region
