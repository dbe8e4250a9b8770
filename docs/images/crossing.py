"""Makes crossing.png from examples/crossing.yaml: python docs/images/crossing.py

The ways of three robots on two wheels each, with their poses every few seconds; V and the least clearance over time.
"""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Circle, Polygon

import drake_ltl
from drake_ltl.execution.recording import Recording
from drake_ltl.multibody.drive_agent import YAW
from drake_ltl.scenario import Scenario

HERE = Path(__file__).parent
COLOURS = ("#c8502d", "#2f6f9f", "#7a8f2f")
INK, PILLAR, FLOOR = "#20303c", "#b9c3cb", "#eef1f3"
POSES = (0.0, 4.0, 8.0, 11.0, 14.0, 17.0)
"""When they are drawn [s], besides the end."""


def main() -> None:
    """Writes the picture next to this script."""
    scenario = drake_ltl.load("crossing")
    recording = drake_ltl.simulate(scenario).recording
    assert drake_ltl.verify(recording, scenario).satisfied
    figure = plt.figure(figsize=(10.4, 5.6), dpi=150, constrained_layout=True)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.35, 1.0))
    draw_floor(figure.add_subplot(grid[:, 0]), recording, scenario)
    draw_energy(figure.add_subplot(grid[0, 1]), recording)
    draw_clearance(figure.add_subplot(grid[1, 1]), recording, scenario)
    figure.savefig(HERE / "crossing.png")


def draw_floor(axes, recording: Recording, scenario: Scenario) -> None:
    """Regions, ways and poses."""
    for region in scenario.regions:
        colour = PILLAR if region.name == "pillar" else FLOOR
        axes.add_patch(Circle(region.centre[:2], region.radius, fc=colour, ec=INK, lw=0.6))
        outside = np.multiply(1.25, region.centre[:2])
        axes.annotate(region.name, outside, ha="center", va="center", fontsize=8, color=INK)
    for name, colour in zip(recording.agents, COLOURS, strict=True):
        axes.plot(*recording.q[name][:, :2].T, color=colour, lw=2.0, zorder=3)
        for instant in POSES:
            draw_pose(axes, recording, name, int(np.searchsorted(recording.time, instant)), colour, alpha=0.35)
        draw_pose(axes, recording, name, -1, colour, alpha=1.0)
        beside = recording.q[name][0, :2] * 1.08 + [0.0, 0.33]
        axes.annotate(name, beside, ha="center", color=colour, weight="bold")
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", xlim=(-3.7, 3.7), ylim=(-3.7, 3.7))
    axes.set_title("ways and headings; filled at the end", fontsize=10)


def draw_pose(axes, recording: Recording, name: str, sample: int, colour: str, alpha: float) -> None:
    """Its sphere, and an arrow head along its heading."""
    p, theta, radius = recording.q[name][sample, :2], recording.q[name][sample, YAW], recording.agent_radius[name]
    axes.add_patch(Circle(p, radius, fc="none", ec=colour, lw=1.0, alpha=max(alpha, 0.5), zorder=4))
    turn = theta + np.array([0.0, 2.5, np.pi, -2.5])
    reach = radius * np.array([0.85, 0.75, 0.3, 0.75])
    corners = p + reach[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    axes.add_patch(Polygon(corners, fc=colour if sample == -1 else "white", ec=colour, lw=1.0, alpha=alpha, zorder=5))


def draw_energy(axes, recording: Recording) -> None:
    """V, which must not rise, until the step is done."""
    first = recording.step == 0
    axes.semilogy(recording.time[first], recording.lyapunov[first], color=INK, lw=1.6)
    axes.set_title("$V = k\\,\\Phi + \\sum c\\,m v^2 / 2$ [J]", fontsize=10)
    axes.grid(alpha=0.3)


def draw_clearance(axes, recording: Recording, scenario: Scenario) -> None:
    """Least distance of two spheres, or of one and the pillar."""
    centre, radius, pillar = recording.centre, recording.agent_radius, scenario.region("pillar")
    gaps = [np.linalg.norm(centre[a] - centre[b], axis=1) - radius[a] - radius[b] for a, b in combinations(centre, 2)]
    gaps += [np.linalg.norm(centre[a] - pillar.centre, axis=1) - radius[a] - pillar.radius for a in centre]
    axes.plot(recording.time, np.min(gaps, axis=0), color=INK, lw=1.6)
    axes.axhline(0.0, color=COLOURS[0], lw=1.0)
    axes.set(xlabel="time [s]", ylim=(-0.1, None))
    axes.set_title("least clearance, of each other and of the pillar [m]", fontsize=10)
    axes.grid(alpha=0.3)


if __name__ == "__main__":
    main()
