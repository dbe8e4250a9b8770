"""Contents that do not fit, found on a lasso and generalised to cuts.

P_s is taken to be monotone: what does not fit with fewer bodies does not fit with more. Where a predicate is not,
some lassos are not found; those that are found are still checked by the predicate itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice, pairwise, permutations

from drake_ltl.planning.bounded.cuts import Cut, WeakTeam
from drake_ltl.planning.bounded.problem import Problem, Run
from drake_ltl.planning.fits import Content, Fits, content_of, published_fits
from drake_ltl.planning.plan import State
from drake_ltl.scenario.model import PublishedFits

_MOST_NAMES = 400
"""So many other names are tried in a content that does not fit."""


@dataclass
class Refusals:
    """All cuts found so far."""

    problem: Problem
    fits: Fits
    cuts: list[Cut] = field(default_factory=list)
    weak: list[WeakTeam] = field(default_factory=list)
    _answers: dict[tuple[int, Content], bool] = field(default_factory=dict)

    def find(self, run: Run) -> bool:
        """Add what forbids a lasso; whether anything does, be it found before or now."""
        states, loop = run
        for state, after in pairwise((*states, states[loop])):
            self.weak += self._weak_teams(state, after)
            for region, content in self._contents(state, after):
                if not any(cut.region == region and _within(cut.content, content) for cut in self.cuts):
                    self._find_cuts(region, content)
        return not self.allows(run)

    def allows(self, run: Run) -> bool:
        """Whether all contents of a lasso fit and all teams are strong enough; nothing is learnt from it."""
        states, loop = run
        return all(self.allows_step(*step) for step in pairwise((*states, states[loop])))

    def allows_step(self, before: State, after: State) -> bool:
        """Whether all contents before and after a step fit, and its teams are strong enough."""
        return (
            not self._weak_teams(before, after)
            and all(self._fits(region, content) for region, content in self._contents(before, after))
            and all(self._fits(region, content) for region, content in self._contents(after, after))
        )

    def _contents(self, before: State, after: State) -> Iterator[tuple[int, Content]]:
        """What stands in each region before a step, as it leaves and as it arrives."""
        problem = self.problem
        moved = [
            (obj, a, b)
            for obj, a, b in zip(problem.scenario.object_names, before.objects, after.objects, strict=True)
            if a != b
        ]
        for k, region in enumerate(problem.scenario.region_names):
            yield k, content_of(problem.scenario, before, region)
            leaves = frozenset(obj for obj, start, _ in moved if start == region)
            arrives = frozenset(obj for obj, _, goal in moved if goal == region)
            for state, carried in ((before, leaves), (after, arrives)):
                if carried:
                    yield k, content_of(problem.scenario, state, region, carried)

    def _weak_teams(self, before: State, after: State) -> list[WeakTeam]:
        found = []
        for j, (start, goal) in enumerate(zip(before.objects, after.objects, strict=True)):
            name = self.problem.scenario.object_names[j]
            team = frozenset(i for i, grasp in enumerate(before.grasps) if grasp == name)
            if start != goal and not self.problem.carries(j, team):
                found.append(WeakTeam(j, team))
        return found

    def _find_cuts(self, region: int, content: Content) -> None:
        if self._fits(region, content):
            return
        core = self._core(region, content)
        for renamed in self._renamed(core):
            for k in range(self.problem.n_regions):
                cut = Cut(k, renamed)
                if cut not in self.cuts and not self._fits(k, renamed):
                    self.cuts.append(cut)

    def _fits(self, region: int, content: Content) -> bool:
        if (region, content) not in self._answers:
            empty = not (content.free_agents or content.objects)
            self._answers[region, content] = empty or self.fits(self.problem.scenario.regions[region], content)
        return self._answers[region, content]

    def _core(self, region: int, content: Content) -> Content:
        """The content without all that it does not need in order to be refused."""
        smaller = next((less for less in _with_less(content) if not self._fits(region, less)), None)
        return content if smaller is None else self._core(region, smaller)

    def _renamed(self, content: Content) -> Iterator[Content]:
        """The content itself, then with other agents."""
        yield content
        agents = (*content.free_agents, *(agent for agent, _ in content.holds))
        for others in islice(permutations(self.problem.scenario.agent_names, len(agents)), _MOST_NAMES):
            to = dict(zip(agents, others, strict=True))
            order = self.problem.scenario.agent_names.index
            yield replace(
                content,
                free_agents=tuple(sorted((to[a] for a in content.free_agents), key=order)),
                holds=tuple(sorted(((to[a], obj) for a, obj in content.holds), key=lambda hold: order(hold[0]))),
            )


def counting_rule(problem: Problem, fits: Fits) -> PublishedFits | None:
    """The scenario's published rule, if the predicate answers as it does wherever it is asked."""
    rule, scenario = problem.scenario.fits, problem.scenario
    if rule is None:
        return None
    published, agents, objects = published_fits(rule), scenario.agent_names, scenario.object_names
    if fits == published:
        return rule
    for free in range(len(agents) + 1):
        for holding in range(len(agents) - free + 1 if objects else 1):
            for placed in range(int(holding > 0), len(objects) + 1):
                holds = tuple((agent, objects[0]) for agent in agents[free : free + holding])
                content = Content(agents[:free], objects[:placed], holds)
                if any(fits(region, content) != published(region, content) for region in scenario.regions):
                    return None
    return rule


def _within(less: Content, more: Content) -> bool:
    return (
        set(less.free_agents) <= set(more.free_agents)
        and set(less.objects) <= set(more.objects)
        and set(less.holds) <= set(more.holds)
        and less.carried <= more.carried
    )


def _with_less(content: Content) -> Iterator[Content]:
    """The content with one body less, or with one object not carried."""
    for agent in content.free_agents:
        yield replace(content, free_agents=_without(content.free_agents, agent))
    for hold in content.holds:
        yield replace(content, holds=_without(content.holds, hold))
    for obj in content.objects:
        if obj in content.carried:
            yield replace(content, carried=content.carried - {obj})
        elif all(held != obj for _, held in content.holds):
            yield replace(content, objects=_without(content.objects, obj))


def _without(items: Sequence, item: object) -> tuple:
    return tuple(other for other in items if other != item)
