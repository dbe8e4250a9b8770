"""h_O: what lifts a load off the floor and keeps it level while it is carried, and why V falls with it.

Far from the goal k psi pulls with the force k along the error of the whole pose, which leaves a newton for a few
centimetres of height and for a few degrees of tilt. Those who carry, though, are dragged along by their grippers
against their own inertia, and that tilts the load; an edge that slides over the floor, tilted forward, catches there,
throws the load up and its team against each other. The floor's pushes are no part of (10b): nothing is known of V
where they act. So what is carried gets a potential of its own besides k psi,

    h_O(x_O) = K_z (z - z_l(d))^2 / 2 + K_t (1 - cos tilt),    z_l(d) = z* + LIFT d^2 / (d^2 + DESCENT^2),

d the horizontal distance from the goal, the tilt that of the axis which is vertical there. With grad (k psi + h_O) in
place of k grad psi in (10b) and V = k psi + h_O + kinetic energy (+ h of redundant agents, `null_space`),

    dV/dt = -v_O^T K_O v_O (- friction of redundant agents' springs) <= 0

by the paper's own argument, which asks of a potential that it is smooth and of its goal that it is the minimum:

- h_O is finite where an interval begins, so k psi stays finite, G positive, and nothing touches.
- At the goal h_O and its slope vanish: as it comes near, the load comes down.
- Elsewhere h_O adds no place of rest. G knows neither height nor tilt, so at rest these have settled: level, and at
  z* <= z <= z_l. Along d the slope is then k dpsi/dgamma 2 d + K_z (z_l - z) dz_l/dd, both of one sign and zero at
  d = 0 alone: h_O pulls where gamma pulls.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drake_ltl.dynamics.orientation import tilt_mismatch

LIFT = 0.05
"""How high a load is carried, but for what the posture springs of redundant arms take off that [m]: an edge of a crate
comes down by as much at a tilt of 10 degrees."""
DESCENT = 0.2
"""So near to its goal it has come down by half [m]; where goals count as reached, by all but a millimetre."""
HEIGHT_STIFFNESS = 1000.0
"""K_z [N/m]: the first pull is 50 N, which one arm can give."""
TILT_STIFFNESS = 60.0
"""K_t [N m/rad]: as stiff as the lightest arms allow at time steps of 10 ms."""


@dataclass(frozen=True)
class LoadSpring:
    """h_O of a load on its way to one goal."""

    p_goal: np.ndarray
    """p*_O (3,) [m] in W."""
    orientation_goal: np.ndarray
    """Of R*_WO, as a quaternion (4,)."""

    def value_and_slope(self, pose: np.ndarray) -> tuple[float, tuple[float, ...]]:
        """h_O [J] and its slope (6,) along (omega_W, v_W) [N m; N], for a quaternion and an origin (7,) [m]."""
        x, y, z = (here - there for here, there in zip(pose[4:].tolist(), self.p_goal.tolist(), strict=True))
        squared, width = x * x + y * y, DESCENT * DESCENT
        off = z - LIFT * squared / (squared + width)
        along = -HEIGHT_STIFFNESS * off * LIFT * 2.0 * width / (squared + width) ** 2
        tilt, turn = tilt_mismatch(pose[:4], self.orientation_goal)
        value = 0.5 * HEIGHT_STIFFNESS * off * off + TILT_STIFFNESS * tilt
        torque = (TILT_STIFFNESS * turn[0], TILT_STIFFNESS * turn[1], 0.0)
        return value, (*torque, along * x, along * y, HEIGHT_STIFFNESS * off)

    def energy(self, poses: np.ndarray) -> np.ndarray:
        """h_O (T,) [J] of poses (T, 7)."""
        return np.array([self.value_and_slope(pose)[0] for pose in poses])
