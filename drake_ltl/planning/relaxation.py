"""A problem with some of its formulas and facts left out, so that at least the same runs are possible."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from drake_ltl.planning.demands import Demand, demands, speaks_of, with_demands
from drake_ltl.planning.fits import Content, Fits
from drake_ltl.planning.plan import State
from drake_ltl.planning.power import CanCarry
from drake_ltl.scenario.model import Region, Scenario


@dataclass(frozen=True)
class Power:
    """The fact that not every team can carry an object. Left out, any single agent can."""

    object: str


@dataclass(frozen=True)
class Room:
    """The fact that not everything fits in a region. Left out, everything does."""

    region: str


@dataclass(frozen=True)
class Start:
    """The fact that a member begins as it does. Left out, it may begin in any region (an agent: grasping or not)."""

    member: str


Reason = Demand | Power | Room | Start


@dataclass(frozen=True)
class Problem:
    """What a planner is asked, and which of it may be left out."""

    scenario: Scenario
    start: State
    fits: Fits
    can_carry: CanCarry

    @property
    def reasons(self) -> tuple[Reason, ...]:
        """All formulas, split at their conjunctions, then all facts."""
        scenario = self.scenario
        return (
            *demands(scenario),
            *map(Power, scenario.object_names),
            *map(Room, scenario.region_names),
            *map(Start, scenario.agent_names + scenario.object_names),
        )

    def with_only(self, kept: Iterable[Reason]) -> Problem:
        """The same without all reasons but some. The start stays: see `drake_ltl.planning.existence`."""
        kept = frozenset(kept)
        scenario = with_demands(self.scenario, [r for r in self.reasons if isinstance(r, Demand) and r in kept])

        def fits(region: Region, content: Content) -> bool:
            return Room(region.name) not in kept or self.fits(region, content)

        def can_carry(obj: str, team: frozenset[str]) -> bool:
            return Power(obj) not in kept or self.can_carry(obj, team)

        return Problem(scenario, self.start, fits, can_carry)


def starts_to_try(problem: Problem, kept: Iterable[Reason]) -> Iterator[State]:
    """The initial state, and those in which one member begins elsewhere, if its start is left out.

    Only members of which the kept formulas speak begin elsewhere, and only if no grasp is concerned.
    """
    scenario, start, kept = problem.scenario, problem.start, frozenset(kept)
    yield start
    speaking = [speaks_of(scenario, reason) for reason in kept if isinstance(reason, Demand)]
    for i, member in enumerate(scenario.agent_names + scenario.object_names):
        bound = member in start.grasps or (i < len(start.grasps) and start.grasps[i] is not None)
        if Start(member) in kept or bound or not any(member in members for members in speaking):
            continue
        for region in scenario.region_names:
            places = [*start.agents, *start.objects]
            if places[i] != region:
                places[i] = region
                n_agents = len(start.agents)
                yield State(tuple(places[:n_agents]), tuple(places[n_agents:]), start.grasps)
