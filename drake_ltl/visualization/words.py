"""Plan steps in words, for titles and captions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from drake_ltl.execution.recording import Recording, StepRecord


def action_words(action: Mapping[str, Any]) -> str:
    """One action of a recording, such as `a2 + a3 carry o2: pi1 → pi3`."""
    agents, obj = " + ".join(action["agents"]), action["object"]
    if action["kind"] == "travel":
        return f"{agents}: {action['from']} → {action['to']}"
    if action["kind"] == "transport":
        verb = "carries" if len(action["agents"]) == 1 else "carry"
        return f"{agents} {verb} {obj}: {action['from']} → {action['to']}"
    verb = {"grasp": "grasps", "release": "releases"}[action["kind"]]
    return f"{agents} {verb} {obj} in {action['from']}"


def actions_words(actions: Iterable[Mapping[str, Any]]) -> list[str]:
    """A line for each action; a step in which nothing happens says so."""
    return [action_words(action) for action in actions] or ["all wait"]


def step_heading(step: StepRecord, recording: Recording) -> str:
    """Such as `Step 3 of 11 (prefix)`; steps are counted from 1 for people."""
    return run_heading(step.number, len(recording.steps), recording.prefix_length, recording.suffix_length)


def run_heading(number: int, num_steps: int, prefix_length: int, suffix_length: int) -> str:
    """The heading of step `number`, from 0, of a run of so many steps."""
    return f"Step {number + 1} of {num_steps} ({_part(number, prefix_length, suffix_length)})"


def _part(number: int, prefix_length: int, suffix_length: int) -> str:
    if number < prefix_length or suffix_length == 0:
        return "prefix"
    return f"suffix, round {(number - prefix_length) // suffix_length + 1}"
