"""What all agents' models make of a recorded motion, sample by sample, each set only once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from drake_ltl.multibody.crew import CrewModel


@dataclass(frozen=True)
class CrewMotion:
    """Kinematics and energy of the crew, one row per sample."""

    centre: Mapping[str, np.ndarray]
    """agent -> c_i (T, 3) [m] in W"""
    grasp_jacobian: Mapping[str, np.ndarray]
    """agent with an arm -> J_i (T, 6, n_i)"""
    kinetic_energy: np.ndarray
    """(T,) [J]"""


def crew_motion(crew: CrewModel, q: Mapping[str, np.ndarray], qd: np.ndarray) -> CrewMotion:
    """Of configurations, agent -> (T, n_i), and of stacked velocities (T, n) of those whose energy counts."""
    T, stacked = len(qd), np.concatenate([*q.values()], axis=1)
    motion = CrewMotion(
        centre={name: np.empty((T, 3)) for name in q},
        grasp_jacobian={name: np.empty((T, 6, q[name].shape[1])) for name in crew.with_arms},
        kinetic_energy=np.empty(T),
    )
    for row in range(T):
        crew.set_state(stacked[row], qd[row])
        motion.kinetic_energy[row] = crew.kinetic_energy()
        for name in q:
            motion.centre[name][row] = crew.centre(name)
        for name in crew.with_arms:
            motion.grasp_jacobian[name][row] = crew.grasp_jacobian(name)
    return motion
