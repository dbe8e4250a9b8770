"""A verdict for a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rich import box
from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from drake_ltl.execution.recording_versions import VERSION
from drake_ltl.quantities import quantity
from drake_ltl.scenario.model import Scenario
from drake_ltl.verification.detours import EXCHANGED, WORDS
from drake_ltl.verification.drives import SLIDE, turn_limit
from drake_ltl.verification.grasps import HELD_ANGLE, HELD_GAP
from drake_ltl.verification.headings import limit
from drake_ltl.verification.lyapunov import RISE
from drake_ltl.verification.verdict import Verdict

CLEARANCE_NAMES = {
    "agent_agent": "agent to agent",
    "agent_object": "agent to object",
    "object_object": "object to object",
    "team_other": "carrying team to others",
    "forbidden_region": "mover to other regions",
    "workspace": "to the workspace's border",
}

ROUNDING = 1e-12
"""What is left of a manipulability of zero."""


def verdict_table(verdict: Verdict, scenario: Scenario | None = None) -> RenderableType:
    """Headline, violations, the steps with their letters and durations, and the measured numbers.

    Without the scenario some of what was demanded is left out.
    """
    word = "SATISFIED" if verdict.satisfied else "VIOLATED"
    head = Text.assemble(
        (word, "bold green" if verdict.satisfied else "bold red"), f"  {scenario.name if scenario else ''}".rstrip()
    )
    faults = [Padding(Text(str(violation), style="red"), (0, 0, 0, 2)) for violation in verdict.violations]
    return Group(head, *faults, _steps(verdict), _numbers(verdict, scenario))


def _steps(verdict: Verdict) -> Table:
    """The letter of each row is the one at the end of its step: the regions in which everybody then is."""
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1))
    table.add_column("step", justify="right", no_wrap=True)
    table.add_column("actions", overflow="fold", ratio=3)
    table.add_column("letter", overflow="fold", ratio=2)
    table.add_column("seconds", justify="right", no_wrap=True)
    letters = [" ".join(letter) or "\N{EN DASH}" for letter in verdict.word]
    if letters:
        table.add_row("", "start", letters[0], "")
    for index, step in enumerate(verdict.steps, start=1):
        texts = [action_text(action) for action in step.actions]
        texts += [f"({EXCHANGED})"] if step.number in verdict.exchanges else []
        texts += [f"({WORDS})"] if step.number in verdict.detours else []
        letter = letters[index] if index < len(letters) else ""
        table.add_row(str(index), "\n".join(texts) or "all wait", letter, f"{step.duration:.1f}")
    return table


def _numbers(verdict: Verdict, scenario: Scenario | None) -> Table:
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1))
    table.add_column("measured", no_wrap=True)
    table.add_column("worst", justify="right", no_wrap=True)
    table.add_column("demanded", no_wrap=True)
    for row in _rows(verdict, scenario):
        table.add_row(*row)
    return table


def _rows(verdict: Verdict, scenario: Scenario | None) -> Iterator[tuple[str, str, str]]:
    for kind, name in CLEARANCE_NAMES.items():
        value = verdict.min_clearance[kind]
        if value is not None:
            yield f"clearance {name}", quantity(value, "m"), "> 0"
    if verdict.min_inside_teams is not None:
        yield "distance inside teams, of bodies", quantity(verdict.min_inside_teams, "m"), "> 0"
    older = "" if verdict.version_of_V == VERSION else f" of version {verdict.version_of_V}"
    yield f"rise of V{older}, relative to its start", f"{verdict.max_lyapunov_increase:.3g}", f"<= {RISE:g}"
    if any(action["kind"] == "grasp" for step in verdict.steps for action in step.actions):
        gap, angle = _weld_limits(scenario)
        yield "gap of a weld", quantity(verdict.max_weld_error, "m"), gap
        yield "turn of a weld", quantity(verdict.max_weld_angle, "rad"), angle
        yield "tilt of an object", quantity(verdict.max_tilt, "rad"), ""
    if verdict.max_heading_error is not None:
        most = f"<= {quantity(limit(scenario), 'rad')}" if scenario else ""
        yield "turn of an object from its heading", quantity(verdict.max_heading_error, "rad"), most
    if verdict.max_arrival_turn is not None:
        most = f"<= {quantity(turn_limit(scenario), 'rad')}" if scenario else ""
        yield "turn of a drive from its heading", quantity(verdict.max_arrival_turn, "rad"), most
    if verdict.max_slide is not None:
        yield "speed of a drive aside", quantity(verdict.max_slide, "m/s"), f"<= {quantity(SLIDE, 'm/s')}"
    if verdict.max_effort:
        agent = max(verdict.max_effort, key=verdict.max_effort.__getitem__)
        saturated = "" if verdict.max_effort[agent] <= 1.0 else "cut off at 100 %"
        yield f"torque asked of {agent}, of its limit", f"{100.0 * verdict.max_effort[agent]:.3g} %", saturated
    if verdict.min_manipulability:
        agent = min(verdict.min_manipulability, key=verdict.min_manipulability.__getitem__)
        least = verdict.min_manipulability[agent]
        yield f"manipulability of {agent}", f"{least:.3g}" if least > ROUNDING else "0", "(0: singular)"
    yield "simulated time", f"{verdict.simulated_seconds:.1f} s", ""


def _weld_limits(scenario: Scenario | None) -> tuple[str, str]:
    if scenario is None:
        return "", ""
    gap = max(HELD_GAP, scenario.tolerances.weld_position)
    angle = max(HELD_ANGLE, scenario.tolerances.weld_angle)
    return f"<= {quantity(gap, 'm')}", f"<= {quantity(angle, 'rad')}"


def action_text(action: Mapping[str, Any]) -> str:
    """One action, such as `a1: pi1 → pi2`, `a2 grasps o2` or `{a2, a3} carry o2: pi1 → pi3`."""
    agents, way = action["agents"], f"{action['from']} \N{RIGHTWARDS ARROW} {action['to']}"
    if action["kind"] == "travel":
        return f"{', '.join(agents)}: {way}"
    if action["kind"] == "transport":
        who = f"{agents[0]} carries" if len(agents) == 1 else f"{{{', '.join(agents)}}} carry"
        return f"{who} {action['object']}: {way}"
    return f"{', '.join(agents)} {action['kind']}s {action['object']}"
