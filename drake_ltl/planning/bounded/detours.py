"""Ways that the relaxation can do without, because a detour is as cheap and as good.

A way from a to b is needless for a member if for some k the ways a, k and k, b are both cheaper than it and together
no dearer, the member may go them, and its own automaton does not mind: from each state, reading k and b leads to
where reading b leads, meets at least the same marks, and none more that some clause forbids. For an object, moreover,
all agents that may go the way itself must be free to go the detour.

A solution of the relaxation (`counting`) that goes a needless way can go the detour instead, with the same bodies, at
no higher cost: balance, connection, teams and own formulas still hold. As both parts are cheaper, this comes to an
end. So leaving needless ways out does not change the minimum. (Where costs are squared distances, that is most ways.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from drake_ltl.planning.bounded.alone import Alone, Node, Step, Way
from drake_ltl.planning.bounded.problem import Problem


def needed_ways(problem: Problem, members: Sequence[Alone | None]) -> list[list[Way]]:
    """For each member the ways that are left, of those it may go; for an agent, free ways.

    Args:
        problem: the problem.
        members: from `lone_members`.
    """
    costs = problem.integer_ways(below=True)
    regions = range(problem.n_regions)
    every = frozenset((a, b) for a in regions for b in regions if a != b)
    may = [every if lone is None else lone.ways for lone in members]
    found = []
    for member, lone in enumerate(members):
        reads = {} if lone is None else {(step.source, step.target[0]): step for step in lone.steps}
        carriers = may[: problem.n_agents] if member >= problem.n_agents else []

        def is_as_good(a: int, k: int, b: int, member=member, lone=lone, reads=reads, carriers=carriers) -> bool:
            detour = {(a, k), (k, b)}
            if not detour <= may[member] or any((a, b) in ways and not detour <= ways for ways in carriers):
                return False
            return lone is None or all(_minds_not(lone, reads, node, k, b) for node in lone.nodes if node[0] == a)

        def is_needless(a: int, b: int, is_as_good=is_as_good) -> bool:
            return any(
                max(costs[a][k], costs[k][b]) < costs[a][b]
                and costs[a][k] + costs[k][b] <= costs[a][b]
                and is_as_good(a, k, b)
                for k in regions
                if k not in (a, b)
            )

        found.append([way for way in sorted(may[member]) if not is_needless(*way)])
    return found


def _minds_not(lone: Alone, reads: dict[tuple[Node, int], Step], node: Node, k: int, b: int) -> bool:
    """Whether a member's automaton takes the detour over k for the way to b, if it takes that at all."""
    direct, first = reads.get((node, b)), reads.get((node, k))
    if direct is None:
        return True
    second = None if first is None else reads.get((first.target, b))
    if first is None or second is None or second.target != direct.target:
        return False
    marks = first.marks | second.marks
    return direct.marks <= marks and not any((marks - direct.marks) & clause.never for clause in lone.clauses)


def without_ways(lone: Alone | None, ways: Sequence[Way]) -> Alone | None:
    """What a member can do alone along some of its ways."""
    if lone is None:
        return None
    kept = {*ways, *((k, k) for k, _ in lone.nodes)}
    return replace(lone, steps=tuple(s for s in lone.steps if (s.source[0], s.target[0]) in kept))
