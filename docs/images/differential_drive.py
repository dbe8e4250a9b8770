"""Makes differential_drive.png from examples/differential_drive.py: python docs/images/differential_drive.py

The ways of three robots on two wheels each, with their poses every few seconds; V and the least clearance over time.
"""

from __future__ import annotations

import runpy
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from drake_ltl.diagrams.drive_diagram import MakeDriveDiagram
from matplotlib.patches import Circle, Polygon

from drake_ltl.execution.drive_run import DriveRun, DriveTrack, RunDrives

HERE = Path(__file__).parent
EXAMPLE = runpy.run_path(str(HERE.parents[1] / "examples" / "differential_drive.py"))
COLOURS = ("#c8502d", "#2f6f9f", "#7a8f2f")
INK, PILLAR = "#20303c", "#b9c3cb"
POSES = (0.0, 5.0, 10.0, 13.0, 16.0, 19.0)
"""When they are drawn [s], besides the end."""


def main() -> None:
    """Writes the picture next to this script."""
    run = RunDrives(MakeDriveDiagram(EXAMPLE["DRIVES"], obstacles=[EXAMPLE["PILLAR"]]))
    assert run.violations() == []
    figure = plt.figure(figsize=(10.4, 5.6), dpi=150, constrained_layout=True)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.35, 1.0))
    draw_floor(figure.add_subplot(grid[:, 0]), run)
    draw_energy(figure.add_subplot(grid[0, 1]), run)
    draw_clearance(figure.add_subplot(grid[1, 1]), run)
    figure.savefig(HERE / "differential_drive.png")


def draw_floor(axes, run: DriveRun) -> None:
    """Ways, poses and the pillar."""
    for x, y, radius in run.obstacles:
        axes.add_patch(Circle((x, y), radius, fc=PILLAR, ec=INK, lw=1.0))
    for (name, track), colour in zip(run.tracks.items(), COLOURS, strict=True):
        axes.plot(*track.p.T, color=colour, lw=2.0, zorder=3)
        for instant in POSES:
            draw_pose(axes, track, int(np.searchsorted(run.time, instant)), colour, alpha=0.35)
        draw_pose(axes, track, -1, colour, alpha=1.0)
        axes.annotate(name, track.p[0], xytext=(-20, 10), textcoords="offset points", color=colour, weight="bold")
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", xlim=(-3.1, 3.1), ylim=(-3.3, 2.9))
    axes.set_title("ways and headings; goal poses filled", fontsize=10)


def draw_pose(axes, track: DriveTrack, sample: int, colour: str, alpha: float) -> None:
    """Its sphere, and an arrow head along its heading."""
    at_end = sample == -1
    p, theta, radius = track.p[sample], track.theta[sample], track.radius
    axes.add_patch(Circle(p, radius, fc="none", ec=colour, lw=1.0, alpha=max(alpha, 0.5), zorder=4))
    turn = theta + np.array([0.0, 2.5, np.pi, -2.5])
    reach = radius * np.array([0.85, 0.75, 0.3, 0.75])
    corners = p + reach[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    axes.add_patch(Polygon(corners, fc=colour if at_end else "white", ec=colour, lw=1.0, alpha=alpha, zorder=5))


def draw_energy(axes, run: DriveRun) -> None:
    """V, which must not rise."""
    axes.semilogy(run.time, run.lyapunov, color=INK, lw=1.6)
    axes.set_title("$V = k\\,\\Phi + \\sum m v^2 / 2$ [J]", fontsize=10)
    axes.grid(alpha=0.3)


def draw_clearance(axes, run: DriveRun) -> None:
    """Least distance of two spheres."""
    axes.plot(run.time, run.clearance, color=INK, lw=1.6)
    axes.axhline(0.0, color=COLOURS[0], lw=1.0)
    axes.set(xlabel="time [s]", ylim=(-0.1, None))
    axes.set_title("least clearance of spheres [m]", fontsize=10)
    axes.grid(alpha=0.3)


if __name__ == "__main__":
    main()
