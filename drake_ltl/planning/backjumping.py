"""Search for values of a few variables with finite lists of values, subject to constraints.

Conflict-directed backjumping: when every value of a variable is ruled out, the search returns to the latest
variable that had a part in it. All values of a variable are tried at once, as arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_ltl.planning.spheres import GOOD_SPACING, Array

Value = int | NDArray[np.intp]
Assignment = list[Value]
"""Value of each variable: an index, or for one variable the array of all its indices. Unset ones hold -1."""


@dataclass(frozen=True)
class Constraint:
    """`slack` must not be negative. Constraints are considered in the order of `step`."""

    scope: frozenset[int]
    slack: Callable[[Assignment], Array]
    """Slack [m] at an assignment of all variables in scope, broadcast over the one that holds an array."""
    step: int
    text: str
    """What is wrong where it does not hold."""
    region: str = ""
    """Where that is."""
    bodies: frozenset[str] = frozenset()
    """Who is concerned."""
    spacing: bool = True
    """Whether slack beyond what is needed is worth something."""


@dataclass(frozen=True)
class Cost:
    """A term of what is made small."""

    scope: frozenset[int]
    value: Callable[[Assignment], Array]


class DeadEndError(Exception):
    """No values satisfy all constraints, or none were found.

    `reasons` are the constraints that ruled out all values in the try that got furthest, the last one last.
    """

    def __init__(self, reasons: Sequence[Constraint]):
        self.reasons = tuple(reasons)
        super().__init__("; ".join(dict.fromkeys(reason.text for reason in reasons)))


@dataclass
class Search:
    """A problem: numbers of values, constraints and costs of variables that are set in the order given."""

    sizes: Sequence[int]
    constraints: Sequence[Constraint]
    costs: Sequence[Cost]
    spacing_weight: float = 4.0
    """What a metre of spacing is worth, in units of the costs."""
    effort: int = 3000
    """Number of variables looked at before the search gives up."""

    def __post_init__(self) -> None:
        count = len(self.sizes)
        ordered = sorted(self.constraints, key=lambda constraint: constraint.step)
        self._of = [[c for c in ordered if v in c.scope] for v in range(count)]
        self._closed_by = [[c for c in self._of[v] if max(c.scope) == v] for v in range(count)]
        self._costs_of = [[c for c in self.costs if v in c.scope] for v in range(count)]
        self._fixed = [c for c in ordered if not c.scope]

    def solve(self) -> list[int]:
        """Values that satisfy all constraints, of small cost; DeadEndError if none are found."""
        for constraint in self._fixed:
            if float(constraint.slack([])) < 0.0:
                raise DeadEndError([constraint])
        return self._improve(self._backjump())

    def _backjump(self) -> list[int]:
        count = len(self.sizes)
        values: Assignment = [-1] * count
        untried: list[Iterator[int]] = []
        blame: list[set[int]] = []
        furthest: list[Constraint] = []
        effort = 0
        while len(untried) < count:
            variable = len(untried)
            good, culprits, reasons = self._survey(variable, values)
            untried.append(iter(good))
            blame.append(culprits)
            if not good and (not furthest or reasons[-1].step > furthest[-1].step):
                furthest = reasons
            effort += 1
            while (value := next(untried[-1], None)) is None:
                culprits = blame[-1]
                if not culprits or effort > self.effort:
                    raise DeadEndError(furthest)
                target = max(culprits)
                for later in range(target + 1, len(untried)):
                    values[later] = -1
                del untried[target + 1 :], blame[target + 1 :]
                blame[target] |= culprits - {target}
            values[len(untried) - 1] = value
        return [int(value) for value in values]

    def _survey(self, variable: int, values: Assignment) -> tuple[list[int], set[int], list[Constraint]]:
        """The variable's values in the order to try them, the variables that rule out others, and the constraints
        by which they do."""
        values[variable] = np.arange(self.sizes[variable])
        alive = np.ones(self.sizes[variable], dtype=bool)
        spacing = np.full(self.sizes[variable], GOOD_SPACING)
        culprits: set[int] = set()
        reasons: list[Constraint] = []
        for constraint in self._closed_by[variable]:
            slack = constraint.slack(values)
            failing = alive & (slack < 0.0)
            if failing.any():
                culprits |= constraint.scope - {variable}
                reasons.append(constraint)
                alive &= ~failing
                if not alive.any():
                    return [], culprits, reasons
            if constraint.spacing:
                spacing = np.minimum(spacing, slack)
        known = [c for c in self._costs_of[variable] if max(c.scope) <= variable]
        cost = self._cost(known, values, spacing)
        best_first = np.argsort(np.where(alive, cost, np.inf), kind="stable")[: int(alive.sum())]
        return [int(best_first[k]) for k in _spread(len(best_first))], culprits, reasons

    def _cost(self, terms: Sequence[Cost], values: Assignment, spacing: Array) -> Array:
        total = self.spacing_weight * (GOOD_SPACING - spacing)
        for term in terms:
            total = total + term.value(values)
        return total

    def _improve(self, solution: list[int], rounds: int = 2) -> list[int]:
        """Give each variable in turn its best value, the others fixed."""
        values: Assignment = list(solution)
        for _ in range(rounds):
            before = list(values)
            for variable, size in enumerate(self.sizes):
                if size == 1:
                    continue
                current = values[variable]
                values[variable] = np.arange(size)
                alive = np.ones(size, dtype=bool)
                spacing = np.full(size, GOOD_SPACING)
                for constraint in self._of[variable]:
                    slack = constraint.slack(values)
                    alive &= slack >= 0.0
                    if constraint.spacing:
                        spacing = np.minimum(spacing, slack)
                cost = np.where(alive, self._cost(self._costs_of[variable], values, spacing), np.inf)
                best = int(np.argmin(cost))
                values[variable] = best if cost[best] < cost[current] - 1e-9 else current
            if values == before:
                break
        return [int(value) for value in values]


def _spread(count: int) -> list[int]:
    """0 .. count - 1, the first first and then ever finer: values alike in cost mostly fail alike."""
    bits = max(count - 1, 1).bit_length()
    reversed_bits = (int(f"{k:0{bits}b}"[::-1], 2) for k in range(1 << bits))
    return [k for k in reversed_bits if k < count]
