"""A mixed-integer program under construction: numbers, literals, flows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from datetime import timedelta
from typing import Any

from ortools.math_opt.python import mathopt


class Program:
    """A thin layer over MathOpt."""

    def __init__(self):
        self._model = mathopt.Model()

    def number(self) -> Any:
        """At least zero."""
        return self._model.add_variable(lb=0.0)

    def share(self) -> Any:
        """Between zero and one."""
        return self._model.add_variable(lb=0.0, ub=1.0)

    def literal(self) -> Any:
        """Zero or one."""
        return self._model.add_binary_variable()

    def add(self, constraint: Any) -> None:
        """A linear constraint; one without variables that holds is left out."""
        if constraint is not True:
            self._model.add_linear_constraint(constraint)

    def add_path(self, flow: Mapping[tuple[Any, Any], Any], sources: Mapping, sinks: Mapping) -> None:
        """A flow along edges from sources to sinks: at each node, what leaves less what enters."""
        nodes = {node for ends in flow for node in ends} | set(sources) | set(sinks)
        balance: dict[Any, list[Any]] = {node: [] for node in nodes}
        for (a, b), number in flow.items():
            balance[a].append(number)
            balance[b].append(-number)
        for node, terms in balance.items():
            self.add(total(terms) == total([sources.get(node, 0.0)]) - sinks.get(node, 0.0))

    def least(self, objective: Iterable[Any], seconds: float) -> tuple[float, bool]:
        """What the solver (SCIP) proves the objective to be at least, up to its tolerance, and whether it can be."""
        self._model.minimize(total(objective))
        parameters = mathopt.SolveParameters(time_limit=timedelta(seconds=max(seconds, 0.01)))
        # Not interrupted, because MathOpt's handler for SCIP writes errors to the terminal then (OR-Tools 9.15).
        result = mathopt.solve(self._model, mathopt.SolverType.GSCIP, params=parameters, remove_names=True)
        dual = result.termination.objective_bounds.dual_bound
        done = result.termination.reason == mathopt.TerminationReason.OPTIMAL
        return dual if math.isfinite(dual) else 0.0, done


def total(terms: Iterable[Any]) -> Any:
    """The sum of variables and numbers."""
    return mathopt.LinearSum(terms)
