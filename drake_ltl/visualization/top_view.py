"""What top views consist of: workspace, regions, bodies as circles and squares, and their ways."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon

from drake_ltl.execution.recording import Recording, StepRecord
from drake_ltl.scenario.model import Scenario
from drake_ltl.visualization.palette import FLOOR, GRID, INK, MUTED, REGION, Colour, member_colours
from drake_ltl.visualization.spheres import CARRIES
from drake_ltl.visualization.style import HALO

SIDES = np.array([(0.0, -1.0), (0.0, 1.0), (1.0, 0.0), (-1.0, 0.0)])
"""Where a region's name may stand: below, above, right, left."""
_ALIGN = {0.0: "center", 1.0: "left", -1.0: "right"}
MAX_POINTS = 1000
"""Of a drawn way: more cannot be seen."""
STILL = 0.02
"""A way shorter than this is not drawn [m]."""


@dataclass(frozen=True)
class View:
    """What a top view is drawn from."""

    recording: Recording
    scenario: Scenario
    colours: Mapping[str, Colour]

    @staticmethod
    def of(recording: Recording, scenario: Scenario) -> View:
        return View(recording, scenario, member_colours(recording.agents, recording.objects))


def samples_of(recording: Recording, step: StepRecord) -> np.ndarray:
    """Indices of the step's samples and of the first one after it, where it is seen to be done."""
    inside = np.flatnonzero(recording.step == step.number)
    return np.append(inside, inside[-1] + 1) if inside[-1] + 1 < len(recording.time) else inside


def draw_workspace(axes: Axes, scenario: Scenario) -> None:
    """Workspace and regions; equal scales, no frame."""
    radius = scenario.workspace_radius
    axes.add_patch(Circle((0, 0), radius, facecolor=FLOOR, edgecolor=MUTED, linewidth=1.0, zorder=0))
    for region in scenario.regions:
        axes.add_patch(
            Circle(region.centre[:2], region.radius, facecolor=(*REGION, 0.22), edgecolor=REGION, lw=0.8, zorder=1)
        )
    _plain(axes)
    axes.set_xlim(-1.02 * radius, 1.02 * radius)
    axes.set_ylim(-1.02 * radius, 1.02 * radius)


def draw_step(axes: Axes, view: View, step: StepRecord, *, font_size: float = 9.0) -> None:
    """Spheres at the step's begin (dashed) and end (solid), names, and the ways of all centres in between."""
    rows = samples_of(view.recording, step)
    for name, centre in _moving(view.recording):
        _draw_way(axes, centre[rows], view.colours[name])
    _draw_bodies(axes, view, rows[0], begin=True)
    _draw_bodies(axes, view, rows[-1], begin=False)
    _draw_teams(axes, view, rows)
    _draw_names(axes, view, rows[-1], font_size)


def draw_region_names(axes: Axes, view: View, step: StepRecord, *, font_size: float = 9.0) -> None:
    """Names of the regions just outside them, on the side where there is most room in this step."""
    rows = samples_of(view.recording, step)
    rows = rows[_strided(len(rows), 50)]
    names = [
        edge + 0.06 * view.scenario.workspace_radius * away for edge, away in _name_places(view, rows[-1]).values()
    ]
    busy = np.concatenate([names, *(points[rows, :2] for _, points in _moving(view.recording))])
    for region in view.scenario.regions:
        centre = np.array(region.centre[:2])
        room = [np.linalg.norm(busy - (centre + 1.25 * region.radius * side), axis=1).min() for side in SIDES]
        side = SIDES[int(np.argmax(np.minimum(room, region.radius)))]  # with room enough the first side, below
        axes.annotate(
            region.name, centre + region.radius * side, 8 * side, textcoords="offset points", ha=_ALIGN[side[0]],
            va="center", color=MUTED, fontsize=font_size, style="italic", zorder=6, path_effects=HALO,
        )  # fmt: skip


def show_region(axes: Axes, view: View, name: str) -> None:
    """Turns the axes into a close-up of a region, with a frame and its name."""
    region = view.scenario.region(name)
    half = 1.25 * region.radius
    x, y = region.centre[:2]
    axes.set_xlim(x - half, x + half)
    axes.set_ylim(y - half, y + half)
    axes.set_title(name, style="italic", color=MUTED, fontsize=9.0, pad=3)
    axes.set_axis_on()
    axes.set(xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set(visible=True, color=GRID)


def draw_scale(axes: Axes, scenario: Scenario) -> None:
    """A bar of a round length in the lower left corner."""
    radius = scenario.workspace_radius
    length = _round_length(radius / 3)
    x, y = -0.98 * radius, -0.95 * radius
    axes.plot([x, x + length], [y, y], color=INK, lw=1.5, solid_capstyle="butt")
    axes.annotate(f"{length:g} m", (x + length / 2, y), (0, 3), textcoords="offset points", ha="center", fontsize=8)


def _moving(recording: Recording) -> Iterator[tuple[str, np.ndarray]]:
    yield from recording.object_origin.items()
    yield from recording.centre.items()


def _draw_way(axes: Axes, points: np.ndarray, colour: Colour) -> None:
    if np.ptp(points[:, :2], axis=0).max() < STILL:
        return
    drawn = points[_strided(len(points), MAX_POINTS)]
    axes.plot(drawn[:, 0], drawn[:, 1], color=colour, lw=1.4, alpha=0.9, zorder=3)


def _draw_bodies(axes: Axes, view: View, row: int, *, begin: bool) -> None:
    recording = view.recording
    line = {"linestyle": (0, (3, 2)), "linewidth": 0.9} if begin else {"linewidth": 1.3}
    for name in recording.agents:
        colour = view.colours[name]
        face = "none" if begin else (*colour, 0.16)
        centre = recording.centre[name][row, :2]
        axes.add_patch(Circle(centre, recording.agent_radius[name], facecolor=face, edgecolor=colour, zorder=4, **line))
    for name in recording.objects:
        colour = view.colours[name]
        square = _square(recording.pose[name][row], recording.object_radius[name])
        face = "none" if begin else (*colour, 0.9)
        axes.add_patch(Polygon(square, closed=True, facecolor=face, edgecolor=colour, zorder=4.5, **line))


def _draw_teams(axes: Axes, view: View, rows: np.ndarray) -> None:
    """The sphere of every team that carries within `rows`, where it sets out and where it sets down."""
    recording = view.recording
    rows = rows[recording.step[rows] == recording.step[rows[0]]]  # the last one may see the next step begin
    for index, name in enumerate(recording.objects):
        carrying = rows[(recording.mode[rows] == CARRIES + index).any(axis=1)]
        for row, style in zip(carrying[[0, -1]] if len(carrying) else (), ((0, (3, 2)), "-"), strict=False):
            origin = recording.object_origin[name][row, :2]
            axes.add_patch(
                Circle(
                    origin, recording.team_radius[name],
                    facecolor="none", edgecolor=view.colours[name], linestyle=style, linewidth=1.1, zorder=4,
                )
            )  # fmt: skip


def _draw_names(axes: Axes, view: View, row: int, font_size: float) -> None:
    draw_names(axes, _name_places(view, row), view.colours, font_size)


def draw_names(
    axes: Axes, places: Mapping[str, tuple[np.ndarray, np.ndarray]], colours: Mapping[str, Colour], font_size: float
) -> None:
    """Names of members at places found by `name_places`; long ones do not reach back over their bodies."""
    for name, (edge, away) in places.items():
        side = float(np.sign(away[0])) if abs(away[0]) > 0.5 else 0.0
        axes.annotate(
            name, edge, (4.0 if side else 7.5) * away, textcoords="offset points", ha=_ALIGN[side], va="center",
            color=colours[name], fontsize=font_size, weight="bold", zorder=7, path_effects=HALO,
            annotation_clip=True, clip_on=True,
        )  # fmt: skip


def _name_places(view: View, row: int) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    recording = view.recording
    centres = {name: points[row, :2] for name, points in _moving(recording)}
    return name_places(centres, recording.agent_radius, recording.object_radius)


def name_places(
    centres: Mapping[str, np.ndarray], agent_radius: Mapping[str, float], object_radius: Mapping[str, float]
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """For each member the point beside which its name stands, and the direction: away from the bodies around it.

    Args:
        centres: (2,) of each member, in W [m].
        agent_radius: [m]; of circles.
        object_radius: [m]; of squares around which a circle of that radius passes.
    """
    radii = {**object_radius, **agent_radius}
    beside = {}
    for name, place in centres.items():
        near = [p for other, p in centres.items() if other != name and np.linalg.norm(p - place) < 4 * radii[name]]
        away = place - np.mean(near, axis=0) if near else np.array([0.0, 1.0])
        length = np.linalg.norm(away)
        away = away / length if length > 1e-6 else np.array([0.0, 1.0])
        reach = radii[name] if name in agent_radius else 0.71 * radii[name]
        beside[name] = place + reach * away, away
    return beside


def _square(pose: np.ndarray, radius: float) -> np.ndarray:
    """(4, 2) corners of a square inscribed in the object's circle, turned by its yaw."""
    w, x, y, z = pose[:4]
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    angles = yaw + np.pi / 4 + np.pi / 2 * np.arange(4)
    return pose[4:6] + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _strided(count: int, most: int) -> np.ndarray:
    """Indices of about `most` of `count` points, the last among them."""
    return np.append(np.arange(0, count - 1, max(1, count // most)), count - 1)


def _round_length(length: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that does not exceed `length`."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(power * max(factor for factor in (1, 2, 5) if factor * power <= length * (1 + 1e-9)))


def _plain(axes: Axes) -> None:
    axes.set_aspect("equal")
    axes.set_axis_off()
