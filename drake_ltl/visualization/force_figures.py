"""Torques that were asked for, forces that teams put on what they carry, and how the members share them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from drake_ltl.execution.recording import Recording, StepRecord
from drake_ltl.scenario.model import Scenario
from drake_ltl.visualization.palette import DANGER, GRID, INK, agent_colours, object_colours
from drake_ltl.visualization.spheres import CARRIES
from drake_ltl.visualization.style import Drawing
from drake_ltl.visualization.time_figures import SIZE, least_in_buckets, time_axis

if TYPE_CHECKING:
    from drake_ltl.multibody.agent_model import AgentModel

MOST_SAMPLES = 400
"""Of a transport, at which forces are worked out."""
CLOSE = 0.1
"""Transports are neighbours if there is less than this share of the run between them."""
LEAST_FORCE = 0.01
"""Where the axis of forces begins [N]."""
SPACING = 0.02
"""Accelerations are differences of velocities so far apart [s]."""


@dataclass(frozen=True)
class TeamForce:
    """The horizontal forces of one transport, in W; n samples."""

    object: str
    step: int
    time: np.ndarray
    """(n,) [s]"""
    total: np.ndarray
    """(n, 2) [N]: what moves the object and all who carry it, by Newton's law."""
    share: dict[str, float]
    """agent -> c_tau of (10b), by the powers; of sum 1."""
    on_object: dict[str, np.ndarray]
    """agent -> (n, 2) [N] what is left of its share for the object when the agent's own mass has been moved."""


def effort_drawings(recording: Recording) -> list[Drawing]:
    """effort: the largest torque asked of a joint of each agent, relative to its effort limit, over time.

    Nothing of a recording without torques (`lacks`).
    """
    if "effort" in recording.lacks or not recording.effort.any():
        return []
    title = "torques asked for, relative to their limits"
    return [Drawing("effort", title, SIZE, lambda figure: _draw_effort(figure, recording))]


def force_drawings(recording: Recording, forces: Sequence[TeamForce]) -> list[Drawing]:
    """forces: those of all transports over time; nothing if nobody carried anything."""
    if not forces:
        return []
    title = "horizontal forces of carrying teams, and how their members share them"
    return [Drawing("forces", title, (SIZE[0], 4.6), lambda figure: _draw_forces(figure, recording, forces))]


def team_forces(recording: Recording, scenario: Scenario) -> list[TeamForce]:
    """Of each transport, from the recorded motion: total = sum of (1a) over the team + m_O a_O, horizontally.

    What keeps the bodies apart is no contact, so nothing else pushes horizontally. It loads the scenario's models.
    """
    from drake_ltl.multibody.drive_agent import make_agent_model
    from drake_ltl.multibody.object_model import ObjectModel

    agents = {agent.name: make_agent_model(agent, scenario) for agent in scenario.agents}
    mass = {obj.name: ObjectModel(obj).mass for obj in scenario.objects}
    found = []
    for step in recording.steps:
        for action in step.actions:
            if action["kind"] == "transport":
                rows = _carrying(recording, step, action["object"])
                if len(rows):
                    found.append(_team_force(recording, scenario, agents, mass, step, action, rows))
    return found


def _carrying(recording: Recording, step: StepRecord, obj: str) -> np.ndarray:
    """Some of the samples in which the object is carried in a step, all with neighbours a gap away."""
    carries = CARRIES + recording.objects.index(obj)
    rows = np.flatnonzero((recording.step == step.number) & (recording.mode == carries).any(axis=1))
    gap = _gap(recording)
    rows = rows[gap : len(rows) - gap]
    return rows[:: max(1, len(rows) // MOST_SAMPLES)]


def _gap(recording: Recording) -> int:
    return max(1, round(SPACING / np.median(np.diff(recording.time)))) if len(recording.time) > 1 else 1


def _rate(recording: Recording, values: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Central differences of values (T, ..) at rows (n,)."""
    gap = _gap(recording)
    span = recording.time[rows + gap] - recording.time[rows - gap]
    return (values[rows + gap] - values[rows - gap]) / span[:, None]


def _team_force(
    recording: Recording,
    scenario: Scenario,
    agents: Mapping[str, AgentModel],
    mass: Mapping[str, float],
    step: StepRecord,
    action: Mapping[str, Any],
    rows: np.ndarray,
) -> TeamForce:
    from drake_ltl.dynamics.load_sharing import load_shares

    obj, team = action["object"], action["agents"]
    own = {}
    for name in team:
        q, qd, qdd = recording.q[name][rows], recording.qd[name][rows], _rate(recording, recording.qd[name], rows)
        own[name] = np.array([agents[name].inverse_dynamics(*row)[:2] for row in zip(q, qd, qdd, strict=True)])
    total = sum(own.values()) + mass[obj] * _rate(recording, recording.velocity[obj][:, 3:5], rows)
    power = {agent.name: agent.power for agent in scenario.agents}
    share = dict(zip(team, load_shares([power[name] for name in team]).tolist(), strict=True))
    on_object = {name: share[name] * total - own[name] for name in team}
    return TeamForce(obj, step.number, recording.time[rows], total, share, on_object)


def _draw_effort(figure: Figure, recording: Recording) -> None:
    axes = figure.add_subplot()
    for index, (name, colour) in enumerate(agent_colours(recording.agents).items()):
        t, least = least_in_buckets(recording.time, -recording.effort[:, index])
        axes.plot(t, -100.0 * least, color=colour, label=name, lw=1.2)
    highest = 100.0 * float(recording.effort.max(initial=0.0))
    if highest > 60.0:
        axes.axhline(100.0, color=DANGER, lw=0.9)
    axes.set_ylim(0.0, max(1.1 * highest, 1.0))
    axes.set_ylabel("torque asked for [% of limit]")
    axes.set_title("Torques of the joints", loc="left", pad=24)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.11), ncols=8, borderpad=0.0, columnspacing=1.2)
    time_axis(axes, recording)


def _draw_forces(figure: Figure, recording: Recording, forces: Sequence[TeamForce]) -> None:
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(1.0, 1.0))
    agents, objects = agent_colours(recording.agents), object_colours(recording.objects)
    labelled: set[str] = set()
    said, said_at = "", 0.0

    def label(name: str) -> str | None:
        labelled.add(name)
        return name

    for force in forces:
        total = np.linalg.norm(force.total, axis=1)
        seen = label(force.object) if force.object not in labelled else None
        upper.plot(force.time, total, color=objects[force.object], label=seen)
        shares = "\n".join(f"{name} {100 * share:.0f} %" for name, share in force.share.items())
        if (
            shares != said or force.time[0] > said_at + CLOSE * recording.time[-1]
        ):  # once for neighbours that share alike
            said, said_at = shares, float(force.time[-1])
            upper.annotate(
                shares, (force.time[0], total.max()), (0, 3), textcoords="offset points", fontsize=7, color=INK
            )
        for name, pushed in force.on_object.items():
            seen = label(name) if name not in labelled else None
            lower.plot(force.time, np.linalg.norm(pushed, axis=1), color=agents[name], label=seen, lw=1.2)
    upper.set_title("Horizontal forces of teams", loc="left", pad=24)
    upper.set_ylabel("of the whole team [N]")
    lower.set_ylabel("on the object [N]")
    for axes in (upper, lower):
        axes.set_yscale("log")
        top = axes.get_ylim()[1]
        axes.set_ylim(LEAST_FORCE, max(30.0 * top, 100.0 * LEAST_FORCE))
        axes.grid(axis="y", color=GRID, lw=0.6)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(loc="upper left", ncols=8, borderpad=0.2, columnspacing=1.2, facecolor="white", frameon=True)
    time_axis(upper, recording)
    upper.set_xlabel("")
    time_axis(lower, recording, numbers=False)
