"""How far regions are too full, estimated without steps."""

from __future__ import annotations

from collections.abc import Sequence

from drake_ltl.planning.bounded.errands import Agenda
from drake_ltl.planning.bounded.problem import Problem
from drake_ltl.scenario.model import PublishedFits


class Crowding:
    """Weights by a counting rule, if errands are done one after the other (`timetable`, `together=False`)."""

    def __init__(self, problem: Problem, rule: PublishedFits):
        self._problem, self._rule = problem, rule

    def excess(self, agenda: Agenda, meetings: Sequence[int]) -> float:
        """What is too much where an object leaves or arrives, in agents, summed over all transports.

        Args:
            agenda: the errands.
            meetings: where each agent is when the suffix begins.
        """
        rule, n = self._rule, self._problem.n_agents
        at, total = list(self._problem.starts), 0.0
        weight = [0.0] * self._problem.n_regions
        for m, k in enumerate(at):
            weight[k] += rule.agent if m < n else rule.object
        for errands in agenda:
            for errand in errands:
                for i in errand.team:
                    weight[at[i]] -= rule.agent
                    weight[errand.start] += rule.agent
                    at[i] = errand.goal
                if errand.object is None:
                    continue
                here = weight[errand.start] + len(errand.team) * (rule.grasping - rule.agent)
                weight[errand.start] -= len(errand.team) * rule.agent + rule.object
                there = weight[errand.goal] + len(errand.team) * rule.grasping + rule.object
                weight[errand.goal] += len(errand.team) * rule.agent + rule.object
                total += max(0.0, here - rule.capacity) + max(0.0, there - rule.capacity)
            for i, meeting in enumerate(meetings):
                if meeting != at[i]:
                    weight[at[i]] -= rule.agent
                    weight[meeting] += rule.agent
                    at[i] = meeting
        return total / rule.agent if rule.agent else total
