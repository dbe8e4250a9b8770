"""From which initial states a plan exists at all, without looking for it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.automaton import Automaton, letters
from drake_ltl.planning.conjunction import propositions_of, tabulate_all, translate_each
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
    automata = translate_each(global_formula(scenario))
    names = propositions_of(automata)
    different, letter = letters(system, names)
    table = tabulate_all(automata, names, different)
    n = system.n_states
    if table.n_states * system.n_transitions > MOST_EDGES:
        raise SearchLimitError(f"{table.n_states} x {system.n_transitions} transitions are too many to enumerate")
    whole = _product(system, letter, table)
    goals = np.zeros(whole.shape[0], dtype=bool)
    for rules in table.for_loops():
        loops = whole if rules is table else _product(system, letter, rules)
        goals |= _on_accepting_loops(loops, rules, letter)
    winning = _reaching(whole, np.flatnonzero(goals))
    return winning[table.initial * n : (table.initial + 1) * n]


def _product(system: TransitionSystem, letter: NDArray, automaton: Automaton) -> csr_array:
    """The graph of nodes q S + s: the automaton in state q is about to read the letter of s."""
    n, read = system.n_states, letter[system.sources]
    counts, targets = [], []
    for q in range(automaton.n_states):
        edge = np.flatnonzero(automaton.successors[q][read] >= 0)
        counts.append(np.bincount(system.sources[edge], minlength=n))
        targets.append(automaton.successors[q][read[edge]].astype(np.int32) * n + system.targets[edge])
    rows = np.concatenate([[0], np.cumsum(np.concatenate(counts))]).astype(np.int32)
    columns = np.concatenate(targets).astype(np.int32)
    n_nodes = n * automaton.n_states
    return csr_array((np.ones(len(columns)), columns, rows), shape=(n_nodes, n_nodes))


def _on_accepting_loops(graph: csr_array, automaton: Automaton, letter: NDArray) -> NDArray[np.bool_]:
    """Which nodes lie in strongly connected sets with all marks. All edges of a node carry the marks of its letter."""
    n_components, component = connected_components(graph, connection="strong")
    sources = np.repeat(np.arange(graph.shape[0]), np.diff(graph.indptr))
    inside = component[sources] == component[graph.indices]
    marks = automaton.marks[:, letter].reshape(-1)
    collected = np.zeros(n_components, dtype=np.int64)
    np.bitwise_or.at(collected, component[sources[inside]], marks[sources[inside]])
    return (collected == automaton.full)[component]


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
