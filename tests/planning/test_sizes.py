"""Sizes of automata and of what runs reach."""

from __future__ import annotations

from dataclasses import replace

import networkx as nx
import pytest

from drake_ltl.planning.automaton import buchi_size
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.graphs import transition_graph
from drake_ltl.planning.plan import State
from drake_ltl.planning.power import sum_rule
from drake_ltl.planning.sizes import automaton_sizes, reachable_size
from drake_ltl.planning.transition_system import form
from drake_ltl.scenario import load
from drake_ltl.scenario.formulas import global_formula


@pytest.fixture(scope="module")
def paper(examples):
    return load(examples / "case_ii.yaml")


START = State(("pi1", "pi3", "pi4"), ("pi2", "pi1"), (None, None, None))


@pytest.mark.parametrize("power", [6.0, 100.0])
def test_what_is_reached_is_what_networkx_reaches(paper, power):
    """Some states are never reached; with objects that nobody can lift most are not."""
    scenario = replace(paper, objects=tuple(replace(obj, power_needed=power) for obj in paper.objects))
    system = form(scenario, published_fits(scenario.fits), sum_rule(scenario))
    graph = transition_graph(system)
    reached = nx.descendants(graph, START) | {START}
    assert reachable_size(system, START) == (len(reached), sum(graph.out_degree(state) for state in reached))
    assert len(reached) < (system.n_states if power == 6.0 else 0.2 * system.n_states)


def test_nothing_is_reached_from_what_is_no_state(paper):
    """No region has room for three agents and two objects that are grasped."""
    system = form(paper, published_fits(paper.fits), sum_rule(paper))
    crowded = State(("pi1",) * 3, ("pi1",) * 2, ("o1", "o1", "o2"))
    assert system.index(crowded) < 0
    assert reachable_size(system, crowded) == (0, 0)


def test_automata(paper):
    alone = replace(
        paper,
        agents=tuple(replace(agent, spec="1") for agent in paper.agents),
        objects=tuple(replace(obj, spec="1") for obj in paper.objects),
    )
    visit = replace(alone, spec="GF a1.pi1")
    sizes = automaton_sizes(visit)
    assert sizes.searched == (1, 2)  # acceptance on edges: one state is enough
    assert sizes.buchi == buchi_size(global_formula(visit))
