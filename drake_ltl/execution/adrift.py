"""Robots out of service that nothing holds: how fast they coast, and what they come to.

Of a robot without torque and brakes only friction f [N s/m] takes momentum. From a speed v its centre of mass m goes on
by m v / f: nowhere to rest without friction, whatever the others do.
"""

from __future__ import annotations

import math

import numpy as np

from drake_ltl.faults.legs import Bodies
from drake_ltl.faults.losses import Losses

ADRIFT = 0.05
"""A centre of mass that is slower is not going anywhere [m/s]."""


def adrift(bodies: Bodies, losses: Losses) -> str:
    """Who of those out of service coasts, as a clause for each; empty if nobody does."""
    return "; ".join(filter(None, (_of_one(agent, bodies) for agent in sorted(losses.agents))))


def _of_one(agent: str, bodies: Bodies) -> str:
    velocity = bodies.models.agents[agent].mass_velocity(bodies.now.q[agent], bodies.now.qd[agent])[:2]
    speed = float(np.linalg.norm(velocity))
    if speed <= ADRIFT:
        return ""
    says = f"{agent} coasts at {speed:.2g} m/s, with neither torque nor brakes: nobody can hold it"
    return f"{says}, and unless something slows it, it {_comes_to(agent, velocity, bodies)}"


def _comes_to(agent: str, velocity: np.ndarray, bodies: Bodies) -> str:
    """The first sphere on the straight way, or the border of the workspace. Who is above or below is met as well."""
    here, radius = bodies.centre(agent)[:2], bodies.radius(agent)
    others = [name for name in (*bodies.now.q, *bodies.now.X_WO) if name != agent]
    meets = {name: _meeting(bodies.centre(name)[:2] - here, velocity, bodies.radius(name) + radius) for name in others}
    first = min(meets, key=meets.__getitem__, default="")
    leaves = _leaving(here, velocity, bodies.scenario.workspace_radius - radius)
    if meets.get(first, math.inf) < leaves:
        return f"comes to {first} within {meets[first]:.2g} s"
    return f"leaves the workspace within {leaves:.2g} s" if leaves > 0.0 else "has left the workspace"


def _meeting(way: np.ndarray, velocity: np.ndarray, reach: float) -> float:
    """When what moves at `velocity` [m/s] comes within `reach` of what is `way` ahead [m]: [s], infinite if never."""
    a, b, c = float(velocity @ velocity), float(way @ velocity), float(way @ way) - reach**2
    under = b * b - a * c
    return max(0.0, (b - math.sqrt(under)) / a) if b > 0.0 and under > 0.0 else math.inf


def _leaving(here: np.ndarray, velocity: np.ndarray, radius: float) -> float:
    """When a point comes to the border of a disc about the origin [s]; 0 if it is beyond."""
    a, b, c = float(velocity @ velocity), float(here @ velocity), float(here @ here) - radius**2
    return 0.0 if c >= 0.0 else (math.sqrt(b * b - a * c) - b) / a
