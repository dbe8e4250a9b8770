"""What the pages say beside their scene, as plain data: titles, steps, activities, goals, colours, cameras."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from drake_ltl.errors import DrakeLtlError
from drake_ltl.execution.recording import Recording
from drake_ltl.planning.demands import Demand, demands
from drake_ltl.planning.mission import Mission
from drake_ltl.planning.plan_json import action_to_json
from drake_ltl.planning.remaining import Goal, pursuits
from drake_ltl.planning.sentences import sentence
from drake_ltl.scenario.model import Scenario
from drake_ltl.verification.spans import state_samples, step_spans
from drake_ltl.verification.word import letter_at
from drake_ltl.visualization.activity import Changes, activity_changes
from drake_ltl.visualization.palette import hex_code, member_colours
from drake_ltl.visualization.words import actions_words, step_heading


@dataclass(frozen=True)
class Chapter:
    """One step of a run, or its end."""

    begin: float
    """[s]"""
    heading: str
    lines: tuple[str, ...]
    """Its actions."""
    goals: tuple[tuple[str, str], ...] = ()
    """For each of the page's demands how it stands when the step begins, and what is left of it."""


@dataclass(frozen=True)
class PageData:
    """All that a page shows beside its scene."""

    title: str
    chapters: tuple[Chapter, ...]
    """Of a recorded run; a live page is told its own as it goes on."""
    legend: Mapping[str, str] = field(default_factory=dict)
    """Member -> CSS colour."""
    activities: Mapping[str, Changes] = field(default_factory=dict)
    """Member -> what it does and since when."""
    demands: tuple[tuple[str, str, str], ...] = ()
    """Owner, formula and meaning in words of what is pursued."""
    steps: tuple[str, ...] = ()
    """Of a live page: the plan, a text for each step."""
    loop: int = 0
    """Of a live page: index of the step that follows the last."""
    radius: float = 0.0
    """Of the workspace [m]; 0 if there are no cameras to choose."""
    live: bool = False

    def to_json(self) -> dict[str, Any]:
        """As the page's script reads it."""
        return {
            "title": self.title,
            "chapters": [
                {"begin": c.begin, "heading": c.heading, "lines": list(c.lines), "goals": list(map(list, c.goals))}
                for c in self.chapters
            ],
            "legend": list(self.legend.items()),
            "activities": {name: list(map(list, changes)) for name, changes in self.activities.items()},
            "demands": list(map(list, self.demands)),
            "steps": list(self.steps),
            "loop": self.loop,
            "radius": self.radius,
            "live": self.live,
        }


def recorded_page_data(recording: Recording, scenario: Scenario) -> PageData:
    """Of a run that is over."""
    goals, asked = _goals_of(recording, scenario)
    return PageData(
        title=scenario.name,
        chapters=tuple(_chapters(recording, goals)),
        legend=legend_of(recording.agents, recording.objects),
        activities=activity_changes(recording) if len(recording.time) else {},
        demands=asked,
        radius=scenario.workspace_radius,
    )


def live_page_data(mission: Mission, scenario: Scenario) -> PageData:
    """Of a run that begins."""
    return PageData(
        title=scenario.name,
        chapters=(),
        legend=legend_of(scenario.agent_names, scenario.object_names),
        demands=demand_texts(scenario),
        steps=tuple("; ".join(actions_words(map(action_to_json, step.actions))) for step in mission.steps),
        loop=mission.loop,
        radius=scenario.workspace_radius,
        live=True,
    )


def legend_of(agents: Sequence[str], objects: Sequence[str]) -> dict[str, str]:
    """Name -> CSS colour of all members."""
    return {name: hex_code(colour) for name, colour in member_colours(agents, objects).items()}


def demand_texts(scenario: Scenario) -> tuple[tuple[str, str, str], ...]:
    """Owner, formula and meaning in words of every part of the specification."""
    return tuple(_demand_text(scenario, part) for part in demands(scenario))


def standings(goals: Iterable[Goal]) -> tuple[tuple[str, str], ...]:
    """As chapters have them."""
    return tuple((goal.standing.value, goal.left) for goal in goals)


def _demand_text(scenario: Scenario, part: Demand) -> tuple[str, str, str]:
    return part.owner or "all", str(part).partition(": ")[2], sentence(scenario, part)


def _chapters(recording: Recording, goals: Sequence[tuple[tuple[str, str], ...]]) -> Iterable[Chapter]:
    """One for each step, and one for the end."""

    def owed(position: int) -> tuple[tuple[str, str], ...]:
        return goals[min(position, len(goals) - 1)] if goals else ()

    for step in recording.steps:
        lines = tuple(actions_words(step.actions))
        yield Chapter(step.start, step_heading(step, recording), lines, owed(step.number))
    if len(recording.time) and recording.steps:
        last = recording.steps[-1]
        end = last.start + last.duration
        if recording.completed:
            yield Chapter(end, "All steps done", (), owed(len(recording.steps)))
        else:
            yield Chapter(end, "Stopped", (recording.reason,), owed(last.number))


def _goals_of(recording: Recording, scenario: Scenario) -> tuple[list[tuple[tuple[str, str], ...]], tuple]:
    """How the demands stand at each state of the word that the poses spell; nothing where that cannot be told."""
    if not len(recording.time) or not recording.steps:
        return [], ()
    try:
        samples = state_samples(step_spans(recording))
        word = [letter_at(recording, scenario, sample) for sample in samples]
        found = pursuits(scenario, word, recording.prefix_length, recording.suffix_length)
        return list(map(standings, found)), demand_texts(scenario)
    except (DrakeLtlError, ValueError, IndexError, KeyError):  # a page is shown of damaged recordings too
        return [], ()
