"""What stands in a region, and the predicates P_s that say whether it fits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from drake_ltl.planning.plan import State
from drake_ltl.scenario.model import PublishedFits, Region, Scenario


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


def content_of(scenario: Scenario, state: State, region: str, carried: frozenset[str] = frozenset()) -> Content:
    """What stands in a region."""
    free, holds = [], []
    for agent, at, grasp in zip(scenario.agent_names, state.agents, state.grasps, strict=True):
        if at == region:
            free += [agent] if grasp is None else []
            holds += [] if grasp is None else [(agent, grasp)]
    objects = [o for o, at in zip(scenario.object_names, state.objects, strict=True) if at == region]
    return Content(tuple(free), tuple(objects), tuple(holds), carried)


Fits = Callable[[Region, Content], bool]
"""P_{s,0}: whether the content fits in the region. It may have an attribute `counts_agents`, true if it asks how many
agents are free and how many hold each object, never which; and `of_region`, a function that says on what of a region
the answer depends."""


def published_fits(rule: PublishedFits) -> Fits:
    """The counting rule that reproduces the published numbers of states (no geometry, carried or not)."""
    return _Counting(rule)


@dataclass(frozen=True)
class _Counting:
    rule: PublishedFits
    counts_agents: bool = True

    @staticmethod
    def of_region(region: Region) -> None:
        """Nothing: every region has the same capacity."""
        del region

    def __call__(self, region: Region, content: Content) -> bool:
        del region
        weight = (
            self.rule.agent * len(content.free_agents)
            + self.rule.grasping * len(content.holds)
            + self.rule.object * len(content.objects)
        )
        return weight <= self.rule.capacity
