"""The automata of formulas, drawn: by Graphviz where it is installed, else by Matplotlib."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass

import networkx as nx
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.demands import spaced
from drake_ltl.scenario.formulas import global_formula
from drake_ltl.scenario.model import Scenario
from drake_ltl.spot_questions import ask
from drake_ltl.spot_questions import automaton as spot_automaton
from drake_ltl.spot_support import require_spot
from drake_ltl.visualization.palette import AGENT_HUES, FLOOR, INK, MUTED, hex_code, mixed
from drake_ltl.visualization.style import HALO, Drawing

MOST_STATES, MOST_EDGES = 24, 90
"""Of an automaton that can be read in a drawing."""
PATIENCE = 10.0
"""For making an automaton, and for drawing it [s]."""
MOST_LABELS = 12
"""Edges of an automaton with more have no labels in its drawing: they would hide one another."""
LABEL_WIDTH = 48
"""Characters of an edge's label; longer ones are cut."""
_SIZE = (6.4, 4.8)


@dataclass(frozen=True)
class AutomatonGraph:
    """A Buchi automaton: a run is accepted if it meets accepting states for ever."""

    name: str
    """Whose formula it is."""
    formula: str
    initial: int
    accepting: frozenset[int]
    num_states: int
    edges: tuple[tuple[int, int, str], ...]
    """From, to, and what is read on the way."""

    @property
    def has_labels(self) -> bool:
        """Whether its drawing says what is read."""
        return len(self.edges) <= MOST_LABELS


def automaton_graphs(scenario: Scenario) -> list[AutomatonGraph]:
    """BA of the whole specification, then of each formula of which it consists: those that can be read in a drawing.

    State-based Buchi acceptance, as small as Spot makes it; no sink for words that are refused.
    """
    members = [(member.name, member.spec) for member in (*scenario.agents, *scenario.objects)]
    parts = [part for part in (*members, ("the formula over everything", scenario.spec)) if part[1] != "1"]
    whole = [("the whole specification", global_formula(scenario))] if len(parts) != 1 else []
    found = [automaton_graph(name, formula) for name, formula in (*whole, *parts)]
    return [graph for graph in found if graph is not None]


def automaton_graph(name: str, formula: str) -> AutomatonGraph | None:
    """None if it is too large to be drawn, or to be made."""
    try:
        return ask(_read, formula, name, seconds=PATIENCE)
    except (TimeoutError, SearchLimitError):
        return None


def automaton_svg(graph: AutomatonGraph) -> str:
    """A drawing, the same for the same automaton."""
    drawn = _by_graphviz(graph, "svg")
    if drawn is None:
        return automaton_drawing(graph).svg()
    text = drawn.decode()
    return text[text.index("<svg") :]


def automaton_pdf(graph: AutomatonGraph) -> bytes:
    """The same drawing, for print."""
    return _by_graphviz(graph, "pdf") or automaton_drawing(graph).render(["pdf"])["pdf"]


def _by_graphviz(graph: AutomatonGraph, kind: str) -> bytes | None:
    """None where Graphviz is not installed, or cannot draw such files."""
    program = shutil.which("dot")
    if program is None:
        return None
    command = [program, f"-T{kind}"]
    try:
        done = subprocess.run(command, input=dot(graph).encode(), capture_output=True, timeout=PATIENCE, check=True)
    except (subprocess.SubprocessError, OSError):
        return None
    return done.stdout


def dot(graph: AutomatonGraph) -> str:
    """In Graphviz's language; accepting states have a double border."""
    fill = hex_code(mixed(AGENT_HUES[0], (1.0, 1.0, 1.0), 0.85))
    lines = [
        "digraph {",
        '  rankdir=LR; bgcolor="transparent"; nodesep=0.35; ranksep=0.6;',
        f'  node [shape=circle, style=filled, fillcolor="{fill}", color="{hex_code(INK)}"];',
        '  node [fontname="Helvetica", fontsize=11, width=0.35, margin=0.03];',
        f'  edge [fontname="Helvetica", fontsize=10, color="{hex_code(MUTED)}", fontcolor="{hex_code(INK)}"];',
        '  start [shape=point, width=0.06, label=""];',
        f"  start -> {graph.initial};",
    ]
    for state in range(graph.num_states):
        lines.append(f"  {state} [peripheries={2 if state in graph.accepting else 1}];")
    for source, goal, label in graph.edges:
        shown = f' [label="{_escaped(_short(label))}"]' if graph.has_labels else ""
        lines.append(f"  {source} -> {goal}{shown};")
    return "\n".join([*lines, "}"])


def automaton_drawing(graph: AutomatonGraph) -> Drawing:
    """By Matplotlib alone."""
    title = f"automaton of {graph.name}: {spaced(graph.formula)}"
    return Drawing("automaton", title, _SIZE, lambda figure: _draw(figure, graph))


def _read(formula: str, name: str) -> AutomatonGraph | None:
    spot = require_spot()
    made = spot_automaton(formula, "BA", "sbacc", "small")
    if made.num_states() > MOST_STATES or made.num_edges() > MOST_EDGES:
        return None
    edges = tuple(
        (edge.src, edge.dst, spot.bdd_format_formula(made.get_dict(), edge.cond).replace('"', ""))
        for edge in made.edges()
    )
    accepting = frozenset(state for state in range(made.num_states()) if made.state_is_accepting(state))
    return AutomatonGraph(name, formula, made.get_init_state_number(), accepting, made.num_states(), edges)


def _short(label: str) -> str:
    return label if len(label) <= LABEL_WIDTH else f"{label[: LABEL_WIDTH - 3]}..."


def _escaped(label: str) -> str:
    return label.replace("\\", "\\\\").replace('"', '\\"')


def _draw(figure: Figure, graph: AutomatonGraph) -> None:
    axes = figure.add_subplot()
    axes.set_axis_off()
    axes.set_aspect("equal")
    places = _places(graph)
    radius = 0.09
    for state, place in enumerate(places):
        for size in (radius, 0.78 * radius)[: 2 if state in graph.accepting else 1]:
            axes.add_patch(_circle(place, size))
        axes.text(*place, str(state), ha="center", va="center", zorder=4)
    axes.annotate(
        "", places[graph.initial] - (radius, 0.0), (-22, 0), textcoords="offset points",
        arrowprops={"arrowstyle": "->", "color": INK},
    )  # fmt: skip
    pairs = {(source, goal) for source, goal, _ in graph.edges}
    for source, goal, label in graph.edges:
        _draw_edge(
            axes, places, radius, source, goal, _short(label) if graph.has_labels else "", bent=(goal, source) in pairs
        )
    axes.margins(0.2)
    axes.autoscale_view()


def _circle(place: np.ndarray, radius: float) -> Circle:
    return Circle(tuple(place), radius, facecolor=FLOOR, edgecolor=INK, lw=1.0, zorder=3)


def _places(graph: AutomatonGraph) -> Sequence[np.ndarray]:
    """(2,) of each state: on a circle, beginning at the left, where neighbours stand side by side."""
    drawn = nx.Graph((source, goal) for source, goal, _ in graph.edges if source != goal)
    drawn.add_nodes_from(range(graph.num_states))
    order = list(nx.dfs_preorder_nodes(drawn, graph.initial))
    order += [state for state in range(graph.num_states) if state not in order]
    angles = np.pi - 2 * np.pi * np.arange(len(order)) / max(len(order), 1)
    places = np.zeros((graph.num_states, 2))
    places[order] = np.column_stack([np.cos(angles), np.sin(angles)]) if len(order) > 1 else 0.0
    return places


def _draw_edge(axes, places, radius: float, source: int, goal: int, label: str, *, bent: bool) -> None:
    start, end = places[source], places[goal]
    if source == goal:
        out = start / np.linalg.norm(start) if np.linalg.norm(start) > 1e-9 else np.array([0.0, 1.0])
        side = np.array([-out[1], out[0]])
        begin, finish = start + radius * (out - 0.5 * side), start + radius * (out + 0.5 * side)
        style, middle = "arc3,rad=1.6", start + 2.9 * radius * out
    else:
        along = (end - start) / np.linalg.norm(end - start)
        begin, finish = start + radius * along, end - radius * along
        curve = 0.18 if bent else 0.0
        style = f"arc3,rad={curve}"
        middle = 0.5 * (begin + finish) + 0.5 * curve * np.linalg.norm(end - start) * np.array([along[1], -along[0]])
    axes.add_patch(
        FancyArrowPatch(begin, finish, connectionstyle=style, arrowstyle="-|>", mutation_scale=9, color=MUTED, lw=1.0)
    )
    axes.text(*middle, label, ha="center", va="center", fontsize=7.5, zorder=5, path_effects=HALO, parse_math=False)
