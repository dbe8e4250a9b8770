"""Torques of a differential drive among all other agents, (U2) to (U4) of `navigation.unicycle`, and its stages.

V of a mission has `scale` m v^2 / 2 of each drive that travels. With F = h . f / scale - K_v v its share of dV/dt is
-h . f v + scale v F = -scale K_v v^2, whatever others do and however it turns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from drake_ltl.dynamics import growing_damping
from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS
from drake_ltl.multibody.drive_agent import BRAKING, BRISK, LATERAL, TURN_RATE, YAW, DriveAgent
from drake_ltl.navigation.unicycle import is_at_rest, is_parked, sense_of_travel
from drake_ltl.systems.signals import Stage


def sense(q: np.ndarray, q_goal: np.ndarray) -> int:
    """FORWARDS or BACKWARDS, whichever lies nearer to the headings at both ends."""
    p, p_goal = q[:NUM_BASE_JOINTS], q_goal[:NUM_BASE_JOINTS]
    return int(sense_of_travel(q[YAW], p, p_goal, q_goal[YAW]))


def next_stage(model: DriveAgent, stage: int, q: np.ndarray, qd: np.ndarray, q_goal: np.ndarray) -> int:
    """PARKED from when it has come near its goal; on its way anew when it has gone far, or come to rest not near."""
    at = _Planar.of(q, qd)
    at_rest = is_at_rest(q[YAW], at.v, at.omega, q_goal[YAW], model.gains)
    if is_parked(stage == Stage.PARKED, at_rest, model.gamma(q, q_goal), model.gains):
        return Stage.PARKED
    return sense(q, q_goal) if stage == Stage.PARKED else stage


@dataclass(frozen=True)
class DriveLaw:
    """What one drive's wheels do. Configurations are (8,), as `DriveAgent` has them.

    (U2) to (U4) in floats, which are a good deal faster than arrays of one.
    """

    model: DriveAgent
    frequency: float
    """Of those who hold [rad/s]."""
    speed_limit: float
    """Beyond which damping grows [m/s]."""

    def travel(self, q: np.ndarray, qd: np.ndarray, gradient: np.ndarray, stage: int, q_goal: np.ndarray) -> np.ndarray:
        """Torques (8,) from k dPhi/dq (8,)."""
        at, gains, scale = _Planar.of(q, qd), self.model.gains, -self.model.scale
        f_x, f_y = float(gradient[0]) / scale, float(gradient[1]) / scale
        parked = stage == Stage.PARKED
        if parked:
            u_x, u_y = math.cos(q_goal[YAW]), math.sin(q_goal[YAW])
        else:
            length = math.sqrt(f_x * f_x + f_y * f_y + gains.softness**2)
            u_x, u_y = stage * f_x / length, stage * f_y / length
        damping = growing_damping(
            self.model.drive_damping(q, q_goal, parked=parked), abs(at.v), min(BRISK, self.speed_limit)
        )
        pull = at.along(f_x, f_y)
        damping += BRAKING * max(0.0, -math.copysign(pull, pull * at.v))
        slower = min(1.0, LATERAL / max(TURN_RATE * abs(at.v), LATERAL))
        tau = slower * gains.turn_stiffness * at.turn(u_x, u_y) - gains.turn_damping * at.omega
        return self._torques(pull - damping * at.v, tau)

    def hold(self, q: np.ndarray, qd: np.ndarray, q_hold: np.ndarray) -> np.ndarray:
        """Torques (8,) that bring it back along its heading, and to its heading, as fast as `frequency` says; across
        its heading it cannot, and nothing moves it but its wheels."""
        at, w, drive = _Planar.of(q, qd), self.frequency, self.model.drive
        away, aside = float(q_hold[0] - q[0]), float(q_hold[1] - q[1])
        turn = at.turn(math.cos(q_hold[YAW]), math.sin(q_hold[YAW]))
        F = drive.mass * w * (w * at.along(away, aside) - 2.0 * at.v)
        return self._torques(F, drive.inertia * w * (w * turn - 2.0 * at.omega))

    def _torques(self, F: float, tau: float) -> np.ndarray:
        """F gets what it asks for and tau the rest, as in `wheel_torques`."""
        model, drive = self.model, self.model.drive
        mean = min(max(0.5 * drive.wheel_radius * F, -model.effort), model.effort)
        spare = model.effort - abs(mean)
        half = min(max(0.5 * drive.wheel_radius / drive.half_track * tau, -spare), spare)
        torques, (left, right) = np.zeros(model.n), model.wheels
        torques[left], torques[right] = mean - half, mean + half
        return torques


class _Planar(NamedTuple):
    """Where it heads and how it moves."""

    cos: float
    sin: float
    v: float
    """Along its heading [m/s]."""
    omega: float
    """[rad/s]"""

    @staticmethod
    def of(q: np.ndarray, qd: np.ndarray) -> _Planar:
        cos, sin = math.cos(q[YAW]), math.sin(q[YAW])
        return _Planar(cos, sin, cos * float(qd[0]) + sin * float(qd[1]), float(qd[YAW]))

    def along(self, x: float, y: float) -> float:
        """h . (x, y)."""
        return self.cos * x + self.sin * y

    def turn(self, x: float, y: float) -> float:
        """turn(theta, u) of (U3)."""
        aside = self.cos * y - self.sin * x
        return aside if self.along(x, y) >= 0.0 else math.copysign(math.hypot(x, y), aside)
