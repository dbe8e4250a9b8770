"""What the models of a scenario make of recorded joints and poses: where bodies are, how far they reach, V.

A recording says itself where spheres are and what V was. All of it can be worked out again from the joint angles, the
objects' poses and the models alone (`models.work_out`), for the verdict to hold against what was recorded.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Mechanics:
    """A recorded run as its models see it; T samples."""

    centre: Mapping[str, np.ndarray]
    """agent -> c_i(q_i) (T, 3) [m] in W."""
    gripper: Mapping[str, np.ndarray]
    """agent with an arm -> X_WE(q_i) (T, 4, 4)."""
    ring: Mapping[str, np.ndarray]
    """object -> X_OG (4, 4), its grasp frame at azimuth 0; turned about the object's z axis it is one as well."""
    mass: Mapping[str, float]
    """object -> [kg]"""
    kinetic: Mapping[str, np.ndarray]
    """object -> (T,) its kinetic energy, with that mass [J]."""
    lowest: Mapping[str, np.ndarray]
    """object -> (T,) height of its lowest point above the floor [m]."""
    seen: np.ndarray
    """(S,) indices of the samples at which `reach` is known."""
    reach: Mapping[str, np.ndarray]
    """agent -> (S,) distance from c_i of the point of its geometry that is farthest from it [m]; object -> (1,)
    that from p_WO."""
    team_reach: Mapping[tuple[str, str], np.ndarray]
    """(object, agent) -> (S,) distance from p_WO of the farthest point of the agent's geometry [m]."""
    lyapunov: np.ndarray
    """(T,) V [J], formed anew; 0 where nothing moves under a navigation function."""
    goals: tuple[dict[str, np.ndarray], ...]
    """For each recorded interval, mover -> centre of its sphere at the goal (3,) [m]."""
    limits: Mapping[str, tuple[np.ndarray, np.ndarray]]
    """agent -> lower and upper limits of its joints (n_i,) [m, rad]."""
    distance: Callable[[str, str, int], float]
    """(agent, another member, sample) -> least signed distance of their collision geometries [m], but grippers
    against handles."""
    measured_radius: Mapping[str, float] = field(default_factory=dict)
    """Agent or object whose radius the scenario leaves open -> that of its model [m]."""
