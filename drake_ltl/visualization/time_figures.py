"""V and the clearances of a run over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drake_ltl.execution.recording import Recording
from drake_ltl.visualization.clearances import clearances
from drake_ltl.visualization.palette import AGENT_HUES, DANGER, GRID, INK, MUTED
from drake_ltl.visualization.style import HALO, write_figure

SIZE = (8.2, 3.4)
MAX_BUCKETS = 2000
"""Drawn points of a curve: each stands for the least value of its bucket, so that no minimum is lost."""
VISIBLE_CLEARANCE = 16.0
"""Clearances beyond this are not of interest [m]."""
JUMP = 0.2
"""Between two samples nothing moves this far [m]: a clearance that does is of another pair."""


def lyapunov_figure(recording: Recording, directory: Path, formats: Sequence[str] = ("png",)) -> list[Path]:
    """Writes lyapunov.png: V [J] over time, a curve for each phase of each step (V is another function in each)."""
    return write_figure(lambda figure: _draw_lyapunov(figure, recording), SIZE, Path(directory) / "lyapunov", formats)


def clearance_figure(recording: Recording, directory: Path, formats: Sequence[str] = ("png",)) -> list[Path]:
    """Writes clearances.png: the smallest clearances [m] over time, their minima marked."""
    return write_figure(
        lambda figure: _draw_clearances(figure, recording), SIZE, Path(directory) / "clearances", formats
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
    axes.set_title("Lyapunov function of each step", loc="left", pad=22)
    _time_axis(axes, recording)


def _draw_clearances(figure: Figure, recording: Recording) -> None:
    axes = figure.add_subplot()
    gaps = clearances(recording)
    curves = (
        ("agent to agent", gaps.agent_agent, AGENT_HUES[0], "-"),
        ("agent to object", gaps.agent_object, AGENT_HUES[2], (0, (5, 1.5))),
        ("team to others", gaps.team_other, AGENT_HUES[1], "-"),
    )
    for label, gap, colour, style in curves:
        _draw_gap(axes, recording.time, gap, label, colour, style)
    least = min((float(gap.min(initial=np.inf)) for _, gap, _, _ in curves), default=np.inf)
    bottom = min(-0.02, 1.2 * least)
    axes.set_yscale("function", functions=(_spread, _gathered))
    axes.set_yticks([tick for tick in (-4, -1, -0.25, 0, 0.1, 0.25, 0.5, 1, 2, 4, 8, 16) if tick >= bottom])
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_ylim(bottom, VISIBLE_CLEARANCE)
    axes.axhspan(bottom, 0.0, color=DANGER, alpha=0.15, lw=0)
    axes.axhline(0.0, color=DANGER, lw=0.9)
    axes.set_ylabel("smallest clearance [m]")
    axes.set_title("Clearances between spheres", loc="left", pad=22)
    if axes.lines[:-1]:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.07), ncols=3, borderpad=0.0, columnspacing=1.4)
    _time_axis(axes, recording)


def _draw_gap(axes: Axes, time: np.ndarray, gap: np.ndarray, label: str, colour, style) -> None:
    if not np.isfinite(gap).any():
        return
    with np.errstate(invalid="ignore"):  # inf - inf
        breaks = np.flatnonzero(~(np.abs(np.diff(gap)) <= JUMP)) + 1
    stretches = [rows for rows in np.split(np.arange(len(gap)), breaks) if np.isfinite(gap[rows[0]])]
    for number, rows in enumerate(stretches):
        t, least = _least_in_buckets(time[rows], gap[rows])
        axes.plot(t, least, color=colour, ls=style, label=None if number else label)
    row = int(np.argmin(gap))
    if gap[row] < VISIBLE_CLEARANCE:
        axes.plot(time[row], gap[row], "o", color=colour, ms=4)
        axes.annotate(
            f"{gap[row]:.2f}", (time[row], gap[row]), (5, 4), textcoords="offset points", color=colour,
            fontsize=8, weight="bold", path_effects=HALO, zorder=5,
        )  # fmt: skip


def _spread(clearance: np.ndarray) -> np.ndarray:
    """The scale of clearances: roots, because those near zero are of interest."""
    return np.sign(clearance) * np.sqrt(np.abs(clearance))


def _gathered(root: np.ndarray) -> np.ndarray:
    return np.sign(root) * root**2


def _time_axis(axes: Axes, recording: Recording) -> None:
    """Time, the grid, and where steps begin: their numbers, in two rows where they would touch."""
    axes.set_xlabel("time [s]")
    axes.grid(axis="y", color=GRID, lw=0.6)
    axes.set_axisbelow(True)
    end = recording.time[-1] if len(recording.time) else 1.0
    axes.set_xlim(0.0, max(end, 1e-9))
    row, last = 0, -np.inf
    for step in recording.steps:
        axes.axvline(step.start, color=MUTED, lw=0.6, ls=(0, (2, 2)), zorder=0.5)
        row = 1 - row if step.start - last < 0.022 * end else 0
        last = step.start
        axes.annotate(
            str(step.number + 1), (step.start, 1.0), (1, 2 + 8 * row), xycoords=("data", "axes fraction"),
            textcoords="offset points", ha="left", va="bottom", fontsize=7.5, color=INK if step.finished else DANGER,
        )  # fmt: skip


def _segments(recording: Recording) -> list[np.ndarray]:
    """Sample indices of each stretch in which V is one function."""
    key = recording.step * 4 + recording.phase
    return np.split(np.arange(len(key)), np.flatnonzero(np.diff(key)) + 1)


def _strided(count: int) -> np.ndarray:
    """Indices of at most MAX_BUCKETS + 1 of `count` samples, first and last among them."""
    return np.unique(np.append(np.arange(0, count, max(1, count // MAX_BUCKETS)), count - 1))


def _least_in_buckets(time: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    size = max(1, len(time) // MAX_BUCKETS)
    starts = np.arange(0, len(time), size)
    return time[starts], np.minimum.reduceat(value, starts)
