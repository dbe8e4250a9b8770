"""How large a problem is: its automata, its transition system, and what of that a run can reach."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.automaton import buchi_size, joint
from drake_ltl.planning.counts import BUCHI_TIME
from drake_ltl.planning.plan import State
from drake_ltl.planning.transition_system import TransitionSystem
from drake_ltl.scenario.formulas import global_formula
from drake_ltl.scenario.model import Scenario


@dataclass(frozen=True)
class AutomatonSizes:
    """Of the global formula's automata."""

    buchi: tuple[int, int] | None
    """States and edges of BA as `automaton.buchi_size` counts them; None if it takes long to make."""
    searched: tuple[int, int] | None
    """States and edges of the deterministic one, of which the planner searches what the letters of TS reach; None if it
    is too large."""


def automaton_sizes(scenario: Scenario) -> AutomatonSizes:
    """Translates the global formula twice."""
    formula = global_formula(scenario)
    try:
        made = joint(formula)
        searched = made.num_states(), made.num_edges()
    except SearchLimitError:
        searched = None
    try:
        buchi = buchi_size(formula, BUCHI_TIME)
    except (TimeoutError, SearchLimitError):
        buchi = None
    return AutomatonSizes(buchi, searched)


def reachable_size(system: TransitionSystem, start: State) -> tuple[int, int]:
    """States and transitions of TS that runs from `start` meet; (0, 0) if it is no state of TS."""
    first = system.index(start)
    if first < 0:
        return 0, 0
    n = system.n_states
    graph = csr_array((np.ones(system.n_transitions, dtype=bool), (system.sources, system.targets)), shape=(n, n))
    found = np.zeros(n, dtype=bool)
    found[breadth_first_order(graph, first, return_predecessors=False)] = True
    return int(found.sum()), int(found[system.sources].sum())
