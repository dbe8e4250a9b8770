"""Plans, automata, TS and the product in forms that other tools read: DOT, HOA, networkx."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from functools import cache

import networkx as nx
import numpy as np
import pydot

from drake_ltl.errors import InfeasibleError, SearchLimitError
from drake_ltl.planning.automaton import Automaton, joint, letters
from drake_ltl.planning.conjunction import propositions_of, tabulate_all, translate_each
from drake_ltl.planning.plan import Plan, State
from drake_ltl.planning.table import action_text
from drake_ltl.planning.transition_system import TransitionSystem
from drake_ltl.scenario.formulas import global_formula
from drake_ltl.scenario.model import Scenario

MOST_EDGES = 200_000
"""Larger graphs are refused unless asked for: networkx takes about a kilobyte for each edge."""


def plan_dot(plan: Plan, scenario: Scenario) -> str:
    """The plan as a lasso in Graphviz's language: a node per state, an edge per step with its number and actions.

    States of the suffix have double borders.
    """
    graph = pydot.Dot("plan", rankdir="TB")
    graph.set_node_defaults(shape="box", fontname="Helvetica")
    graph.set_edge_defaults(fontname="Helvetica")
    for number, state in enumerate(plan.states, start=1):
        borders = 2 if number > plan.loop else 1
        graph.add_node(pydot.Node(f"s{number}", label=state_text(state, scenario), peripheries=borders))
    for number, actions in enumerate(plan.moves, start=1):
        following = number + 1 if number < len(plan.states) else plan.loop + 1
        label = "\n".join([f"step {number}", *(map(action_text, actions) if actions else ["all wait"])])
        graph.add_edge(pydot.Edge(f"s{number}", f"s{following}", label=label))
    return graph.to_string()


def state_text(state: State, scenario: Scenario) -> str:
    """Where everybody is, such as `a1 pi1, a2 pi3[o2]` and below it `o1 pi2, o2 pi3`."""
    grasping = zip(scenario.agent_names, state.agents, state.grasps, strict=True)
    agents = [f"{name} {region}" + (f"[{held}]" if held else "") for name, region, held in grasping]
    objects = [f"{name} {region}" for name, region in zip(scenario.object_names, state.objects, strict=True)]
    return "\n".join(", ".join(part) for part in (agents, objects) if part)


def automaton_hoa(scenario: Scenario) -> str:
    """The automaton of the global formula in the Hanoi Omega-Automata format, over propositions `m.p`.

    Deterministic, with any acceptance, on transitions: the planner searches what of it the letters of TS reach.
    """
    formula = global_formula(scenario)
    automaton = joint(formula)
    automaton.set_name(formula)
    return automaton.to_str("hoa") + "\n"


def transition_graph(system: TransitionSystem, *, most_edges: int = MOST_EDGES) -> nx.DiGraph:
    """TS of Def. 5: nodes are `State`s, edges have `cost` (chi) and `actions` (how many agents act).

    Raises:
        SearchLimitError: there are more than `most_edges` transitions.
    """
    if system.n_transitions > most_edges:
        raise _too_large("TS", f"{system.n_transitions} transitions", most_edges)
    states = [system.state(index) for index in range(system.n_states)]
    graph = nx.DiGraph()
    graph.add_nodes_from(states)
    columns = (system.sources, system.targets, system.costs, system.actions)
    for source, target, cost, actions in zip(*(column.tolist() for column in columns), strict=True):
        graph.add_edge(states[source], states[target], cost=cost, actions=actions)
    return graph


def product_graph(system: TransitionSystem, start: State, *, most_edges: int = MOST_EDGES) -> nx.DiGraph:
    """The part of TS x automaton that runs from `start` reach.

    A node (state, q) says that TS is in a state whose letter has just brought the automaton to q. Edges have
    `cost` and `marks`, a frozenset of numbers. The graph's attributes are `initial`, a tuple of nodes, and `clauses`:
    a run is accepting if the marks that it meets again and again satisfy one of them (`acceptance.Clause`).

    Args:
        system: TS; its scenario's formulas are those of the automaton.
        start: the initial state.
        most_edges: of the product.

    Raises:
        InfeasibleError: `start` is no state of TS.
        SearchLimitError: there are more than `most_edges` edges.
    """
    first = system.index(start)
    if first < 0:
        raise InfeasibleError(f"the initial state is impossible: {start}")
    automata = translate_each(global_formula(system.scenario))
    names = propositions_of(automata)
    different, letter = letters(system, names)
    return _Product(system, tabulate_all(automata, names, different), letter).reachable(first, most_edges)


class _Product:
    """Successors of product nodes, and what they are called."""

    def __init__(self, system: TransitionSystem, automaton: Automaton, letter: np.ndarray):
        self._system, self._automaton, self._letter = system, automaton, letter
        self._state = cache(system.state)
        self._rows = np.searchsorted(system.sources, np.arange(system.n_states + 1))

    def reachable(self, first: int, most_edges: int) -> nx.DiGraph:
        begins = self._read(self._automaton.initial, first)
        initial = [] if begins is None else [(first, begins[0])]
        graph = nx.DiGraph(initial=tuple(map(self._node, initial)), clauses=self._automaton.clauses)
        graph.add_nodes_from(map(self._node, initial))
        seen, queue = set(initial), deque(initial)
        while queue:
            source = queue.popleft()
            node = self._node(source)
            for state, cost in self._transitions(source[0]):
                read = self._read(source[1], state)
                if read is None:
                    continue
                q, marks = read
                graph.add_edge(node, self._node((state, q)), cost=cost, marks=_marks(marks))
                if (state, q) not in seen:
                    seen.add((state, q))
                    queue.append((state, q))
            if graph.number_of_edges() > most_edges:
                raise _too_large("the product", f"more than {most_edges} edges", most_edges)
        return graph

    def _transitions(self, state: int) -> Iterator[tuple[int, float]]:
        """Targets and costs of the transitions of TS from a state."""
        own = slice(self._rows[state], self._rows[state + 1])
        return zip(self._system.targets[own].tolist(), self._system.costs[own].tolist(), strict=True)

    def _read(self, q: int, state: int) -> tuple[int, int] | None:
        """The automaton's (state, marks) after it has read the letter of a state of TS; None if it cannot."""
        letter = self._letter[state]
        target = int(self._automaton.successors[q, letter])
        return (target, int(self._automaton.marks[q, letter])) if target >= 0 else None

    def _node(self, pair: tuple[int, int]) -> tuple[State, int]:
        return self._state(pair[0]), pair[1]


def _marks(mask: int) -> frozenset[int]:
    return frozenset(mark for mark in range(mask.bit_length()) if mask >> mark & 1)


def _too_large(what: str, size: str, most_edges: int) -> SearchLimitError:
    return SearchLimitError(
        f"{what} has {size}; as a networkx graph it may have {most_edges} (raise `most_edges` if memory allows)"
    )
