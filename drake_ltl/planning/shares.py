"""The cheapest loop with all marks, looked for only where it can begin and pass.

Of each node it is known that no loop that begins there lies below some bound. First all loops below the limit are
looked at together, in the few nodes that they can use. Where their layers (`layers`) are too many, the loops are
shared out by where they begin: the share with the least bound is looked at next, up to a limit a little above it. If
these are still too many, the step to the limit is made smaller, and at last the share divided.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from itertools import count

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.layers import Priced
from drake_ltl.planning.loops import LoopProblem, cheapest_loop, split
from drake_ltl.planning.marks import Features

FIRST_STEP, LEAST_STEP = 1 / 16, 1 / 64
"""Parts of the limit by which a share is searched beyond its bound, at first and before it is divided."""
MOST_LOOKS, MOST_FAILURES = 600, 40
"""The search is given up after so many looks at shares, and after so many at what is too much."""


@dataclass(frozen=True)
class LeastLoop:
    """What is known of the cheapest loop below a limit."""

    nodes: list[int]
    """Of the part, the first one at the end too; empty if no loop is known."""
    weight: float
    """Price + weight; the limit if no loop is known."""
    bound: float
    """No loop has less; equal to `weight` if the search came to its end."""


def least_loop(priced: Priced, features: Features, limit: float, most_edges: int) -> LeastLoop:
    """The cheapest loop below a limit.

    Args:
        priced: marks of a part, with prices.
        features: of nodes of the product, for `LoopProblem`.
        limit: loops of this price + weight or more are not looked for.
        most_edges: of the layers that are looked at together.
    """
    look = _Look(priced, features, most_edges)
    found = look.at(np.arange(len(priced.prices)), limit)
    return look.share_out(limit) if found is None else LeastLoop(*found, found[1])


def layered_loop(priced: Priced, features: Features, limit: float, most_edges: int) -> tuple[list[int], float] | None:
    """The cheapest loop below a limit and its price + weight, ([], limit) if there is none; arguments as for
    `least_loop`.

    Returns:
        None if the layers have more edges.
    """
    many = len(priced.prices) * (priced.marks.full + 1) > most_edges
    layers = None if many else priced.layers(limit, most_edges)
    if layers is None:
        return None
    roots = np.flatnonzero((layers.first >= 0) & (layers.last >= 0) & (priced.prices < limit))
    if not len(roots):
        return [], limit
    rows = features(priced.marks.part.nodes[roots])
    problem = LoopProblem(layers.graph, layers.first[roots], layers.last[roots, None], rows)
    loop = cheapest_loop(problem, priced.prices[roots], limit)
    return ([], limit) if loop is None else (layers.nodes[list(loop.nodes)].tolist(), loop.weight)


@dataclass(frozen=True, eq=False)
class _Look:
    priced: Priced
    features: Features
    most_edges: int

    def at(self, roots: NDArray, limit: float) -> tuple[list[int], float] | None:
        """The cheapest loop that begins in one of some nodes; as `layered_loop`."""
        priced, nodes = self.priced.within(roots, limit)
        if not np.isfinite(priced.prices).any():
            return [], limit
        found = layered_loop(priced, self.features, limit, self.most_edges)
        return None if found is None else (nodes[found[0]].tolist() if found[0] else [], found[1])

    def share_out(self, limit: float) -> LeastLoop:
        """The cheapest loop, share by share."""
        bounds = self.priced.bounds
        best, ticket = LeastLoop([], limit, limit), count()
        low = float(bounds.min())
        queue = [(low, next(ticket), np.flatnonzero(np.isfinite(self.priced.prices)), limit * FIRST_STEP)]
        looks = failures = 0
        while looks < MOST_LOOKS and failures <= MOST_FAILURES:
            looks += 1
            if not queue or queue[0][0] >= best.weight:
                return LeastLoop(best.nodes, best.weight, best.weight)
            low, _, roots, step = heapq.heappop(queue)
            roots = roots[bounds[roots] < best.weight]
            if not len(roots):
                continue
            goal = min(low + np.ceil(step), best.weight)
            found = self.at(roots, goal)
            failures += found is None
            if found is not None and found[0]:
                best = LeastLoop(*found, found[1])
            elif found is not None:
                heapq.heappush(queue, (goal, next(ticket), roots, 1.5 * step))
            elif step > limit * LEAST_STEP or len(roots) == 1:
                heapq.heappush(queue, (low, next(ticket), roots, step / 4.0))
            else:
                for part in self._divided(roots):
                    bound = max(low, float(bounds[part].min()))
                    heapq.heappush(queue, (bound, next(ticket), part, limit * FIRST_STEP))
        return LeastLoop(best.nodes, best.weight, min([best.weight, *(share[0] for share in queue)]))

    def _divided(self, roots: NDArray) -> list[NDArray]:
        """Smaller shares."""
        rows = self.features(self.priced.marks.part.nodes[roots])
        other = int(np.flatnonzero((rows != rows[0]).any(axis=1))[0])
        return [roots[part] for part in split(rows, np.arange(len(roots)), 0, other)]
