"""What stands in a region, and the predicates P_s that say whether it fits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from drake_ltl.scenario.model import PublishedFits, Region


@dataclass(frozen=True)
class Content:
    """All bodies in one region at one state."""

    free_agents: tuple[str, ...] = ()
    """Agents that grasp nothing."""
    objects: tuple[str, ...] = ()
    """All objects, grasped or not."""
    holds: tuple[tuple[str, str], ...] = ()
    """(agent, object) for each agent that grasps."""
    carried: frozenset[str] = frozenset()
    """Objects about to be carried away, or just brought: with their teams they count as one sphere r_{T,j}."""


Fits = Callable[[Region, Content], bool]
"""P_{s,0}: whether the content fits in the region."""


def published_fits(rule: PublishedFits) -> Fits:
    """The counting rule that reproduces the published numbers of states (no geometry, carried or not)."""

    def fits(region: Region, content: Content) -> bool:
        del region  # every region has the same capacity
        weight = (
            rule.agent * len(content.free_agents)
            + rule.grasping * len(content.holds)
            + rule.object * len(content.objects)
        )
        return weight <= rule.capacity

    return fits
