"""Loops that only later rounds close, for missions in which they are the cheapest."""

from __future__ import annotations

import numpy as np
import pytest

from drake_ltl.planning import models, rounds
from drake_ltl.planning.acceptance import Clause
from drake_ltl.planning.automaton import Automaton
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.marks import Marks
from drake_ltl.planning.plan import State
from drake_ltl.planning.planner import plan
from drake_ltl.planning.product import Graph, Part

START = State(("pi1", "pi3", "pi4"), ("pi2", "pi1"), (None,) * 3)
SPECS = {
    "a1": "G(pi1 -> X(!pi1 U pi2)) & (!pi3 U pi3) & G(pi3 -> X !pi2)",
    "a2": "G(pi4 -> X(!pi4 U pi1)) & GF pi1",
    "o1": "(!pi4 U pi2) & GF(pi2 & F(pi3 & F pi2))",
}


@pytest.fixture
def mission(make_scenario):
    """The regions of the paper's second example; the automaton reads the cheapest loop twice before it is back."""
    regions = {"pi1": (0.0, 0.0, 0.0), "pi2": (-14.0, -14.0, 0.0), "pi3": (20.0, -10.0, 0.0), "pi4": (-16.0, 15.0, 0.0)}
    agents = {"a1": (4.0, SPECS["a1"]), "a2": (3.0, SPECS["a2"]), "a3": (3.0, "1")}
    return make_scenario(agents, {"o1": (5.0, SPECS["o1"]), "o2": (6.0, "1")}, regions)


@pytest.mark.parametrize("most_listed", [0, models.MOST_LISTED])
def test_a_loop_that_is_closed_later_is_found_and_proven(mission, most_listed, monkeypatch):
    """The same with and without a list of transitions; better than any that is closed at once."""
    monkeypatch.setattr(models, "MOST_LISTED", most_listed)
    found = plan(mission, START, published_fits(mission.fits))
    assert found.status == "optimal"
    monkeypatch.setattr(rounds, "MOST_EDGES", 0)
    closed = plan(mission, START, published_fits(mission.fits))
    assert closed.status == "feasible"
    assert closed.lower_bound <= found.cost < closed.cost


@pytest.mark.parametrize("few", [0, rounds.FEW_LAYERED_EDGES])
def test_looking_without_marks_first_changes_nothing(mission, few, monkeypatch):
    best = plan(mission, START, published_fits(mission.fits))
    monkeypatch.setattr(rounds, "FEW_LAYERED_EDGES", few)
    found = plan(mission, START, published_fits(mission.fits))
    assert (found.status, found.cost, len(found.moves)) == (best.status, best.cost, len(best.moves))


def test_levels_with_too_many_sets_of_marks_are_searched_by_themselves(mission, monkeypatch):
    """Each for its own loops, of which there are fewer than of all later levels together."""
    best = plan(mission, START, published_fits(mission.fits))
    monkeypatch.setattr(rounds, "FEW_LAYERED_EDGES", 0)
    monkeypatch.setattr(rounds, "MOST_LAYERED_EDGES", 300_000)
    found = plan(mission, START, published_fits(mission.fits))
    assert (found.status, found.cost, len(found.moves)) == ("optimal", best.cost, len(best.moves))


def test_below_every_bound_there_is_no_loop():
    """A part of one node, whose loop weighs 5 at a price of 2."""
    one, clause = np.zeros((1, 1), dtype=np.int64), Clause(frozenset({0}), frozenset())
    graph = Graph.of(1, np.array([0]), np.array([0], dtype=np.int32), np.array([5.0]))
    marks = Marks(Part(graph, np.ones(1, dtype=np.int64), np.array([0])), 1)
    searched = rounds.Rounds(
        Automaton(0, one, one + 1, (clause,)),
        one[0],
        np.full((1, 1), 2.0),
        np.array([2.0]),
        lambda nodes: nodes[:, None],
    )
    for limit in (3.0, 7.0, 100.0):
        assert searched.cheapest(marks, limit) == (None, limit)
