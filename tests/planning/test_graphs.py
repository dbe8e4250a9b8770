"""What other tools read says what the plan, the automaton, TS and the product are."""

from __future__ import annotations

import json
import warnings
from itertools import pairwise

import networkx as nx
import pydot
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_ltl.errors import InfeasibleError, SearchLimitError
from drake_ltl.planning.certificate import transition_fault
from drake_ltl.planning.costs import sum_of_ways
from drake_ltl.planning.feasibility import feasible_starts
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.graphs import automaton_hoa, plan_dot, product_graph, transition_graph
from drake_ltl.planning.outputs import write_outputs
from drake_ltl.planning.plan import State
from drake_ltl.planning.plan_reader import plan_from_json
from drake_ltl.planning.planner import plan
from drake_ltl.planning.power import sum_rule
from drake_ltl.planning.transition_system import form
from drake_ltl.scenario.formulas import global_formula
from drake_ltl.spot_support import require_spot

TWO = {f"r{k}": (10.0 * k, 0.0, 0.0) for k in range(2)}


def anything_fits(region, content):
    return True


@pytest.fixture(scope="module")
def planned(case_i):
    scenario, start = case_i
    return plan(scenario, start, published_fits(scenario.fits)), scenario


def system_of(scenario, fits=None):
    return form(scenario, fits or published_fits(scenario.fits), sum_rule(scenario))


# DOT


def read_dot(text):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of the parser that pydot uses
        (graph,) = pydot.graph_from_dot_data(text)
    return graph


def test_dot_is_the_lasso(planned):
    found, scenario = planned
    graph = read_dot(plan_dot(found, scenario))
    edges = [(edge.get_source(), edge.get_destination()) for edge in graph.get_edges()]
    names = [f"s{number}" for number in range(1, len(found.states) + 1)]
    assert edges == [*pairwise(names), (names[-1], names[found.loop])]
    borders = {node.get_name(): node.get("peripheries") for node in graph.get_nodes() if node.get_name() in names}
    assert [borders[name] for name in names] == ["1"] * found.loop + ["2"] * len(found.suffix)
    labels = [edge.get("label") for edge in graph.get_edges()]
    assert any("{a1, a2} carry o1: pi2 → pi4" in label for label in labels)
    assert [label.strip('"').split(r"\n")[0] for label in labels] == [f"step {k}" for k in range(1, len(labels) + 1)]
    assert "a1 pi1[o2], a2 pi1[o2]" in graph.to_string()


def test_dot_of_a_state_for_ever(make_scenario):
    scenario = make_scenario({"a1": (1.0, "1")}, {})
    found = plan(scenario, State(("pi1",), (), (None,)), anything_fits)
    graph = read_dot(plan_dot(found, scenario))
    (edge,) = graph.get_edges()
    assert (edge.get_source(), edge.get_destination()) == ("s1", "s1")


# HOA


def test_hoa_is_the_formula(planned):
    _, scenario = planned
    spot = require_spot()
    read = spot.automaton(automaton_hoa(scenario))
    assert spot.are_equivalent(read, spot.formula(global_formula(scenario)))
    assert {ap.ap_name() for ap in read.ap()} == {"a1.pi3", "a2.pi3", "o1.pi1", "o1.pi4", "o2.pi4"}


# networkx


def test_transition_graph_is_def_5(make_scenario):
    scenario = make_scenario({"a1": (1.0, "1"), "a2": (1.0, "1")}, {"o1": (2.0, "1")}, TWO)
    graph = transition_graph(system_of(scenario))
    fits, rule, chi = published_fits(scenario.fits), sum_rule(scenario), sum_of_ways(scenario)
    allowed = {(s, t) for s in graph for t in graph if transition_fault(scenario, s, t, fits, rule) is None}
    assert set(graph.edges) == allowed
    for before, after, data in graph.edges(data=True):
        ways = zip(before.agents, before.grasps, after.agents, after.grasps, strict=True)
        assert data == {"cost": chi(before, after), "actions": sum((a, g) != (b, h) for a, g, b, h in ways)}


def test_counts_of_the_paper(case_i):
    scenario, start = case_i
    system = system_of(scenario)
    graph = transition_graph(system)
    assert (graph.number_of_nodes(), graph.number_of_edges()) == (560, 7680)
    assert start in graph


def test_large_graphs_are_refused(case_ii):
    scenario, start = case_ii
    system = system_of(scenario)
    with pytest.raises(SearchLimitError, match=r"TS has 160504 transitions; .* may have 1000 "):
        transition_graph(system, most_edges=1000)
    with pytest.raises(SearchLimitError, match="the product has more than 1000 edges"):
        product_graph(system, start, most_edges=1000)


def accepts(graph):
    """Whether the product has an accepting run: a strongly connected part with all marks of a clause, without the
    edges that must not recur."""
    return any(_accepts_by(clause, graph) for clause in graph.graph["clauses"])


def _accepts_by(clause, graph):
    edges = [(*ends, marks) for *ends, marks in graph.edges(data="marks") if not marks & clause.never]
    kept = nx.DiGraph()
    kept.add_weighted_edges_from(edges, weight="marks")
    for part in nx.strongly_connected_components(kept):
        inside = [marks for *_, marks in kept.subgraph(part).edges(data="marks")]
        if inside and clause.often <= frozenset().union(*inside):
            return True
    return False


FORMULAS = st.sampled_from(
    ["GF r1 & GF r0", "FG r1 & F r0", "G(r0 -> X r1) & G(r1 -> X r0)", "G r1", "F(r1 & X r1)", "GF r1 & FG r0", "1"]
)


@settings(deadline=None, max_examples=30)
@given(agent=FORMULAS, obj=FORMULAS)
def test_product_graph_accepts_where_there_is_a_plan(make_scenario, agent, obj):
    scenario = make_scenario({"a1": (1.0, agent)}, {"o1": (1.0, obj)}, TWO)
    system = system_of(scenario)
    feasible = feasible_starts(scenario, system)
    for index in range(system.n_states):
        assert accepts(product_graph(system, system.state(index))) == feasible[index]


def test_product_graph_projects_to_ts(planned):
    found, scenario = planned
    system = system_of(scenario)
    graph, ts = product_graph(system, found.states[0]), transition_graph(system)
    for (before, _), (after, _), cost in graph.edges(data="cost"):
        assert ts.edges[before, after]["cost"] == cost
    (initial,) = graph.graph["initial"]
    assert initial[0] == found.states[0]
    assert set(found.states) <= {state for state, _ in graph}


def test_a_product_needs_a_state_to_begin_in(case_i):
    scenario, _ = case_i
    crowd = State(("pi1", "pi1"), ("pi1", "pi1"), ("o1", "o1"))
    with pytest.raises(InfeasibleError, match="initial state is impossible"):
        product_graph(system_of(scenario), crowd)


# Files


def test_files(planned, tmp_path):
    found, scenario = planned
    folder = tmp_path / "new" / "plan"
    files = write_outputs(found, scenario, folder)
    assert set(files) == set(folder.iterdir())
    assert [file.name for file in files] == ["plan.json", "plan.txt", "plan.dot", "projections.json", "automaton.hoa"]
    data = json.loads((folder / "plan.json").read_text(encoding="utf-8"))
    assert plan_from_json(data, scenario) == found
    assert data["counts"]["ts_states"] == 560
    text = (folder / "plan.txt").read_text(encoding="utf-8")
    assert "{a1, a2} carry o2: pi1 → pi4" in text
    assert "o1: G(pi1 -> X pi4) counts plan steps" in text
    assert "\na1: pi1 " in text
    assert set(json.loads((folder / "projections.json").read_text(encoding="utf-8"))) == {"agents", "objects"}
    assert (folder / "automaton.hoa").read_text(encoding="utf-8").startswith("HOA: v1")
    assert (folder / "plan.dot").read_text(encoding="utf-8").startswith("digraph")
