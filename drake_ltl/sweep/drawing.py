"""All that is drawn for a run, and the scenario that it makes.

Drawn are the starts, the gains of the controllers, and the masses of the objects. The controllers know their gains; of
the masses they know nothing: they carry what the models' files say.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from drake_ltl.scenario import loads
from drake_ltl.scenario.model import Scenario
from drake_ltl.scenario.model_access import ANYWHERE, allow_models
from drake_ltl.scenario.yaml_text import parse
from drake_ltl.sweep.starts import Position, draw_starts
from drake_ltl.sweep.sweep import Sweep
from drake_ltl.whole_files import write_text_whole

GAINS = ("force", "base_damping", "arm_damping", "team_damping", "team_rotation_damping")
"""Of the scenario's block `controller`."""


@dataclass(frozen=True)
class Drawn:
    """What is a run's own."""

    positions: Mapping[str, Position]
    """Of every member, in W [m]."""
    gains: Mapping[str, float]
    """Of `GAINS`, in their own units."""
    masses: Mapping[str, float]
    """object -> what its mass and its inertia are multiplied with in the plant."""


def draw(sweep: Sweep, number: int) -> Drawn:
    """What belongs to run `number`; the same whoever draws it, and when."""
    rng = sweep.random(number)
    controller = sweep.scenario.controller
    gains = {name: _rounded(getattr(controller, name) * _factor(sweep.gains, rng)) for name in GAINS}
    masses = {name: _rounded(_factor(sweep.masses, rng)) for name in sweep.scenario.object_names}
    return Drawn(draw_starts(sweep.scenario, sweep.geometry, sweep.plan, rng), gains, masses)


def drawn_text(scenario: Scenario, drawn: Drawn) -> str:
    """The scenario as YAML with drawn starts and gains; models are named by whole paths, masses are those of models."""
    data = parse(scenario.source, scenario.name)
    data["name"] = scenario.name
    for block, members in (("agents", scenario.agents), ("objects", scenario.objects)):
        for member in members:
            data[block][member.name] |= {"model": member.model, "position": list(drawn.positions[member.name])}
    data["controller"] = {**(data.get("controller") or {}), **drawn.gains}
    return yaml.safe_dump(data, sort_keys=False, allow_unicode=True, default_flow_style=None, width=120)


def drawn_scenario(scenario: Scenario, drawn: Drawn) -> Scenario:
    """What the text says."""
    with allow_models(ANYWHERE):  # the scenario's own were looked at when it was read
        return loads(drawn_text(scenario, drawn), source_name=scenario.name)


def write_drawn(scenario: Scenario, drawn: Drawn, path: Path, heading: str) -> None:
    """Writes the text under a comment that says what it leaves out. Raises OSError if it cannot."""
    masses = ", ".join(f"{name} {factor:g}" for name, factor in drawn.masses.items())
    lines = [heading, *([f"masses in the run, as shares of the models': {masses}"] if masses else [])]
    comment = "".join(f"# {' '.join(line.split())}\n" for line in lines)
    write_text_whole(path, comment + drawn_text(scenario, drawn))


def drawn_from_json(data: Mapping[str, Any]) -> Drawn:
    """The inverse of `dataclasses.asdict`, after a way through JSON."""
    positions = {name: (float(x), float(y)) for name, (x, y) in data["positions"].items()}
    return Drawn(positions, dict(data["gains"]), dict(data["masses"]))


def _factor(per_cent: float, rng: np.random.Generator) -> float:
    return 1.0 + per_cent / 100.0 * rng.uniform(-1.0, 1.0)


def _rounded(value: float) -> float:
    return float(f"{value:.6g}")
