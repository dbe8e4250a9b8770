"""From which initial states a plan exists at all, without looking for it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.automaton import Automaton, letters, tabulate, translate
from drake_ltl.planning.transition_system import TransitionSystem
from drake_ltl.scenario.formulas import global_formula
from drake_ltl.scenario.model import Scenario

MOST_EDGES = 30_000_000
"""Products with more edges are not formed: some 30 bytes each."""


def feasible_starts(scenario: Scenario, system: TransitionSystem) -> NDArray[np.bool_]:
    """Whether some run from each state satisfies the scenario's formulas.

    A run is a path of the product whose node (q, s) has an automaton in state q that is about to read the letter
    of s. It satisfies the formulas from where it can reach a strongly connected set whose edges meet every mark.

    Args:
        scenario: whose formulas are to be satisfied; members and regions are those of `system`.
        system: TS with S states.

    Returns:
        (S,)

    Raises:
        SearchLimitError: the product is too large.
    """
    automaton = translate(global_formula(scenario))
    names = [ap.ap_name() for ap in automaton.ap()]
    different, letter = letters(system, names)
    table = tabulate(automaton, names, different)
    n = system.n_states
    if table.n_states * system.n_transitions > MOST_EDGES:
        raise SearchLimitError(f"{table.n_states} x {system.n_transitions} transitions are too many to enumerate")
    sources, targets, marks = [], [], []
    read = letter[system.sources]
    for q in range(table.n_states):
        edge, choice = np.nonzero(table.successors[q][read] >= 0)
        sources.append(q * n + system.sources[edge])
        targets.append(table.successors[q, read[edge], choice] * n + system.targets[edge])
        marks.append(table.marks[q, read[edge], choice])
    winning = _winning(np.concatenate(sources), np.concatenate(targets), np.concatenate(marks), n, table)
    return winning[table.initial * n : (table.initial + 1) * n]


def _winning(sources: NDArray, targets: NDArray, marks: NDArray, n_system: int, table: Automaton) -> NDArray:
    """Which nodes reach a strongly connected set with all marks: a search backwards from all such sets at once."""
    n_nodes = n_system * table.n_states
    graph = csr_array((np.ones(len(sources)), (sources, targets)), shape=(n_nodes, n_nodes))
    n_components, component = connected_components(graph, connection="strong")
    inside = component[sources] == component[targets]
    collected = np.zeros(n_components, dtype=np.int64)
    np.bitwise_or.at(collected, component[sources[inside]], marks[inside])
    goals = np.flatnonzero((collected == table.full)[component])
    rows = np.concatenate([targets, np.full(len(goals), n_nodes)])
    columns = np.concatenate([sources, goals])
    backwards = csr_array((np.ones(len(rows)), (rows, columns)), shape=(n_nodes + 1, n_nodes + 1))
    found = np.zeros(n_nodes + 1, dtype=bool)
    found[breadth_first_order(backwards, n_nodes, return_predecessors=False)] = True
    return found[:n_nodes]
