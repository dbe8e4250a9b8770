"""What the numbers in the supervisor's signals mean."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from drake_ltl.systems.legs import ALL, Leg


class Phase(IntEnum):
    """Where a plan step stands."""

    NAVIGATE = 0
    """Travellers and teams move under the navigation function; agents at their stand-off grasp, holders release."""
    REACH = 1
    """Every mover has arrived; agents that first had to drive to their stand-off grasp now."""
    DONE = 2
    """The mission is over: everything holds."""
    SAFE = 3
    """A fault has been noticed: movers have braked, and whoever lets go comes away."""


class Mode(IntEnum):
    """What an agent does. Modes from TRANSPORT on: carries object number `mode - TRANSPORT`."""

    HOLD = 0
    TRANSITION = 1
    REACH = 2
    TRANSPORT = 3


class Stage(IntEnum):
    """How a differential drive travels: its sense, or 0 once it turns to its goal's heading."""

    BACKWARDS = -1
    PARKED = 0
    FORWARDS = 1


NO_GRASP = -1
"""In place of the index of a weld."""


STEP_SIGNAL_SIZE = 7


def pack_step(index: int, phase: Phase, interval: int, leg: Leg) -> np.ndarray:
    """Signal `step` (7,): index into the program, phase, interval, active mover or ALL, way point or nan, nan, rank of
    the exchange of places."""
    via = (np.nan, np.nan) if leg.via is None else leg.via
    return np.array([index, phase, interval, leg.active, *via, leg.exchange], dtype=float)


def unpack_step(signal: np.ndarray) -> tuple[int, Phase, Leg]:
    """Index into the program, phase, leg."""
    index, phase, _, active, x, y, exchange = signal
    via = None if int(active) == ALL or np.isnan(x) else (float(x), float(y))
    return int(index), Phase(int(phase)), Leg(int(active), via, int(exchange))


def pack_course(stage: int, q_goal: np.ndarray) -> np.ndarray:
    """Signal `course_<agent>` (1 + n,): Stage of a differential drive, and q where it goes to."""
    return np.concatenate([[stage], q_goal])


def pack_reach(start_time: float, duration: float, q_start: np.ndarray, q_goal: np.ndarray) -> np.ndarray:
    """Signal `reach_<agent>` (2 + 2 n,): start [s], duration [s], q at the start, q at the goal."""
    return np.concatenate([[start_time, duration], q_start, q_goal])


def reach_ends(reach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """q at the start and at the goal (n,)."""
    n = (len(reach) - 2) // 2
    return reach[2 : 2 + n], reach[2 + n :]
