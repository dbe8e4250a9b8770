"""A sweep in one picture: where runs began and what they came to, their clearances, how long they took."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drake_ltl.scenario.model import Scenario
from drake_ltl.sweep.outcome import SATISFIED, Outcome
from drake_ltl.sweep.statistics import CONFIDENCE, Summary
from drake_ltl.verification.clearances import KINDS
from drake_ltl.verification.table import CLEARANCE_NAMES
from drake_ltl.visualization.palette import AGENT_HUES, DANGER, GRID, INK, MUTED, member_colours
from drake_ltl.visualization.style import HALO, write_figure
from drake_ltl.visualization.top_view import draw_workspace

SIZE = (10.4, 5.0)


def write_summary_figure(summary: Summary, scenario: Scenario, path: Path) -> None:
    """Writes a picture that ends in .png, .svg or .pdf (OSError if it cannot)."""
    write_figure(
        lambda figure: _draw(figure, summary, scenario), SIZE, path.with_suffix(""), [path.suffix.removeprefix(".")]
    )


def _draw(figure: Figure, summary: Summary, scenario: Scenario) -> None:
    grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.15))
    _draw_starts(figure.add_subplot(grid[:, 0]), summary, scenario)
    _draw_clearances(figure.add_subplot(grid[0, 1]), summary)
    _draw_durations(figure.add_subplot(grid[1, 1]), summary)
    good = summary.satisfied
    text = f"{scenario.name}: {good.count} of {good.of} runs satisfied"
    if good.of:
        text += f" ({CONFIDENCE:.0%} interval {good.low:.1%} to {good.high:.1%})"
    figure.suptitle(text, x=0.01, ha="left", fontsize=10.5, color=INK)


def _draw_starts(axes: Axes, summary: Summary, scenario: Scenario) -> None:
    """A dot for each member at each start, a cross where the run was not satisfied."""
    draw_workspace(axes, scenario)
    colours = member_colours(scenario.agent_names, scenario.object_names)
    for good, marker, size in ((True, "o", 3.0), (False, "X", 6.5)):
        drawn = [o.drawn for o in summary.outcomes if o.drawn is not None and (o.status == SATISFIED) is good]
        for name, colour in colours.items() if drawn else ():
            points = np.array([one.positions[name] for one in drawn])
            edge = {"mec": "none", "alpha": 0.7} if good else {"mec": DANGER, "mew": 0.9}
            axes.plot(*points.T, marker, color=colour, ms=size, zorder=5 if good else 6, **edge)
    for region in scenario.regions:
        x, y = region.centre[:2]
        axes.annotate(
            region.name, (x, y - region.radius), (0, -8), textcoords="offset points", ha="center", va="center",
            color=MUTED, style="italic", zorder=7, path_effects=HALO,
        )  # fmt: skip
    crosses = "; crosses: not satisfied" if summary.unsatisfied else ""
    axes.set_title(f"Starts (bases and objects){crosses}", loc="left")


def _draw_clearances(axes: Axes, summary: Summary) -> None:
    """A row for each kind of clearance with a dot for the least of each run."""
    kinds = [kind for kind in KINDS if any(_values(summary.outcomes, kind))]
    for row, kind in enumerate(kinds):
        values = np.array(_values(summary.outcomes, kind))
        jitter = np.random.default_rng(row).uniform(-0.28, 0.28, len(values))  # so that equal ones are seen
        axes.plot(values, row + jitter, "o", ms=3.0, mec="none", color=AGENT_HUES[0], alpha=0.6)
        axes.plot([np.median(values)] * 2, [row - 0.38, row + 0.38], color=INK, lw=1.2)
    axes.set_yticks(range(len(kinds)), [CLEARANCE_NAMES[kind] for kind in kinds])
    axes.set_ylim(len(kinds) - 0.4, -0.6)
    least = min((value for kind in kinds for value in _values(summary.outcomes, kind)), default=0.0)
    axes.set_xscale("symlog", linthresh=0.1, linscale=1.0)
    axes.set_xlim(min(-0.02, 1.2 * least), None)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.axvspan(min(-0.02, 1.2 * least), 0.0, color=DANGER, alpha=0.15, lw=0)
    axes.axvline(0.0, color=DANGER, lw=0.9)
    axes.grid(axis="x", color=GRID, lw=0.6)
    axes.set_axisbelow(True)
    axes.set_title("Least clearance of each run [m], and the median", loc="left")


def _values(outcomes: Sequence[Outcome], kind: str) -> list[float]:
    values = (outcome.min_clearance.get(kind) for outcome in outcomes)
    return [value for value in values if value is not None]


def _draw_durations(axes: Axes, summary: Summary) -> None:
    seconds = [outcome.simulated_seconds for outcome in summary.outcomes if outcome.status == SATISFIED]
    if seconds:
        axes.hist(seconds, bins=min(30, max(5, len(seconds) // 3)), color=AGENT_HUES[0], alpha=0.75)
        axes.axvline(float(np.median(seconds)), color=INK, lw=1.2)
    axes.yaxis.get_major_locator().set_params(integer=True)
    axes.grid(axis="y", color=GRID, lw=0.6)
    axes.set_axisbelow(True)
    axes.set_xlabel("simulated time of satisfied runs [s]")
    axes.set_title("Durations, and the median", loc="left")
