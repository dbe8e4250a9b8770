"""Torques of a differential drive among all other agents, (U2) to (U4) of `navigation.unicycle`, and its stages.

V of a mission has `scale` m v^2 / 2 of each drive that travels. With F = h . f / scale - K_v v its share of dV/dt is
-h . f v + scale v F = -scale K_v v^2, whatever others do and however it turns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drake_ltl.dynamics import growing_damping
from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS
from drake_ltl.multibody.drive_agent import YAW, DriveAgent
from drake_ltl.navigation.dipole import heading_vector
from drake_ltl.navigation.unicycle import (
    UnicycleGains,
    direction_of_force,
    drive_force,
    is_at_rest,
    is_parked,
    sense_of_travel,
    steering_torque,
    wheel_torques,
)
from drake_ltl.systems.signals import Stage


def sense(q: np.ndarray, q_goal: np.ndarray) -> int:
    """FORWARDS or BACKWARDS, whichever lies nearer to the headings at both ends."""
    p, p_goal = q[:NUM_BASE_JOINTS], q_goal[:NUM_BASE_JOINTS]
    return int(sense_of_travel(q[YAW], p, p_goal, q_goal[YAW]))


def next_stage(model: DriveAgent, stage: int, q: np.ndarray, qd: np.ndarray, q_goal: np.ndarray) -> int:
    """PARKED from when it has come near its goal; on its way anew when it has gone far, or come to rest not near."""
    v, omega = _rates(q, qd)
    at_rest = is_at_rest(q[YAW], v, omega, q_goal[YAW], model.gains)
    if is_parked(stage == Stage.PARKED, at_rest, model.gamma(q, q_goal), model.gains):
        return Stage.PARKED
    return sense(q, q_goal) if stage == Stage.PARKED else stage


@dataclass(frozen=True)
class DriveLaw:
    """What one drive's wheels do. Configurations are (8,), as `DriveAgent` has them."""

    model: DriveAgent
    frequency: float
    """Of those who hold [rad/s]."""
    speed_limit: float
    """Beyond which damping grows [m/s]."""

    def travel(self, q: np.ndarray, qd: np.ndarray, gradient: np.ndarray, stage: int, q_goal: np.ndarray) -> np.ndarray:
        """Torques (8,) from k dPhi/dq (8,)."""
        (v, omega), gains = _rates(q, qd), self.model.gains
        f = gradient[:NUM_BASE_JOINTS] / -self.model.scale
        parked = stage == Stage.PARKED
        u = heading_vector(q_goal[YAW]) if parked else direction_of_force(f, stage, gains.softness)
        damping = growing_damping(gains.drive_damping, abs(v), self.speed_limit)
        return self._torques(drive_force(q[YAW], v, f, damping), steering_torque(q[YAW], omega, u, gains))

    def hold(self, q: np.ndarray, qd: np.ndarray, q_hold: np.ndarray) -> np.ndarray:
        """Torques (8,) that bring it back along its heading, and to its heading, as fast as `frequency` says; across
        its heading it cannot, and nothing moves it but its wheels."""
        (v, omega), w, drive = _rates(q, qd), self.frequency, self.model.drive
        f = drive.mass * w * w * (q_hold - q)[:NUM_BASE_JOINTS]
        gains = UnicycleGains(turn_stiffness=drive.inertia * w * w, turn_damping=2.0 * drive.inertia * w)
        tau = steering_torque(q[YAW], omega, heading_vector(q_hold[YAW]), gains)
        return self._torques(drive_force(q[YAW], v, f, 2.0 * drive.mass * w), tau)

    def _torques(self, F: np.ndarray, tau: np.ndarray) -> np.ndarray:
        model, drive = self.model, self.model.drive
        torques = np.zeros(model.n)
        torques[list(model.wheels)] = wheel_torques(
            float(F), float(tau), drive.wheel_radius, drive.half_track, model.effort
        )
        return torques


def _rates(q: np.ndarray, qd: np.ndarray) -> tuple[float, float]:
    """v [m/s] and omega [rad/s]."""
    return float(heading_vector(q[YAW]) @ qd[:NUM_BASE_JOINTS]), float(qd[YAW])
