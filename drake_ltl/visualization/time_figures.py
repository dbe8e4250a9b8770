"""V and the clearances of a run over time."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drake_ltl.execution.recording import Recording
from drake_ltl.scenario.model import Scenario
from drake_ltl.visualization.clearances import Curve, clearance_curves
from drake_ltl.visualization.palette import AGENT_HUES, DANGER, GRID, INK, MUTED, Colour
from drake_ltl.visualization.style import HALO, Drawing

SIZE = (8.2, 3.4)
MAX_BUCKETS = 2000
"""Drawn points of a curve: each stands for the least value of its bucket, so that no minimum is lost."""
VISIBLE_CLEARANCE = 16.0
"""Clearances beyond this are not of interest [m]."""
TICKS = (-4, -1, -0.25, 0, 0.1, 0.25, 0.5, 1, 2, 4, 8, 16)
KINDS = {
    "agent_agent": ("agent to agent", AGENT_HUES[0], "-"),
    "agent_object": ("agent to object", AGENT_HUES[2], (0, (5, 1.5))),
    "team_other": ("team to others", AGENT_HUES[1], "-"),
    "forbidden_region": ("to other regions", MUTED, (0, (1.5, 1.5))),
}
"""Kinds of clearances that are drawn: label, colour and line. Border and resting objects are left out."""


def lyapunov_drawing(recording: Recording) -> Drawing:
    """V [J] over time, a curve for each phase of each step (V is another function in each)."""
    return Drawing("lyapunov", "Lyapunov function V over time", SIZE, lambda figure: _draw_lyapunov(figure, recording))


def clearance_drawing(recording: Recording, scenario: Scenario) -> Drawing:
    """The smallest clearances [m] over time, the least of each kind marked."""
    return Drawing(
        "clearances",
        "smallest clearances between spheres over time",
        SIZE,
        lambda figure: _draw_clearances(figure, recording, scenario),
    )


def _draw_lyapunov(figure: Figure, recording: Recording) -> None:
    axes = figure.add_subplot()
    V, colour = recording.lyapunov, AGENT_HUES[0]
    for rows in _segments(recording):
        rows = rows[V[rows] > 0.0]
        if len(rows):
            shown = rows[_strided(len(rows))]
            axes.plot(recording.time[shown], V[shown], color=colour)
            axes.plot(recording.time[rows[0]], V[rows[0]], "o", color=colour, ms=3.5)
    if (V > 0.0).any():
        axes.set_yscale("log")
    axes.set_ylabel("V [J]")
    axes.set_title("Lyapunov function of each step", loc="left", pad=24)
    time_axis(axes, recording)


def _draw_clearances(figure: Figure, recording: Recording, scenario: Scenario) -> None:
    axes = figure.add_subplot()
    curves = [curve for curve in clearance_curves(recording, scenario) if curve.kind in KINDS]
    for kind, (label, colour, style) in KINDS.items():
        _draw_kind(axes, [curve for curve in curves if curve.kind == kind], label, colour, style)
    least = min((float(curve.value.min()) for curve in curves), default=0.0)
    bottom = min(-0.02, 1.2 * least)
    axes.set_yscale("function", functions=(_spread, _gathered))
    axes.set_yticks([tick for tick in TICKS if tick >= bottom])
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_ylim(bottom, VISIBLE_CLEARANCE)
    axes.axhspan(bottom, 0.0, color=DANGER, alpha=0.15, lw=0)
    axes.axhline(0.0, color=DANGER, lw=0.9)
    axes.set_ylabel("smallest clearance [m]")
    axes.set_title("Clearances between spheres", loc="left", pad=24)
    if curves:
        axes.legend(
            loc="lower right", bbox_to_anchor=(1.0, 1.11), ncols=4, borderpad=0.0, columnspacing=1.2, handlelength=1.6
        )
    time_axis(axes, recording)


def _draw_kind(axes: Axes, curves: list[Curve], label: str, colour: Colour, style) -> None:
    for number, curve in enumerate(curves):
        t, value = least_in_buckets(curve.time, curve.value)
        axes.plot(t, value, color=colour, ls=style, label=None if number else label)
    if not curves:
        return
    lowest = min(curves, key=lambda curve: curve.value.min())
    row = int(np.argmin(lowest.value))
    place = lowest.time[row], lowest.value[row]
    if place[1] < VISIBLE_CLEARANCE:
        axes.plot(*place, "o", color=colour, ms=4)
        axes.annotate(
            f"{place[1]:.2f}", place, (5, 4), textcoords="offset points", color=colour,
            fontsize=8, weight="bold", path_effects=HALO, zorder=5,
        )  # fmt: skip


def _spread(clearance: np.ndarray) -> np.ndarray:
    """The scale of clearances: roots, because those near zero are of interest."""
    return np.sign(clearance) * np.sqrt(np.abs(clearance))


def _gathered(root: np.ndarray) -> np.ndarray:
    return np.sign(root) * root**2


def time_axis(axes: Axes, recording: Recording, *, numbers: bool = True) -> None:
    """Time, the grid, and where steps begin: their numbers, in two rows where they would touch."""
    axes.set_xlabel("time [s]")
    axes.grid(axis="y", color=GRID, lw=0.6)
    axes.set_axisbelow(True)
    end = recording.time[-1] if len(recording.time) else 1.0
    axes.set_xlim(0.0, max(end, 1e-9))
    row, last = 0, -np.inf
    for step in recording.steps:
        axes.axvline(step.start, color=MUTED, lw=0.6, ls=(0, (2, 2)), zorder=0.5)
        if not numbers:
            continue
        row = 1 - row if step.start - last < 0.022 * end else 0
        last = step.start
        axes.annotate(
            str(step.number + 1), (step.start, 1.0), (1, 2 + 8 * row), xycoords=("data", "axes fraction"),
            textcoords="offset points", ha="left", va="bottom", fontsize=7.5, color=INK if step.finished else DANGER,
        )  # fmt: skip


def _segments(recording: Recording) -> list[np.ndarray]:
    """Sample indices of each stretch in which V is one function."""
    changes = (np.diff(recording.step) != 0) | (np.diff(recording.phase) != 0)
    return np.split(np.arange(len(recording.time)), np.flatnonzero(changes) + 1)


def _strided(count: int) -> np.ndarray:
    """Indices of at most MAX_BUCKETS + 1 of `count` samples, first and last among them."""
    return np.unique(np.append(np.arange(0, count, max(1, count // MAX_BUCKETS)), count - 1))


def least_in_buckets(time: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fewer samples of a curve; each stands for the least value of its bucket."""
    size = max(1, len(time) // MAX_BUCKETS)
    starts = np.arange(0, len(time), size)
    return time[starts], np.minimum.reduceat(value, starts)
