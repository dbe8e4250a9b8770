"""Lambda: whether the agents that grasp an object are strong enough to carry it."""

from __future__ import annotations

import math
from collections.abc import Callable

from drake_ltl.scenario.model import Scenario

CanCarry = Callable[[str, frozenset[str]], bool]
"""Lambda(m_j^O, zeta_T): (name of the object, names of the team T) -> whether T can carry it."""


def sum_rule(scenario: Scenario) -> CanCarry:
    """The rule of a scenario file: the powers zeta of the team add up to at least the object's need."""
    power = {agent.name: agent.power for agent in scenario.agents}
    needed = {obj.name: obj.power_needed for obj in scenario.objects}

    def can_carry(obj: str, team: frozenset[str]) -> bool:
        return math.fsum(power[agent] for agent in team) >= needed[obj]

    return can_carry
