"""An agent on two driven wheels, as a controller sees it: it travels, and has no arm."""

from __future__ import annotations

import math
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS, AgentModel
from drake_ltl.multibody.differential_drive_model import DifferentialDriveModel
from drake_ltl.multibody.drive_urdf import FREE_JOINTS
from drake_ltl.multibody.parsing import has_wheels
from drake_ltl.scenario.model import Agent, Scenario
from drake_ltl.scenario.model_files import WHEELS

if TYPE_CHECKING:  # verdicts load models, and nothing that steers
    from drake_ltl.navigation.dipole import Dipole
    from drake_ltl.navigation.unicycle import UnicycleGains

FLOOR_FRICTION = 0.6
"""Coefficient of the floor on which all missions take place."""
GRIP = 0.6
"""Share of the tyres' friction that torques make use of: the rest is for casters that are pressed down, and bends."""
FAR = 0.5
"""Share of the traction that the far-field force takes: the rest turns, and keeps clear of what is near."""
CRUISE = 2.0
"""Speed to which far-field force and damping would bring a drive [m/s], did damping not grow beyond ..."""
BRISK = 0.25
"""... this speed [m/s]: whom wheels have to stop before others do not run into them."""
LATERAL = 1.5
"""Acceleration across the heading to which a drive slows its turning [m/s^2]: the rest of the grip is for braking."""
NEAR, NEAR_DAMPING = 1.0, 2.0
"""Damping is larger about the goal, by this factor within this distance [m]: critical for the error along the heading,
which has the softest spring of all."""
PARK_DAMPING = 8.0
"""... and by this factor while it turns on the spot, where it should not move: tyres and casters give way by tenths of
a millimetre as torques change, and so rock a body that moves."""
BRAKING = 2.0
"""Damping for each newton of a force against the motion [s/m]: who comes near something at speed brakes while wheels
can, not when only the barrier is left."""
TURN_RATE = 2.5
"""Largest rate of turning [rad/s]."""
TURN_DECAY = 6.4
"""Of the rate, without torque to turn [1/s]: with TURN_RATE, headings come within e of their goal in 0.4 s."""
SUNK = 1e-4
"""How deep wheels begin in the floor, about as deep as they stand in it [m]."""
DEEPEST = 2e-3
"""How deep wheels stand in the floor at most, as far as the bounding sphere is concerned [m]."""
YAW, HEIGHT = FREE_JOINTS.index("yaw"), FREE_JOINTS.index("z")


class DriveAgent(AgentModel):
    """A differential drive, q = (x, y, yaw, z, pitch, roll, wheels) (8,) as `drive_urdf` has it.

    (x, y) is its p, the centre of mass above the middle of its axle, and yaw its heading theta; its bounding sphere is
    about p, at the height of the frame `bounding_centre`. The navigation function knows of p alone.
    """

    has_arm = False

    def __init__(self, agent: Agent, force: float):
        """`force` is k of all movers [N].

        Raises InvalidInputError with one mistake for each point in which the model is not as `DifferentialDriveModel`
        says.
        """
        self.drive = drive = DifferentialDriveModel(f"agents.{agent.name}", agent.model)
        super().__init__(agent)
        friction = 2.0 * FLOOR_FRICTION * drive.tyre_friction / (FLOOR_FRICTION + drive.tyre_friction)
        grip = GRIP * friction * drive.weight * drive.wheel_radius / 2.0
        self.effort: float = min(drive.effort, grip)
        """Most that a wheel is asked for [N m]: what its motor can do, and its tyre."""
        if not self.effort > 0.0:
            what = "has wheels that cannot drive it: no torque, no friction or no weight on them"
            remedy = "give each wheel an effort, and its tyre drake:mu_static"
            raise InvalidInputError([Mistake(f"agents.{agent.name}.model", what, remedy)])
        far = FAR * self.traction
        self.scale: float = max(1.0, force / far)
        """By which the field's force is divided, and the drive's kinetic energy multiplied in V: its wheels may be weak
        where others are strong."""
        self._damping = force / self.scale / CRUISE
        joints = self.joint_names
        self.wheels: tuple[int, int] = (joints.index(WHEELS[0]), joints.index(WHEELS[1]))
        """Rows of the left and of the right one in q."""

    @cached_property
    def gains(self) -> UnicycleGains:
        """Of (U2) to (U4), with the damping far from the goal."""
        from drake_ltl.navigation.unicycle import UnicycleGains

        decay = TURN_DECAY * self.drive.inertia
        return UnicycleGains(drive_damping=self._damping, turn_stiffness=TURN_RATE * decay, turn_damping=decay)

    @property
    def traction(self) -> float:
        """Most that both wheels drive with [N]."""
        return 2.0 * self.effort / self.drive.wheel_radius

    @property
    def mass_in_V(self) -> float:
        """Reduced mass times `scale` [kg]: V has half of it times v^2."""
        return self.scale * self.drive.mass

    @property
    def is_redundant(self) -> bool:
        """It has no arm."""
        return False

    @property
    def yaw_direction(self) -> float:
        """0: it cannot turn what it carries, as it carries nothing."""
        return 0.0

    @property
    def start_arm(self) -> np.ndarray:
        """Its heading, on its wheels."""
        return np.array([self.agent.heading, -SUNK, 0.0, 0.0, 0.0, 0.0])

    @property
    def arm_limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Of all joints but x and y (6,) [rad, m], as far as its sphere has to cover them: wheels turn, tyres give way,
        and yaw changes nothing."""
        lower, upper = np.zeros(self.n), np.zeros(self.n)
        lower[list(self.wheels)], upper[list(self.wheels)] = -np.pi, np.pi
        lower[HEIGHT] = upper[HEIGHT] = -DEEPEST
        return lower[NUM_BASE_JOINTS:], upper[NUM_BASE_JOINTS:]

    @property
    def effort_limits(self) -> np.ndarray:
        """(8,) [N m]; inf for joints that nothing drives, and nothing is asked of."""
        limits = np.full(self.n, np.inf)
        limits[list(self.wheels)] = self.drive.effort
        return limits

    def arriving(self, q: np.ndarray, region: str) -> np.ndarray:
        """q (8,) with the heading that it should have there."""
        goal = q.copy()
        goal[YAW] = self.agent.headings.get(region, self.agent.heading)
        return goal

    def goal_error(self, q: np.ndarray, q_goal: np.ndarray) -> tuple[float, np.ndarray]:
        """gamma_z of its dipole [m^2] and half its gradient (8,)."""
        gamma, slope_x, slope_y = _dipole(q_goal).at(float(q[0]), float(q[1]))
        slope = np.zeros(self.n)
        slope[:NUM_BASE_JOINTS] = 0.5 * slope_x, 0.5 * slope_y
        return gamma, slope

    def gamma(self, q: np.ndarray, q_goal: np.ndarray) -> np.ndarray:
        """gamma_z (...) [m^2] of configurations (..., 8)."""
        return _dipole(q_goal).value(q[..., :NUM_BASE_JOINTS])

    def rates_of_travel(self, qd: np.ndarray) -> np.ndarray:
        """Of p and of its heading (3,): wheels turn ten times as fast, and a body rocks where it stands."""
        return qd[: YAW + 1]

    def joint_error(self, q: np.ndarray, q_goal: np.ndarray) -> float:
        """Between headings [rad]."""
        return abs(math.remainder(q[YAW] - q_goal[YAW], 2.0 * math.pi))

    def drive_damping(self, q: np.ndarray, q_goal: np.ndarray, *, parked: bool = False) -> float:
        """K_v [N s/m]: positive, which is all that the fall of V asks of it."""
        if parked:
            return PARK_DAMPING * self._damping
        gamma, _, _ = _dipole(q_goal).at(float(q[0]), float(q[1]))
        return self._damping * (1.0 + (NEAR_DAMPING - 1.0) / (1.0 + gamma / NEAR**2))

    def unexplained(self, q: np.ndarray, qdd: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """What (U1) leaves unexplained (8,), with the wheels' torques in `torque` (8,): m dv/dt - F [N] at x and
        I domega/dt - tau [N m] at yaw."""
        drive, (left, right) = self.drive, torque[[*self.wheels]]
        residual = np.zeros(self.n)
        along = math.cos(q[YAW]) * qdd[0] + math.sin(q[YAW]) * qdd[1]  # dv/dt, as it moves along its heading alone
        residual[0] = drive.mass * along - (left + right) / drive.wheel_radius
        residual[YAW] = drive.inertia * qdd[YAW] - (right - left) * drive.half_track / drive.wheel_radius
        return residual

    def energy(self, q: np.ndarray, qd: np.ndarray) -> float:
        """`mass_in_V` v^2 / 2 [J]; turning has no part in V."""
        v = math.cos(q[YAW]) * qd[0] + math.sin(q[YAW]) * qd[1]
        return 0.5 * self.mass_in_V * v * v

    def _require_holonomic_base(self) -> None:
        """It has none."""


def make_agent_model(agent: Agent, scenario: Scenario) -> AgentModel:
    """Of either kind, as its file has it. Raises InvalidInputError where the model cannot be used."""
    return DriveAgent(agent, scenario.controller.force) if has_wheels(agent) else AgentModel(agent)


def _dipole(q_goal: np.ndarray) -> Dipole:
    return _made(float(q_goal[0]), float(q_goal[1]), float(q_goal[YAW]))


@lru_cache(maxsize=256)
def _made(x: float, y: float, heading: float) -> Dipole:
    from drake_ltl.navigation.dipole import Dipole

    return Dipole((x, y), heading)
