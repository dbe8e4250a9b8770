"""A map of a scenario at its start, with everybody's formula beside it."""

from __future__ import annotations

import textwrap
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle

from drake_ltl.planning.geometry import Geometry
from drake_ltl.scenario.model import Agent, Scenario
from drake_ltl.scenario.starts import Starts
from drake_ltl.visualization.palette import INK, MUTED, Colour, member_colours
from drake_ltl.visualization.style import HALO, Drawing, write_figure
from drake_ltl.visualization.top_view import draw_names, draw_scale, draw_workspace, name_places

SIZE = (9.6, 6.4)
"""Width and height [inches]."""
TEXT_WIDTH = 40
"""Characters of a line beside the map."""
MOST_LINES = 46
"""That fit beside it."""


def draw_map(scenario: Scenario, geometry: Geometry, starts: Starts, path: Path) -> Path:
    """Writes the map: regions, bounding spheres of agents (circles) and objects (squares within theirs), from above.

    Args:
        path: ends in .png, .svg or .pdf.

    Raises:
        OSError: the file cannot be written.
    """
    (written,) = write_figure(
        lambda figure: fill_map(figure, scenario, geometry, starts),
        SIZE,
        path.with_suffix(""),
        [path.suffix.lstrip(".")],
    )
    return written


def map_drawing(scenario: Scenario, geometry: Geometry, starts: Starts) -> Drawing:
    """The same, to be written in any format."""
    title = "the workspace at the start, and everybody's formula"
    return Drawing("map", title, SIZE, lambda figure: fill_map(figure, scenario, geometry, starts))


def fill_map(figure: Figure, scenario: Scenario, geometry: Geometry, starts: Starts) -> None:
    """The map, in a figure of one's own: axes with the workspace, and beside them axes with the formulas."""
    colours = member_colours(scenario.agent_names, scenario.object_names)
    grid = figure.add_gridspec(1, 2, width_ratios=(2.1, 1))
    axes = figure.add_subplot(grid[0, 0])
    draw_workspace(axes, scenario)
    _draw_region_names(axes, scenario)
    centres = {name: np.array(start.p_WC[:2]) for name, start in starts.agents.items()}
    centres |= {name: np.array(start.p_WO[:2]) for name, start in starts.objects.items()}
    _draw_agents(axes, scenario, geometry, centres, colours)
    _draw_objects(axes, scenario, geometry, centres, colours)
    draw_names(axes, name_places(centres, geometry.agent_radius, geometry.object_radius), colours, 9.0)
    draw_scale(axes, scenario)
    axes.set_title(f"{scenario.name} at the start", loc="left", fontsize=10.5, color=INK, pad=8)
    beside = figure.add_subplot(grid[0, 1])
    beside.set_axis_off()
    _write_formulas(beside, scenario, colours)


def _draw_region_names(axes: Axes, scenario: Scenario) -> None:
    for region in scenario.regions:
        x, y = region.centre[:2]
        axes.annotate(
            region.name, (x, y - region.radius), (0, -8), textcoords="offset points", ha="center", va="center",
            color=MUTED, fontsize=9.0, style="italic", zorder=6, path_effects=HALO,
        )  # fmt: skip


def _draw_agents(
    axes: Axes,
    scenario: Scenario,
    geometry: Geometry,
    centres: dict[str, np.ndarray],
    colours: dict[str, Colour],
) -> None:
    """Bounding spheres, and in each a dot for the base, from which the arm's sphere is off."""
    for agent in scenario.agents:
        colour = colours[agent.name]
        axes.add_patch(
            Circle(
                centres[agent.name], geometry.agent_radius[agent.name],
                facecolor=(*colour, 0.16), edgecolor=colour, lw=1.3, zorder=4,
            )
        )  # fmt: skip
        axes.plot(*agent.position, marker="o", ms=3.5, color=colour, zorder=5)


def _draw_objects(
    axes: Axes,
    scenario: Scenario,
    geometry: Geometry,
    centres: dict[str, np.ndarray],
    colours: dict[str, Colour],
) -> None:
    for obj in scenario.objects:
        colour, radius = colours[obj.name], geometry.object_radius[obj.name]
        axes.add_patch(
            Circle(centres[obj.name], radius, facecolor=(*colour, 0.16), edgecolor=colour, lw=0.6, zorder=4.5)
        )
        corner, side = centres[obj.name] - radius / np.sqrt(2), radius * np.sqrt(2)
        turned = {"angle": np.rad2deg(obj.heading), "rotation_point": "center"}
        axes.add_patch(Rectangle(corner, side, side, **turned, facecolor=(*colour, 0.9), edgecolor=colour, zorder=4.5))


def _write_formulas(axes: Axes, scenario: Scenario, colours: dict[str, Colour]) -> None:
    """A paragraph for each member, and one for the formula over everything; what does not fit is left out."""
    lines: list[tuple[str, Colour, str]] = []
    for member in (*scenario.agents, *scenario.objects):
        power = f"power {member.power:g}" if isinstance(member, Agent) else f"needs power {member.power_needed:g}"
        lines.append((f"{member.name}  ({power})", colours[member.name], "bold"))
        lines += _wrapped("" if member.spec == "1" else member.spec)
    if scenario.spec != "1":
        lines.append(("all together", INK, "bold"))
        lines += _wrapped(scenario.spec)
    if len(lines) > MOST_LINES:
        lines = [*lines[: MOST_LINES - 1], ("...", INK, "normal")]
    for number, (text, colour, weight) in enumerate(lines):
        axes.text(
            0.0, 1.0 - number / MOST_LINES, text, transform=axes.transAxes, va="top", fontsize=8.0,
            color=colour, weight=weight, parse_math=False,
        )  # fmt: skip


def _wrapped(formula: str) -> list[tuple[str, Colour, str]]:
    lines = textwrap.wrap(formula, TEXT_WIDTH, break_on_hyphens=False)
    return [(f"   {line}", INK, "normal") for line in lines]
