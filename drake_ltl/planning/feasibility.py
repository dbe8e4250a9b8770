"""From which initial states a plan exists at all, without looking for it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.automaton import letters, tabulate, translate
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
    counts, targets, marks = [], [], []
    read = letter[system.sources]
    for q in range(table.n_states):
        edge, choice = np.nonzero(table.successors[q][read] >= 0)
        counts.append(np.bincount(system.sources[edge], minlength=n))
        targets.append(table.successors[q, read[edge], choice].astype(np.int32) * n + system.targets[edge])
        marks.append(table.marks[q, read[edge], choice])
    rows = np.concatenate([[0], np.cumsum(np.concatenate(counts))]).astype(np.int32)
    winning = _winning(rows, np.concatenate(targets).astype(np.int32), np.concatenate(marks), table.full)
    return winning[table.initial * n : (table.initial + 1) * n]


def _winning(rows: NDArray, targets: NDArray, marks: NDArray, full: int) -> NDArray[np.bool_]:
    """Which nodes reach a strongly connected set with all marks: a search backwards from all such sets at once.

    Args:
        rows: (n + 1,), the edges of node i are rows[i] .. rows[i + 1].
        targets: (e,)
        marks: (e,)
        full: all marks.
    """
    n_nodes = len(rows) - 1
    graph = csr_array((np.ones(len(targets)), targets, rows), shape=(n_nodes, n_nodes))
    n_components, component = connected_components(graph, connection="strong")
    of_source = np.repeat(component, np.diff(rows))
    inside = of_source == component[targets]
    collected = np.zeros(n_components, dtype=np.int64)
    for mark in np.unique(marks).tolist():
        collected[of_source[inside & (marks == mark)]] |= mark
    goals = np.flatnonzero((collected == full)[component])
    return _reaching(graph, goals)


def _reaching(graph: csr_array, goals: NDArray) -> NDArray[np.bool_]:
    """Which nodes reach any of some goals: those that one more node finds, with edges to all goals, backwards."""
    n_nodes = graph.shape[0]
    backwards = graph.T.tocsr()
    rows = np.append(backwards.indptr, len(backwards.indices) + len(goals)).astype(np.int32)
    columns = np.concatenate([backwards.indices, goals]).astype(np.int32)
    extended = csr_array((np.ones(len(columns)), columns, rows), shape=(n_nodes + 1, n_nodes + 1))
    found = np.zeros(n_nodes + 1, dtype=bool)
    found[breadth_first_order(extended, n_nodes, return_predecessors=False)] = True
    return found[:n_nodes]
