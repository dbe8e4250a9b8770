"""Top views of a run: one figure for each plan step, as Figs. 3 and 4 of the paper, and all steps on one sheet."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Sequence

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from drake_ltl.execution.recording import Recording, StepRecord
from drake_ltl.scenario.model import Scenario
from drake_ltl.visualization.palette import INK
from drake_ltl.visualization.style import Drawing
from drake_ltl.visualization.top_view import View, draw_region_names, draw_scale, draw_step, draw_workspace, show_region
from drake_ltl.visualization.words import actions_words, step_heading

MAX_CLOSE_UPS = 3
"""Regions shown close up beside the whole workspace."""
TITLE_WIDTH = 88
"""Characters that fit a line above a figure."""
SHEET_TITLE_WIDTH = 46
"""... above one step of the sheet."""
LINE_HEIGHT = 0.13
"""Of a line there [inches]."""


def step_drawings(recording: Recording, scenario: Scenario) -> list[Drawing]:
    """step_01, step_02, ...: none where the run ended before its first sample."""
    view = View.of(recording, scenario)
    digits = max(2, len(str(len(recording.steps))))
    return [_step_drawing(view, step, digits) for step in recording.steps]


def sheet_drawing(recording: Recording, scenario: Scenario) -> Drawing:
    """All steps of a run that has some, side by side."""
    view = View.of(recording, scenario)
    rows, columns, size = _sheet(recording.steps)
    return Drawing("steps", "ways of all steps", size, lambda figure: _draw_sheet(figure, view, rows, columns))


def _step_drawing(view: View, step: StepRecord, digits: int) -> Drawing:
    regions = _acting_regions(step)
    size = (8.6, 6.6) if regions else (6.4, 6.9)
    title = f"ways of {step_heading(step, view.recording).lower()}"
    return Drawing(
        f"step_{step.number + 1:0{digits}d}", title, size, lambda figure: _draw_step(figure, view, step, regions)
    )


def _sheet(steps: Sequence[StepRecord]) -> tuple[int, int, tuple[float, float]]:
    """Rows, columns, and width and height [inches] that leave room for the titles."""
    columns = min(5, math.ceil(math.sqrt(len(steps))))
    rows = math.ceil(len(steps) / columns)
    tallest = max(len(_sheet_title(step)) for step in steps)
    return rows, columns, (2.9 * columns, (2.9 + 0.2 + LINE_HEIGHT * tallest) * rows)


def _acting_regions(step: StepRecord) -> list[str]:
    """Regions in which the step's actions end, each once."""
    return list(dict.fromkeys(action["to"] for action in step.actions))[:MAX_CLOSE_UPS]


def _draw_step(figure: Figure, view: View, step: StepRecord, regions: list[str]) -> None:
    figure.suptitle(_title(view.recording, step), fontsize=10.5, color=INK, x=0.02, ha="left")
    if regions:
        grid = figure.add_gridspec(MAX_CLOSE_UPS, 2, width_ratios=(3.1, 1))
        axes = figure.add_subplot(grid[:, 0])
    else:
        grid, axes = None, figure.add_subplot()
    draw_workspace(axes, view.scenario)
    draw_step(axes, view, step)
    draw_region_names(axes, view, step)
    draw_scale(axes, view.scenario)
    _draw_key(axes)
    for place, region in enumerate(regions):
        close_up = figure.add_subplot(grid[place, 1])
        draw_workspace(close_up, view.scenario)
        draw_step(close_up, view, step, font_size=8.5)
        show_region(close_up, view, region)


def _draw_key(axes) -> None:
    lines = [
        Line2D([], [], color=INK, lw=0.9, ls=(0, (3, 2)), label="begin"),
        Line2D([], [], color=INK, lw=1.3, label="end"),
    ]
    axes.legend(handles=lines, loc="lower right", ncols=1, handlelength=1.8, borderpad=0.0)


def _draw_sheet(figure: Figure, view: View, rows: int, columns: int) -> None:
    figure.get_layout_engine().set(h_pad=0.08)
    for place, step in enumerate(view.recording.steps):
        axes = figure.add_subplot(rows, columns, place + 1)
        draw_workspace(axes, view.scenario)
        draw_step(axes, view, step, font_size=6.5)
        draw_region_names(axes, view, step, font_size=6.5)
        axes.set_title("\n".join(_sheet_title(step)), fontsize=7.0, loc="left")


def _sheet_title(step: StepRecord) -> list[str]:
    first, *others = actions_words(step.actions)
    return _joined([f"{step.number + 1}   {first}", *others], SHEET_TITLE_WIDTH)


def _title(recording: Recording, step: StepRecord) -> str:
    end = step.start + step.duration
    heading = f"{step_heading(step, recording)}, {step.start:.1f} to {end:.1f} s"
    if not step.finished:
        heading += ", not finished"
    return "\n".join([heading, *_joined(actions_words(step.actions), TITLE_WIDTH)])


def _joined(parts: Iterable[str], width: int) -> list[str]:
    """Parts on as few lines of at most `width` characters as they need; only what is longer than a line is broken."""
    lines: list[str] = []
    for part in parts:
        if lines and len(lines[-1]) + len(part) + 4 <= width:
            lines[-1] += f"    {part}"
        else:
            lines += textwrap.wrap(part, width, subsequent_indent="    ", break_on_hyphens=False)
    return lines
