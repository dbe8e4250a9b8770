"""Questions to Spot: the same answers from a child process."""

from __future__ import annotations

import pytest

from drake_ltl import spot_questions
from drake_ltl.errors import SearchLimitError
from drake_ltl.planning import stuttering
from drake_ltl.planning.automaton import buchi_size, translate
from drake_ltl.planning.counts import Counts
from drake_ltl.spot_questions import ask, automaton, is_quick
from drake_ltl.spot_support import require_spot

LARGE = "G(a.p -> X a.q) & GF a.p & F(b.p & X(b.q U c.p)) & (G !c.q | FG d.p) & F d.q"
HARD = " & ".join(f"F(a.p & {'X' * n} a.q)" for n in range(1, 12))
"""Takes minutes."""


@pytest.mark.parametrize(
    ("formula", "quick"),
    [
        ("1", True),
        ("G!a1.pi3 & GFa2.pi3 & GFo1.pi1 & G(o1.pi1 -> Fo1.pi4) & GFo2.pi3", True),
        (LARGE, False),
        ("F(a.p & X[9] a.q)", False),
        (" | ".join(f"a.p{n}" for n in range(200)), False),
    ],
)
def test_what_is_quick(formula, quick):
    assert is_quick(formula) == quick


@pytest.mark.parametrize("kind", [("tgba", "deterministic"), ("tgba", "small"), ("generic", "deterministic")])
def test_automata_of_another_process_are_the_same(monkeypatch, kind):
    """Up to the order of edges, which depends on what was asked before."""
    assert not is_quick(LARGE)
    there = automaton(LARGE, *kind)
    monkeypatch.setattr(spot_questions, "is_quick", lambda formula: True)
    here = automaton(LARGE, *kind)
    spot = require_spot()
    assert spot.are_equivalent(there, here)
    assert (there.num_states(), there.num_edges()) == (here.num_states(), here.num_edges())
    assert spot.is_deterministic(there) == spot.is_deterministic(here)


def test_questions_have_a_time_limit():
    with pytest.raises(TimeoutError):
        ask(str, HARD, seconds=0.0)
    with pytest.raises(TimeoutError):
        buchi_size(HARD, seconds=0.1)


def test_automata_that_are_too_large_are_given_up():
    formula = " & ".join(f"F(a.p & {'X' * n} a.q)" for n in range(1, 7))
    with pytest.raises(SearchLimitError, match="more than 3000 states"):
        translate(formula)


def test_sizes_that_take_long_are_left_out(monkeypatch):
    monkeypatch.setattr("drake_ltl.planning.counts.BUCHI_TIME", 0.1)
    counts = Counts(7, 8, HARD)
    assert dict(counts) == {
        "ts_states": 7,
        "ts_transitions": 8,
        "automaton_states": None,
        "automaton_edges": None,
        "product_states": None,
    }


def test_what_takes_long_counts_steps(monkeypatch):
    monkeypatch.setattr(stuttering, "STUTTER_TIME", 0.1)
    assert stuttering.is_stutter_sensitive(HARD)
