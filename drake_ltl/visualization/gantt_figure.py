"""Who did what, and when: a bar for each stretch of time in which an agent did the same."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.transforms import ScaledTranslation

from drake_ltl.execution.recording import NOTHING, Recording
from drake_ltl.visualization.activity import REACH, TRAVEL
from drake_ltl.visualization.palette import AGENT_HUES, GRID, INK, MUTED, Colour, mixed
from drake_ltl.visualization.spheres import CARRIES
from drake_ltl.visualization.style import Drawing
from drake_ltl.visualization.time_figures import time_axis

WIDTH, ROW_HEIGHT, MARGINS = 8.2, 0.32, 1.15
"""[inches]"""
WHITE = (1.0, 1.0, 1.0)
KINDS: dict[str, tuple[str, Colour]] = {
    "travel": ("travels", mixed(AGENT_HUES[0], WHITE, 0.25)),
    "reach": ("grasps or releases", mixed(AGENT_HUES[5], WHITE, 0.15)),
    "carry": ("carries", mixed(AGENT_HUES[1], WHITE, 0.25)),
    "hold": ("holds an object", mixed(AGENT_HUES[1], WHITE, 0.75)),
}
"""Label and colour; who waits has no bar."""
LETTER_WIDTH = 0.075
"""[inches], about: labels that do not fit their bar are left out."""


@dataclass(frozen=True)
class Bar:
    """An agent did the same from `start` to `end` [s]."""

    kind: str
    start: float
    end: float
    label: str
    """Where to, or what with."""


def gantt_drawing(recording: Recording) -> Drawing:
    """Agents over time; a recording with at least one sample."""
    size = (WIDTH, MARGINS + ROW_HEIGHT * len(recording.agents))
    return Drawing("gantt", "what each agent does over time", size, lambda figure: _draw(figure, recording))


def bars(recording: Recording, agent: str) -> Iterator[Bar]:
    """In order of time, without the stretches in which the agent waits."""
    column = recording.agents.index(agent)
    mode, grasp = recording.mode[:, column], recording.grasp[:, column]
    holding = (mode == 0) & (grasp != NOTHING)
    kind = np.where(holding, -1 - grasp, mode)  # holding is told apart by what is held
    cuts = np.flatnonzero((np.diff(kind) != 0) | (np.diff(recording.step) != 0)) + 1
    for first, after in zip([0, *cuts.tolist()], [*cuts.tolist(), len(kind)], strict=True):
        name = _kind(int(kind[first]))
        if name:
            start, end = recording.time[first], recording.time[min(after, len(kind) - 1)]
            yield Bar(name, float(start), float(end), _label(recording, agent, name, first))


def _kind(number: int) -> str:
    if number < 0:
        return "hold"
    return {0: "", TRAVEL: "travel", REACH: "reach"}.get(number, "carry")


def _label(recording: Recording, agent: str, kind: str, row: int) -> str:
    """The region that it moves to, or the object in its hand."""
    if kind == "hold":
        return recording.objects[recording.grasp[row, recording.agents.index(agent)]]
    number = int(recording.step[row])
    actions = recording.steps[number].actions if number < len(recording.steps) else ()
    action = next((action for action in actions if agent in action["agents"]), None)
    if action is None:
        return ""
    if kind == "carry":
        carried = recording.objects[recording.mode[row, recording.agents.index(agent)] - CARRIES]
        return f"{carried} to {action['to']}"
    return action["object"] or action["to"]


def _draw(figure: Figure, recording: Recording) -> None:
    axes = figure.add_subplot()
    for row, agent in enumerate(recording.agents):
        _draw_row(axes, row, list(bars(recording, agent)), (WIDTH - 0.8) / max(recording.time[-1], 1e-9))
    axes.set_yticks(range(len(recording.agents)), recording.agents)
    axes.set_ylim(len(recording.agents) - 0.4, -0.6)
    axes.set_title("What each agent does", loc="left", pad=24)
    handles = [Patch(facecolor=colour, label=label) for label, colour in KINDS.values()]
    above_the_numbers = axes.transAxes + ScaledTranslation(0.0, 24 / 72, figure.dpi_scale_trans)
    axes.legend(
        handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), bbox_transform=above_the_numbers, ncols=4,
        borderpad=0.0, borderaxespad=0.0, columnspacing=1.2, handlelength=1.0,
    )  # fmt: skip
    time_axis(axes, recording)
    axes.grid(visible=False)
    axes.hlines(np.arange(len(recording.agents)), *axes.get_xlim(), color=GRID, lw=0.6, zorder=0)
    axes.tick_params(axis="y", length=0, labelcolor=INK)
    axes.spines["left"].set_color(MUTED)


def _draw_row(axes: Axes, row: int, found: Sequence[Bar], inches_per_second: float) -> None:
    for bar in found:
        length = bar.end - bar.start
        axes.barh(row, length, left=bar.start, height=0.62, color=KINDS[bar.kind][1], edgecolor="white", lw=0.6)
        room = length * inches_per_second / LETTER_WIDTH
        label = next((text for text in (bar.label, bar.label.split(" ")[-1]) if len(text) < room), "")
        if label:
            axes.text(bar.start + length / 2, row, label, ha="center", va="center", fontsize=7.5, color=INK)
