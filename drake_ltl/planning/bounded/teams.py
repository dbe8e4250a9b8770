"""Who can carry an object along a way, and how few."""

from __future__ import annotations

from collections.abc import Sequence

from drake_ltl.planning.bounded.alone import Alone, Way
from drake_ltl.planning.bounded.problem import Problem


def can_go(problem: Problem, agents: Sequence[Alone | None], obj: int, way: Way) -> bool:
    """Whether those agents whose own formulas ever let them go a way can carry an object along it."""
    able = _able(problem, agents, way)
    if problem.strong_teams is not None:
        return any(team <= set(able) for team in problem.strong_teams[obj])
    return not problem.sum_rule or problem.carries(obj, able)


def least_team(problem: Problem, agents: Sequence[Alone | None], obj: int, way: Way) -> int:
    """The least number of agents that can carry an object along a way; 1 where that is not known.

    Args:
        problem: the problem.
        agents: what each agent can do alone (further members are ignored).
        obj: index of the object.
        way: from a region to another.
    """
    able = _able(problem, agents, way)
    if problem.strong_teams is not None:
        return min((len(team) for team in problem.strong_teams[obj] if team <= set(able)), default=1)
    if not problem.sum_rule:
        return 1
    strongest = sorted(able, key=lambda i: -problem.powers[0][i])
    sizes = range(1, len(able) + 1)
    return next((n for n in sizes if problem.carries(obj, strongest[:n])), 1)


def _able(problem: Problem, agents: Sequence[Alone | None], way: Way) -> list[int]:
    return [i for i, lone in enumerate(agents[: problem.n_agents]) if lone is None or way in lone.ways]
