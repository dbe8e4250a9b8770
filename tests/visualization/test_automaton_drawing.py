"""Automata as graphs, and drawn with and without Graphviz."""

from __future__ import annotations

import shutil
from xml.etree import ElementTree

import pytest
from matplotlib.figure import Figure

from drake_ltl.visualization import automaton_drawing
from drake_ltl.visualization.automaton_drawing import (
    automaton_graph,
    automaton_graphs,
    automaton_pdf,
    automaton_svg,
    dot,
)


@pytest.fixture
def graph():
    return automaton_graph("o1", "GF pi1 & G(pi1 -> F pi4)")


def test_it_accepts_what_the_formula_says():
    """F p: once p was read, an accepting state keeps all words."""
    graph = automaton_graph("a", "F p")
    assert (graph.num_states, len(graph.accepting)) == (2, 1)
    (accepting,) = graph.accepting
    assert (accepting, accepting, "1") in graph.edges
    assert {(a, b, label) for a, b, label in graph.edges if a != b} == {(graph.initial, accepting, "p")}


def test_acceptance_is_by_states():
    assert automaton_graph("a", "GF p").num_states == 2


def test_what_is_too_large_is_not_drawn(monkeypatch):
    monkeypatch.setattr(automaton_drawing, "PATIENCE", 0.3)
    assert automaton_graph("a", " & ".join(f"GF p{i}" for i in range(30))) is None


def test_each_formula_and_their_conjunction(case_ii):
    assert [graph.name for graph in automaton_graphs(case_ii)] == ["the whole specification", "a1", "a2", "o1", "o2"]


@pytest.mark.parametrize("graphviz", [True, False])
def test_drawings_are_svg_and_pdf(graph, graphviz, monkeypatch):
    if graphviz and shutil.which("dot") is None:
        pytest.skip("Graphviz is not installed")
    if not graphviz:
        monkeypatch.setattr(automaton_drawing.shutil, "which", lambda _: None)
    svg = automaton_svg(graph)
    assert ElementTree.fromstring(svg[svg.index("<svg") :]).tag.endswith("svg")
    assert automaton_pdf(graph).startswith(b"%PDF-")


def test_dot_has_every_state_and_edge(graph):
    text = dot(graph)
    assert text.count("peripheries=2") == len(graph.accepting)
    assert text.count("->") - text.count('label="') <= len(graph.edges) + 1
    for source, goal, _ in graph.edges:
        assert f"{source} -> {goal}" in text


def test_matplotlib_writes_every_label(graph):
    figure = Figure()
    automaton_drawing.automaton_drawing(graph).draw(figure)
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert {label for _, _, label in graph.edges} <= set(texts)
