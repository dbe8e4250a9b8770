"""The springs of redundant agents that carry, each resting where its agent began."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from drake_ltl.dynamics.null_space import PostureSpring
from drake_ltl.multibody.agent_model import AgentModel


class PostureSprings:
    """Makes them as they are asked for, and keeps the latest of each agent: an interval has one."""

    def __init__(self, agents: Mapping[str, AgentModel]):
        self._agents = agents
        self._latest: dict[str, tuple[bytes, PostureSpring]] = {}

    def of(self, agent: str, reference: np.ndarray) -> PostureSpring:
        """The spring of a redundant agent that began to carry in the configuration `reference` (n,)."""
        key = reference.tobytes()
        if self._latest.get(agent, (b"",))[0] != key:
            self._latest[agent] = (key, posture_spring(self._agents[agent], reference.copy()))
        return self._latest[agent][1]


def posture_spring(model: AgentModel, reference: np.ndarray) -> PostureSpring:
    """tau_0 of a redundant agent that carries in the posture of `reference` (n,)."""
    return PostureSpring(
        reference=reference,
        stiffness=model.posture_stiffness,
        damping=model.posture_damping,
        lower=model.plant.GetPositionLowerLimits(),
        upper=model.plant.GetPositionUpperLimits(),
        manipulability=model.manipulability(reference),
    )
