"""What is where in the state of a plant that has everything of a scenario."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex


@dataclass(frozen=True)
class StatePlaces:
    """Indices into a plant's positions and velocities (size,), as its state port has them."""

    size: int
    agents: tuple[str, ...]
    sizes: tuple[int, ...]
    """n_i of each."""
    q: np.ndarray
    """Configurations of all agents, stacked (n,)."""
    qd: np.ndarray
    """Their velocities (n,)."""
    pose: Mapping[str, slice]
    """object -> quaternion and origin (7,)."""
    velocity: Mapping[str, slice]
    """object -> angular and linear velocity (6,)."""

    @staticmethod
    def of(
        plant: MultibodyPlant, agents: Mapping[str, ModelInstanceIndex], objects: Mapping[str, ModelInstanceIndex]
    ) -> StatePlaces:
        """`plant` is finalized; objects are free bodies."""
        numbers = np.arange(plant.num_multibody_states(), dtype=float)
        positions, velocities = np.split(numbers, [plant.num_positions()])
        q = [plant.GetPositionsFromArray(instance, positions) for instance in agents.values()]
        qd = [plant.GetVelocitiesFromArray(instance, velocities) for instance in agents.values()]
        pose = {name: span(plant.GetPositionsFromArray(instance, positions)) for name, instance in objects.items()}
        velocity = {
            name: span(plant.GetVelocitiesFromArray(instance, velocities)) for name, instance in objects.items()
        }
        stacked_q, stacked_qd = np.concatenate(q).astype(int), np.concatenate(qd).astype(int)
        sizes = tuple(len(part) for part in q)
        return StatePlaces(len(numbers), tuple(agents), sizes, stacked_q, stacked_qd, pose, velocity)

    @cached_property
    def spans(self) -> Mapping[str, tuple[slice, slice]]:
        """agent -> where its configuration is, and where its velocities."""
        ends = np.cumsum(self.sizes)[:-1]
        parts = zip(self.agents, np.split(self.q, ends), np.split(self.qd, ends), strict=True)
        return {name: (span(q), span(qd)) for name, q, qd in parts}

    def not_finite(self, x: np.ndarray) -> list[str]:
        """Whose state has numbers that are not finite."""
        finite = np.isfinite(x)
        ends = np.cumsum(self.sizes)[:-1]
        parts = zip(self.agents, np.split(finite[self.q], ends), np.split(finite[self.qd], ends), strict=True)
        agents = [name for name, q, qd in parts if not (q.all() and qd.all())]
        return agents + [o for o in self.pose if not (finite[self.pose[o]].all() and finite[self.velocity[o]].all())]


def span(numbers: np.ndarray) -> slice:
    """The same as indices that follow one another, as those of all agents do and those of an object."""
    start, size = int(numbers[0]), len(numbers)
    assert np.array_equal(numbers, np.arange(start, start + size)), numbers
    return slice(start, start + size)
