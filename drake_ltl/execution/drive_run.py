"""Runs differential drives to their goals, and measures what became of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context

from drake_ltl.diagrams.drive_diagram import DriveDiagram
from drake_ltl.errors import ExecutionError

LOOK = 0.5
"""Simulated time between looks at whether all have arrived [s]."""
RISE = 1e-4
"""Of V in one step of the plant [J]: what integration in steps may add, a millionth of what V has at the start."""
SLIP = 1e-3
"""Speed of a tyre across the floor [m/s]: what regularised friction lets creep."""


@dataclass(frozen=True)
class Arrival:
    """When a drive counts as arrived."""

    position: float = 0.02
    """[m]"""
    heading: float = 0.02
    """[rad]"""
    speed: float = 0.01
    """[m/s]; of turning as many rad/s."""


@dataclass(frozen=True)
class DriveTrack:
    """One drive's way, at every step of the plant (T samples)."""

    p: np.ndarray
    """(T, 2) [m]"""
    theta: np.ndarray
    """(T,) [rad]"""
    v: np.ndarray
    """(T,) [m/s]"""
    omega: np.ndarray
    """(T,) [rad/s]"""
    aside: np.ndarray
    """(T,) [m/s], see `lateral_slip`."""
    rolling: np.ndarray
    """(T, 2) [m/s], speed of the axle above each wheel less what that wheel rolls."""
    effort: np.ndarray
    """(T, 2) commanded torques as shares of the limit."""
    parked: np.ndarray
    """(T,) bool"""
    goal: tuple[float, float, float]
    radius: float
    """Of its sphere [m]."""

    @property
    def position_error(self) -> float:
        """At the end [m]."""
        return float(np.linalg.norm(self.p[-1] - self.goal[:2]))

    @property
    def heading_error(self) -> float:
        """At the end [rad]."""
        return float(abs(np.angle(np.exp(1j * (self.theta[-1] - self.goal[2])))))

    @property
    def lateral_slip(self) -> float:
        """Largest speed of the axle's middle across its heading [m/s].

        Across the heading at the begin of each step of the plant: that is what tyres' friction acts on in a discrete
        plant. By the end of the step the heading has turned by omega dt.
        """
        return float(np.abs(self.aside).max())

    @property
    def rolling_slip(self) -> float:
        """Largest speed of a tyre over the floor along the heading [m/s], the wheel's nominal radius taken."""
        return float(np.abs(self.rolling).max())

    def __str__(self) -> str:
        return (
            f"{1e3 * self.position_error:.1f} mm and {np.degrees(self.heading_error):.2f} degrees off its goal pose; "
            f"slip at most {1e3 * self.lateral_slip:.2f} mm/s aside, {1e3 * self.rolling_slip:.2f} mm/s rolling; "
            f"at most {100.0 * np.abs(self.effort).max():.0f} % of torque"
        )

    def has_arrived(self, tolerance: Arrival) -> bool:
        """At the end."""
        still = max(abs(self.v[-1]), abs(self.omega[-1])) <= tolerance.speed
        return still and self.position_error <= tolerance.position and self.heading_error <= tolerance.heading


@dataclass(frozen=True)
class DriveRun:
    """What a run recorded."""

    time: np.ndarray
    """(T,) [s]"""
    lyapunov: np.ndarray
    """V (T,) [J]"""
    tracks: Mapping[str, DriveTrack]
    obstacles: np.ndarray
    """(n, 3) rows (x, y, radius) [m]."""
    arrived: bool

    @property
    def clearance(self) -> np.ndarray:
        """Least distance (T,) [m] of two spheres; infinite for one drive without obstacles."""
        tracks = list(self.tracks.values())
        gaps = [np.linalg.norm(a.p - b.p, axis=1) - a.radius - b.radius for a, b in combinations(tracks, 2)]
        gaps += [
            np.linalg.norm(a.p - obstacle[:2], axis=1) - a.radius - obstacle[2]
            for a in tracks
            for obstacle in self.obstacles
        ]
        return np.min(gaps, axis=0) if gaps else np.full(len(self.time), np.inf)

    @property
    def lyapunov_rise(self) -> float:
        """Largest increase of V in one step of the plant [J]; negative if it fell in every one."""
        return float(np.diff(self.lyapunov).max())

    def violations(self) -> list[str]:
        """What of the promises did not hold, a line for each; none if all is well."""
        slip = max(max(track.lateral_slip, track.rolling_slip) for track in self.tracks.values())
        effort = max(np.abs(track.effort).max() for track in self.tracks.values())
        checks = {
            "not all have arrived": self.arrived,
            f"spheres meet: clearance {self.clearance.min():.3g} m": self.clearance.min() > 0.0,
            f"V rises by {self.lyapunov_rise:.3g} J in a step": self.lyapunov_rise <= RISE,
            f"tyres slip at {slip:.3g} m/s": slip <= SLIP,
            f"torques are {effort:.3g} times their limit": effort <= 1.0 + 1e-9,
        }
        return [what for what, holds in checks.items() if not holds]

    def __str__(self) -> str:
        lines = [
            f"{'all arrived' if self.arrived else 'NOT ARRIVED'} after {self.time[-1]:.1f} s of simulated time",
            f"least clearance of spheres   {self.clearance.min():.3f} m",
            f"V                            {self.lyapunov[0]:.1f} J to {self.lyapunov[-1]:.2e} J",
            f"largest rise of V in a step  {max(self.lyapunov_rise, 0.0):.1e} J",
        ]
        return "\n".join([*lines, *(f"{name}: {track}" for name, track in self.tracks.items())])


def RunDrives(drives: DriveDiagram, *, time_limit: float = 60.0, arrival: Arrival | None = None) -> DriveRun:
    """Advances until all have arrived, or for `time_limit` [s].

    Raises ExecutionError where spheres meet.
    """
    arrival = arrival or Arrival()
    simulator = Simulator(drives.diagram, drives.CreateStartContext())
    context = simulator.get_mutable_context()
    simulator.Initialize()
    while context.get_time() < time_limit - 1e-9 and not _all_arrived(drives, context, arrival):
        simulator.AdvanceTo(min(context.get_time() + LOOK, time_limit))
    return _read(drives, context, arrival)


def _all_arrived(drives: DriveDiagram, context: Context, arrival: Arrival) -> bool:
    """By the last two samples of the logs, which is all that is asked of a track then."""
    if context.get_time() == 0.0:
        return False
    return all(_track(drives, context, name, last=2).has_arrived(arrival) for name in drives.models)


def _track(drives: DriveDiagram, context: Context, name: str, last: int = 0) -> DriveTrack:
    """Of the last so many samples; 0 means all."""
    model = drives.models[name]
    states, torques, stages = (
        drives.logs[f"{what}_{name}"].FindLog(context).data()[:, -last:].T for what in ("state", "torque", "stage")
    )
    rows = [model.planar_state(x) for x in states]
    theta, v, omega = (np.array([getattr(row, key) for row in rows]) for key in ("theta", "v", "omega"))
    turned = np.diff(theta, prepend=theta[0])
    aside = np.array([row.aside for row in rows]) * np.cos(turned) + v * np.sin(turned)
    offset = model.half_track * omega
    rolled = model.wheel_radius * np.array([row.wheels for row in rows])
    (drive,) = (drive for drive in drives.drives if drive.name == name)
    return DriveTrack(
        p=np.array([row.p for row in rows]),
        theta=theta,
        v=v,
        omega=omega,
        aside=aside,
        rolling=np.column_stack([v - offset, v + offset]) - rolled,
        effort=torques / model.effort,
        parked=stages[:, 1] > 0.5,
        goal=drive.goal,
        radius=model.radius,
    )


def _read(drives: DriveDiagram, context: Context, arrival: Arrival) -> DriveRun:
    log = drives.logs["lyapunov"].FindLog(context)
    tracks = {name: _track(drives, context, name) for name in drives.models}
    for name, track in tracks.items():
        if not np.isfinite(track.p).all():
            raise ExecutionError(f"the state of {name} is not finite")
    return DriveRun(
        time=log.sample_times().copy(),
        lyapunov=log.data()[0].copy(),
        tracks=tracks,
        obstacles=np.array([(*body.p_W[:2], body.radius) for body in drives.obstacles]).reshape(-1, 3),
        arrived=all(track.has_arrived(arrival) for track in tracks.values()),
    )
