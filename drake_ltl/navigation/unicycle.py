"""Bodies that cannot move sideways under a navigation function: the paper's remark 2.

A differential drive has the pose (p, theta), the speed v along its heading h = (cos theta, sin theta), the rate omega:

    dp/dt = v h,   dtheta/dt = omega,   m dv/dt = F,   I domega/dt = tau,                              (U1)

with m and I the reduced inertia, wheels' rotation included, and the centre of its sphere at p. With f = -k dPhi/dp:

    F   = h . f - K_v v,                                                                               (U2)
    tau = K_theta turn(theta, u) - K_omega omega,   n = dh/dtheta,                                     (U3)
    turn = n . u  where h . u >= 0,   sign(n . u) |u|  elsewhere.

Heading does no work: V = k Phi + sum m v^2 / 2 has dV/dt = -sum K_v v^2 by (U1) and (U2), **whatever tau is**. So
spheres never meet, however agents turn, and tau is free to choose where to turn to, the direction u:

    on the way   u = sense f / sqrt(|f|^2 + softness^2), along the force, forwards or backwards;       (U4)
    when parked  u = h_goal.

docs/navigation.md has the argument in full. All functions broadcast over leading axes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.navigation.dipole import heading_vector, left_of
from drake_ltl.navigation.relations import Array


@dataclass(frozen=True)
class UnicycleGains:
    """Gains of (U2) to (U4) and when to park. Raises InvalidInputError unless all are positive, and leave > park."""

    drive_damping: float = 20.0
    """K_v [N s/m]; the force divided by it is the cruise speed."""
    turn_stiffness: float = 5.0
    """K_theta [N m]."""
    turn_damping: float = 2.0
    """K_omega [N m s/rad]; K_theta / K_omega is the largest rate."""
    softness: float = 0.02
    """Of the direction of a vanishing force [N]."""
    park: float = 0.01
    """sqrt(gamma) below which an agent turns to its goal's heading, and above which it does not stay there [m]."""
    leave: float = 0.05
    """sqrt(gamma) above which it sets out again at once [m]."""
    still: float = 0.01
    """Speeds, and errors of heading, below which it has come to rest [m/s, rad/s, rad]."""

    def __post_init__(self) -> None:
        mistakes = [
            Mistake(f"gains.{name}", f"is {value!r}", "must be positive and finite")
            for name, value in vars(self).items()
            if not 0.0 < value < np.inf
        ]
        if not mistakes and not self.leave > self.park:
            mistakes.append(Mistake("gains.leave", f"is {self.leave!r}", f"must be above park, {self.park!r}"))
        if mistakes:
            raise InvalidInputError(mistakes)


def drive_force(theta: Array, v: Array, f: Array, damping: Array | float) -> Array:
    """(U2): F (...) [N] along the heading, from f (..., 2) [N]."""
    return (heading_vector(theta) * f).sum(axis=-1) - damping * v


def steering_torque(theta: Array, omega: Array, u: Array, gains: UnicycleGains) -> Array:
    """(U3): tau (...) [N m] that turns the heading to u (..., 2), |u| <= 1; leftwards from its opposite."""
    h = heading_vector(theta)
    ahead, aside = (h * u).sum(axis=-1), (left_of(h) * u).sum(axis=-1)
    length = np.sqrt(ahead * ahead + aside * aside)
    turn = np.where(ahead >= 0.0, aside, np.where(aside >= 0.0, length, -length))
    return gains.turn_stiffness * turn - gains.turn_damping * omega


def direction_of_force(f: Array, sense: Array | float, softness: float) -> Array:
    """(U4): u (..., 2) along f, smooth at f = 0 and of length 1 elsewhere; against f where sense is -1."""
    length = np.sqrt((f * f).sum(axis=-1) + softness**2)
    return np.asarray(sense / length)[..., None] * f


def sense_of_travel(theta: Array, p: Array, p_goal: Array, theta_goal: Array) -> Array:
    """1 (...) to drive forwards, -1 to drive backwards: which of them lies nearer to both headings, start's and goal's.

    It is chosen when an agent sets out, for the whole way, lest it turn round half-way.
    """
    way = np.asarray(p_goal) - p
    agreement = (way * (heading_vector(theta) + heading_vector(theta_goal))).sum(axis=-1)
    return np.where(agreement >= 0.0, 1.0, -1.0)


def is_parked(was_parked: Array, at_rest: Array, gamma: Array, gains: UnicycleGains) -> Array:
    """Whether an agent turns to its goal's heading (...): from when it has come near, until it has gone far, or come to
    rest without being near."""
    allowed = np.where(np.logical_and(was_parked, np.logical_not(at_rest)), gains.leave, gains.park)
    return gamma <= allowed**2


def is_at_rest(theta: Array, v: Array, omega: Array, theta_goal: Array, gains: UnicycleGains) -> Array:
    """Whether an agent has turned to its goal's heading and come to rest (...)."""
    turned = np.cos(theta - theta_goal) >= np.cos(gains.still)
    return turned & (np.maximum(np.abs(v), np.abs(omega)) <= gains.still)


def lyapunov(potential: Array, masses: Array, v: Array) -> Array:
    """V (...) [J] = k Phi + sum m v^2 / 2, from k Phi (...), m (N,) [kg] and v (..., N) [m/s]. Turning has no part."""
    return potential + 0.5 * (masses * v**2).sum(axis=-1)


def wheel_torques(F: Array, tau: Array, radius: float, half_track: float, effort: float) -> tuple[Array, Array]:
    """Wheels' torques left, right (...) [N m]: F = (left + right) / radius, tau = (right - left) half_track / radius.

    Each is at most `effort`. What F leaves, and no more, goes to tau: heading does no work, so that cutting tau off
    costs time but never raises V. F is cut off only beyond 2 effort / radius.
    """
    mean = np.clip(0.5 * radius * F, -effort, effort)
    spare = effort - np.abs(mean)
    half = np.clip(0.5 * radius * tau / half_track, -spare, spare)
    return mean - half, mean + half
