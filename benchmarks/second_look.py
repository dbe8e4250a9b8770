"""A recording judged once more, without a line of drake_ltl: where spheres are, and what formulas say of the word.

What robots look like is written down here anew: spheres come from the joints by the planar arm's own trigonometry,
radii from the scenario's text, formulas are trees, and LTL is evaluated by its fixed points. Only for missions of
planar arms whose file states headings and radii.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

SHOULDER = 0.2
"""Height of the shoulder [m]; the sphere's centre is ..."""
ALONG = 0.8
"""... so far from it along the first link [m]."""
CARRIES = 3
"""In `mode`: this and more carries an object."""
ROUNDING = 1e-6
"""[m]"""
Formula = tuple
"""("true",), ("is", member, region), or a head with its parts: ! X F G & | U."""


class Look:
    """What a recording's file shows."""

    def __init__(self, path: Path):
        with np.load(path) as archive:
            self.data = {name: archive[name] for name in archive.files if name != "header"}
            self.header = json.loads(archive["header"].tobytes())
        self.scenario: dict[str, Any] = yaml.safe_load(self.header["scenario"])
        self.agents, self.objects = self.header["agents"], self.header["objects"]
        blocks = {**self.scenario["agents"], **(self.scenario["objects"] or {})}
        self.radius = {name: float(blocks[name]["radius"]) for name in (*self.agents, *self.objects)}
        self.team = {o: float(blocks[o].get("team_radius") or self.scenario["team_radius"]) for o in self.objects}
        self.centre = {name: self._agent_centre(name, blocks[name]["heading"]) for name in self.agents}
        self.centre |= {name: self.data[f"pose/{name}"][:, 4:] for name in self.objects}
        self.regions = {
            name: (np.array(region["centre"], float), float(region["radius"]))
            for name, region in self.scenario["regions"].items()
        }

    def _agent_centre(self, name: str, heading: float) -> np.ndarray:
        """(T, 3) [m]: a mast that leans by q1 in the plane of the heading."""
        x, y, lean, _ = self.data[f"q/{name}"].T
        out = ALONG * np.sin(lean)
        return np.stack([x + out * np.cos(heading), y + out * np.sin(heading), SHOULDER + ALONG * np.cos(lean)], axis=1)

    def region(self, member: str, sample: int) -> str | None:
        """The region that holds all of the member's sphere."""
        for name, (centre, radius) in self.regions.items():
            if np.linalg.norm(self.centre[member][sample] - centre) + self.radius[member] <= radius + ROUNDING:
                return name
        return None

    def end(self, step: Mapping[str, Any]) -> int:
        """The sample that shows what a step came to: the first that is not its own any more."""
        return min(int(np.flatnonzero(self.data["step"] == step["number"])[-1]) + 1, len(self.data["step"]) - 1)


def findings(path: Path, formulas: Sequence[Formula]) -> list[str]:
    """All that is wrong with a run: nothing if it is done, kept everybody apart, and satisfies every formula."""
    look = Look(path)
    empty = {step["number"] for step in look.header["steps"]} - set(look.data["step"].tolist())
    if empty:
        return [f"step {number} has no samples" for number in sorted(empty)]
    found = [*_touching(look), *_outside(look), *_where_nobody_may_be(look)]
    return found + list(_word_findings(look, formulas))


def _touching(look: Look) -> Iterator[str]:
    """Any two spheres; an object and who acts on it excepted. Who carries is a ball with what he carries."""
    for a, b in itertools.combinations((*look.agents, *look.objects), 2):
        apart = np.linalg.norm(look.centre[a] - look.centre[b], axis=1) - look.radius[a] - look.radius[b]
        if b in look.objects and a in look.agents:
            apart = np.where(_acts_on(look, a, b), np.inf, apart)
        if apart.min() <= 0.0:
            yield f"{a} and {b} overlap by {-apart.min():.4f} m at {look.data['time'][apart.argmin()]:.3f} s"
    for number, carried in enumerate(look.objects):
        team = look.data["mode"] == CARRIES + number  # (T, agents)
        for other in (*look.agents, *look.objects):
            own = team[:, look.agents.index(other)] if other in look.agents else np.zeros(len(team), bool)
            if other == carried or not (concerned := team.any(axis=1) & ~own).any():
                continue
            apart = np.linalg.norm(look.centre[carried] - look.centre[other], axis=1)[concerned]
            least = float(apart.min()) - look.team[carried] - look.radius[other]
            if least <= 0.0:
                yield f"the team of {carried} and {other} overlap by {-least:.4f} m"


def _acts_on(look: Look, agent: str, obj: str) -> np.ndarray:
    """(T,) whether the agent holds the object, or is to grasp, carry or release it in the step."""
    acts = look.data["grasp"][:, look.agents.index(agent)] == look.objects.index(obj)
    for step in look.header["steps"]:
        if any(action["object"] == obj and agent in action["agents"] for action in step["actions"]):
            acts = acts | (look.data["step"] == step["number"])
    return acts


def _outside(look: Look) -> Iterator[str]:
    for member, centre in look.centre.items():
        out = np.linalg.norm(centre, axis=1) + look.radius[member] - look.scenario["workspace"]["radius"]
        if out.max() > 0.0:
            yield f"{member} leaves the workspace by {out.max():.4f} m"


def _where_nobody_may_be(look: Look) -> Iterator[str]:
    """Movers touch no region but those of their way, and end in its goal; all others stay where they are."""
    for step in look.header["steps"]:
        samples = np.flatnonzero(look.data["step"] == step["number"])
        ways = {
            member: (action["from"], action["to"])
            for action in step["actions"]
            if action["kind"] in ("travel", "transport")
            for member in (*action["agents"], *([action["object"]] if action["object"] else []))
        }
        for member, name in itertools.product(look.centre, look.regions):
            centre, radius = look.regions[name]
            distance = np.linalg.norm(look.centre[member][samples] - centre, axis=1)
            stays = member not in ways and name == look.region(member, samples[0])
            if stays and distance.max() + look.radius[member] > radius + ROUNDING:
                yield f"{member} leaves {name} in step {step['number']}, in which it has no way to go"
            if not stays and name not in ways.get(member, ()) and distance.min() <= radius + look.radius[member]:
                yield f"{member} touches {name} in step {step['number']}"
        for member, (_, goal) in ways.items():
            if step["finished"] and look.region(member, look.end(step)) != goal:
                yield f"{member} has not come to {goal} in step {step['number']}"


def _word_findings(look: Look, formulas: Sequence[Formula]) -> Iterator[str]:
    begin, cycle = look.header["prefix_length"], look.header["suffix_length"]
    ends = [look.end(step) for step in look.header["steps"] if step["finished"]]
    if len(ends) < begin + cycle:
        yield f"ended after {len(ends)} of {begin + cycle} steps"
        return
    word = [{name: look.region(name, sample) for name in look.centre} for sample in (0, *ends[: begin + cycle])]
    if word[begin] != word[-1]:
        yield "the round does not lead back to where it began"
    for formula in formulas:
        if not truth(formula, word[:-1], begin)[0]:
            yield f"the word does not satisfy {formula}"


def truth(formula: Formula, word: Sequence[Mapping[str, str | None]], loop: int) -> list[bool]:
    """Truth at every position of a word whose last letter is followed by word[loop]; a letter is member -> region."""
    head, *parts = formula
    if head == "true":
        return [True] * len(word)
    if head == "is":
        return [letter[parts[0]] == parts[1] for letter in word]
    values = [truth(part, word, loop) for part in parts]
    if head == "!":
        return [not value for value in values[0]]
    if head in "&|":
        join = all if head == "&" else any
        return [join(pair) for pair in zip(*values, strict=True)]
    after = [*range(1, len(word)), loop]
    if head == "X":
        return [values[0][k] for k in after]
    if head == "G":  # what never fails
        return [not value for value in truth(("F", ("!", parts[0])), word, loop)]
    until = values[0] if head == "U" else [True] * len(word)
    result = list(values[-1])
    for _ in word:  # the least fixed point is reached once every letter has heard of every other
        result = [now or (until[k] and result[after[k]]) for k, now in enumerate(values[-1])]
    return result
