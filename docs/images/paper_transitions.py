"""Makes paper_transitions.png: the two motions that the paper shows, with our gains and with its own.

    python docs/images/paper_transitions.py            # some minutes: by the paper's gains it takes 900 s and 300 s

Its Fig. 3: three arms travel at once, from pi1 to pi2, from pi3 to pi1, from pi4 to pi1. Its Fig. 4: two of them carry
an object from pi1 to pi3, each half of it. Its gains are K = 0.01 [N s/m, N m s/rad] and the gradient of phi itself, of
1 J at most. Its unit of length is open, and phi of metres is 1 to all digits far away: here it is 30 m, the workspace's
radius. Where an object is to be carried, those who carry it drive to it first, by the same gains.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from math import log
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.mission import measure, plan_and_place, simulate
from drake_ltl.navigation import PaperPhi
from drake_ltl.scenario import loads
from drake_ltl.scenario.model import ControllerSettings, Scenario
from drake_ltl.systems import detours

HERE = Path(__file__).parent
EXAMPLE = HERE.parents[1] / "examples" / "case_ii.yaml"
LENGTH = 30.0
"""The unit of length of the paper's phi [m]."""
KAPPA = 6.0
"""The paper's, of which it does not speak."""

WORLD = """\
name: {name}
workspace: {{radius: 30.0}}
regions:
  pi1: {{centre: [0.0, 0.0, 0.0], radius: 3.5}}
  pi2: {{centre: [-14.0, -14.0, 0.0], radius: 3.5}}
  pi3: {{centre: [20.0, -10.0, 0.0], radius: 3.5}}
  pi4: {{centre: [-16.0, 15.0, 0.0], radius: 3.5}}
agents:
  a1: {{model: {arm}, position: [{a1}], heading: 0.0, power: 2, radius: 1.25, spec: "{spec_1}"}}
  a2: {{model: {arm}, position: [{a2}], heading: 2.0944, power: 3, radius: 1.25, spec: "{spec_2}"}}
  a3: {{model: {arm}, position: [{a3}], heading: 4.1888, power: 3, radius: 1.25, spec: "{spec_3}"}}
objects:
  o1: {{model: {crate}, position: [-14.0, -14.5], power_needed: 5, radius: 0.5}}
  o2: {{model: {crate}, position: [-0.5, 0.2], power_needed: 6, radius: 0.5, spec: "{spec_o2}"}}
team_radius: 2.67
"""
MODELS = {
    "arm": "package://drake_ltl_models/agents/planar_arm.urdf",
    "crate": "package://drake_ltl_models/objects/crate.sdf",
}
TRANSITION = loads(
    WORLD.format(
        name="transition",
        a1="0.5, 0.0",
        a2="18.5, -11.5",
        a3="-14.0, 15.0",
        spec_1="F pi2",
        spec_2="F pi1",
        spec_3="F pi1",
        spec_o2="1",
        **MODELS,
    ).replace("[-0.5, 0.2]", "[-1.5, 0.2]")
)
TRANSPORT = loads(
    WORLD.format(
        name="transport",
        a1="-12.0, -12.5",
        a2="-0.9, -2.4",
        a3="-0.5, 2.6",
        spec_1="1",
        spec_2="1",
        spec_3="1",
        spec_o2="F pi3",
        **MODELS,
    )
)


@dataclass(frozen=True)
class PaperPhiOf:
    """phi of lengths in units of `length`."""

    kappa: float
    length: float
    supremum = 1.0

    def value(self, L):
        return PaperPhi(self.kappa).value(L - 2.0 * log(self.length))

    def log_slope(self, L):
        return PaperPhi(self.kappa).log_slope(L - 2.0 * log(self.length)) - 2.0 * log(self.length)


PAPER = ControllerSettings(
    kappa=KAPPA,
    force=1.0,
    shaping=PaperPhiOf(KAPPA, LENGTH),
    base_damping=0.01,
    arm_damping=0.01,
    team_damping=0.01,
    team_rotation_damping=0.01,
)


@dataclass(frozen=True)
class Curve:
    """What became of one motion."""

    recording: Recording
    rows: slice
    """From its begin to its end."""
    finished: bool
    distances: dict[str, np.ndarray]
    """Mover -> distance of its base, or its origin, from where it is to go [m]."""
    begun: bool
    """Else this is the motion before it, which did not come to an end."""

    @property
    def duration(self) -> float:
        time = self.recording.time[self.rows]
        return float(time[-1] - time[0])

    @property
    def end(self) -> str:
        """How it ended."""
        if self.finished:
            return "done after"
        return "in collision after" if self.recording.reason.startswith("in collision") else "not at rest after"

    @property
    def effort(self) -> float:
        """The largest torque asked of a joint, relative to its limit."""
        return float(self.recording.effort[self.rows].max())

    @property
    def rise(self) -> float:
        """Largest rise of V within a step of the plant, relative to V at the begin."""
        V = self.recording.lyapunov[self.rows]
        V = V[V > 0.0]
        return float(np.diff(V).max() / V[0])


def run(scenario: Scenario, kind: str) -> Curve:
    """The first step with an action of that kind, or as far as the run came."""
    models = measure(scenario)
    # By the paper's gains V may rise by more than monitors allow; what becomes of it is to be seen.
    result = simulate(plan_and_place(scenario, models), scenario, models, keep_going=True).recording
    steps = [s for s in result.steps if any(action["kind"] == kind for action in s.actions)]
    step = steps[0] if steps else result.steps[-1]  # what comes before it may not have been done in time
    interval = next(i for i in result.intervals if i.step == step.number)
    inside = np.flatnonzero((result.step == step.number) & (result.phase == interval.phase))
    rows = slice(int(inside[0]), int(inside[-1]) + 1)
    distances = {
        name: np.linalg.norm(result.q[name][rows, :2] - np.array(goal)[:2], axis=1)
        for name, goal in interval.travels.items()
    }
    distances |= {
        name: np.linalg.norm(result.pose[name][rows, 4:] - np.array(goal), axis=1)
        for name, goal in interval.transports.items()
    }
    return Curve(result, rows, step.finished, distances, bool(steps))


def main() -> None:
    """Writes the picture next to this script, and prints its numbers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ours-alone", action="store_true", help="leave the paper's gains out; no picture")
    ours_alone = parser.parse_args().ours_alone
    detours.STALL_TIME = np.inf  # the paper's law has no detours, and by its gains movers set out at a snail's pace
    panels = [("transition, Fig. 3", TRANSITION, "travel", 900.0), ("transport, Fig. 4", TRANSPORT, "transport", 300.0)]
    figure, axes = plt.subplots(2, 2, figsize=(9.6, 6.4), dpi=150, constrained_layout=True)
    for row, (title, scenario, kind, seconds) in enumerate(panels):
        curves = [("gains of this library", run(scenario, kind))]
        if not ours_alone:
            slow = replace(scenario.simulation, step_time_limit=seconds)
            curves.append(("the paper's gains", run(replace(scenario, controller=PAPER, simulation=slow), kind)))
        for column, (gains, curve) in enumerate(curves):
            name = title if curve.begun else f"the drive before {title}"
            print(
                f"{name}, {gains}: {curve.end} {curve.duration:.1f} s, "
                f"largest effort {curve.effort:.2f} of the limit, largest rise of V {curve.rise:.1e}; "
                + ", ".join(f"{name} {d[0]:.1f} -> {d[-1]:.3f} m" for name, d in curve.distances.items())
            )
            draw(axes[row, column], f"{name}, {gains}", curve)
    if not ours_alone:
        figure.savefig(HERE / "paper_transitions.png")


COLOURS = {"a1": "#c8502d", "a2": "#20603c", "a3": "#2d5fc8", "o2": "#7a2f8f"}


def draw(axes, title: str, curve: Curve) -> None:
    """Distances over time."""
    time = curve.recording.time[curve.rows]
    for name, distance in curve.distances.items():
        axes.semilogy(time - time[0], np.maximum(distance, 1e-3), color=COLOURS[name], lw=1.3, label=name)
    axes.set_title(
        f"{title}\n{curve.end} {curve.duration:.0f} s, effort {100.0 * curve.effort:.0f} % of its limit", fontsize=9
    )
    axes.set(xlabel="time [s]", ylabel="distance to the goal [m]", ylim=(1e-2, 50.0), xlim=(0.0, curve.duration))
    axes.axhline(0.03, color="#888888", lw=0.8, ls=":")
    axes.legend(frameon=False, fontsize=8)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


if __name__ == "__main__":
    main()
