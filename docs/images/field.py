"""Makes field.png, a picture of a navigation function: python docs/images/field.py

One mover among four obstacles in a round workspace. Level lines of phi, a descent from the left to the goal on the
right, and the critical points: behind each obstacle, as seen from the goal, lies one saddle.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.colors
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Circle

from drake_ltl.navigation import RegionBall, StaticBody, StepRelations, Traveller, step_relations
from drake_ltl.navigation.planar import PlanarField, sampled_starts
from drake_ltl.navigation.tuning import descend

HERE = Path(__file__).parent
WORKSPACE, RADIUS, KAPPA = 12.0, 1.0, 8.0
OBSTACLES = [(0.0, 0.3, 2.0), (3.0, 6.0, 1.5), (-3.5, -5.5, 1.6), (5.0, -4.0, 1.1)]
START, GOAL = (-9.0, 0.2), (8.0, 1.5)
INK, WAY, SADDLE, OBSTACLE = "#20303c", "#c8502d", "#7a2f8f", "#b9c3cb"


def main() -> None:
    """Writes the picture next to this script."""
    field = PlanarField.of(scene(), kappa=KAPPA)
    figure, axes = plt.subplots(figsize=(8.4, 7.0), dpi=150, constrained_layout=True)
    draw_levels(figure, axes, field)
    draw_bodies(axes)
    draw_critical_points(axes, field)
    path = descend(field, field.start).path
    axes.plot(*path.T, color=WAY, lw=2.2, label="descent from the start", zorder=5)
    axes.plot(*START, "o", color=WAY, ms=8, zorder=6)
    axes.plot(*GOAL, "*", color=WAY, ms=17, mec="white", mew=0.8, label="goal, the only minimum", zorder=6)
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
    axes.set(xlim=(-12.3, 12.3), ylim=(-12.3, 14.6))
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.legend(loc="upper left", frameon=False, fontsize=9, bbox_to_anchor=(-0.02, 1.0))
    figure.savefig(HERE / "field.png")


def scene() -> StepRelations:
    """One traveller, four static bodies, all of them in one region as large as the workspace."""
    home = RegionBall("home", (0.0, 0.0, 0.0), WORKSPACE)
    traveller = Traveller("a1", RADIUS, "home", "home", (*START, 0.0), (*GOAL, 0.0))
    static = [StaticBody(f"o{k}", r, (x, y, 0.0)) for k, (x, y, r) in enumerate(OBSTACLES)]
    return step_relations(travellers=[traveller], static_objects=static, regions=[home], workspace_radius=WORKSPACE)


def draw_levels(figure, axes, field: PlanarField) -> None:
    """Level lines where the mover's centre may be.

    phi itself is 1 to many digits nearly everywhere, so its lines are named by s = sqrt(w), of which phi is a strictly
    increasing function: near the goal s is the distance to it. Lines enclose equal shares of the free area.
    """
    ticks = np.linspace(-WORKSPACE, WORKSPACE, 800)
    x = np.stack(np.meshgrid(ticks, ticks), axis=-1)
    log_w = field.value(x)
    s = np.exp(0.5 * np.where(np.isfinite(log_w), log_w, np.nan))
    levels = np.nanquantile(s, np.linspace(0.0, 1.0, 26))
    levels[-1] = np.nanmax(s)
    columns = x.transpose(2, 0, 1)
    norm = matplotlib.colors.BoundaryNorm(levels, 256)
    shade = axes.contourf(*columns, s, levels=levels, norm=norm, cmap="YlGnBu", alpha=0.75, zorder=1)
    axes.contour(*columns, s, levels=levels[1:-1], colors=INK, linewidths=0.5, alpha=0.8, zorder=2)
    bar = figure.colorbar(shade, ax=axes, shrink=0.8, spacing="uniform", pad=0.01)
    marks = levels[1:-1:3]
    bar.set_ticks(marks, labels=[f"{mark:.1f}" for mark in marks])
    bar.set_label("level lines of $\\varphi$, named by $\\sqrt{w}$ [m];  $\\varphi = (1 + w^{-\\kappa})^{-1/\\kappa}$")


def draw_bodies(axes) -> None:
    """Obstacles, what the mover's centre must keep off around them, and the workspace."""
    for x, y, r in OBSTACLES:
        axes.add_patch(Circle((x, y), r + RADIUS, fc="white", ec=INK, lw=1.0, ls=(0, (4, 2)), zorder=3))
        axes.add_patch(Circle((x, y), r, fc=OBSTACLE, ec=INK, lw=1.0, zorder=3))
    axes.add_patch(Circle((0.0, 0.0), WORKSPACE - RADIUS, fc="none", ec=INK, lw=1.0, ls=(0, (4, 2)), zorder=3))
    axes.add_patch(Circle((0.0, 0.0), WORKSPACE, fc="none", ec=INK, lw=1.6, zorder=3))
    axes.add_patch(Circle(START, RADIUS, fc="none", ec=WAY, lw=1.4, zorder=5))
    axes.text(START[0], START[1] + 1.25, "mover", color="white", weight="bold", ha="center", fontsize=9, zorder=5)


def draw_critical_points(axes, field: PlanarField) -> None:
    """Every critical point but the goal, with the two ways down from each saddle."""
    starts = [np.array([x, y]) for x in np.linspace(-11, 11, 45) for y in np.linspace(-11, 11, 45)]
    found = field.critical_points([*starts, *sampled_starts(field.step, 50, 0)])
    assert [point.kind for point in found] == ["saddle"] * len(OBSTACLES), [(p.kind, p.x) for p in found]
    for point in found:
        for side in (0.02, -0.02):
            way = descend(field, point.x + side * point.directions[:, 0]).path
            axes.plot(*way.T, color=SADDLE, lw=1.3, ls=":", zorder=4)
    x, y = np.array([point.x for point in found]).T
    axes.plot(x, y, "X", color=SADDLE, mec="white", ms=11, ls="none", label="saddles, and the ways down", zorder=6)


if __name__ == "__main__":
    main()
