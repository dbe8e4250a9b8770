"""A scenario as a table for people: who is there, and what each must do."""

from __future__ import annotations

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from drake_ltl.scenario.model import Scenario


def scenario_table(scenario: Scenario) -> RenderableType:
    """One row per member with its power and formula; above it what the workspace holds."""
    regions = "; ".join(f"{r.name} ({r.centre[0]:g}, {r.centre[1]:g}), radius {r.radius:g} m" for r in scenario.regions)
    table = Table(box=box.SIMPLE_HEAD)
    for heading in ("member", "kind", "power", "formula"):
        table.add_column(heading, overflow="fold")
    for agent in scenario.agents:
        table.add_row(agent.name, "agent", f"{agent.power:g}", _formula(agent.spec))
    for obj in scenario.objects:
        table.add_row(obj.name, "object", f"needs {obj.power_needed:g}", _formula(obj.spec))
    if scenario.spec != "1":
        table.add_row("all together", "", "", Text(scenario.spec))
    return Group(Text(summary(scenario)), Text(f"regions: {regions}"), table)


def summary(scenario: Scenario) -> str:
    """Such as `case_ii: 3 agents, 2 objects, 4 regions`."""
    counts = ((scenario.agents, "agent"), (scenario.objects, "object"), (scenario.regions, "region"))
    return f"{scenario.name}: " + ", ".join(f"{len(all_)} {kind}{'s' * (len(all_) != 1)}" for all_, kind in counts)


def _formula(spec: str) -> Text:
    return Text("" if spec == "1" else spec)
