"""Questions to Spot: the same answers from a child process."""

from __future__ import annotations

import time

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


def sleep(formula: str) -> None:
    time.sleep(10.0)


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
        ask(sleep, LARGE, seconds=0.0)
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


@pytest.fixture
def impatient(monkeypatch):
    """Nothing was asked before, and there is little time for each question."""
    monkeypatch.setattr(spot_questions, "_hopeless", {})
    monkeypatch.setattr(spot_questions, "_given_up", [])
    monkeypatch.setattr(spot_questions, "MOST_TIME", 0.2)
    monkeypatch.setattr(spot_questions, "LEAST_TIME", 0.01)


def test_questions_without_a_time_limit_are_given_up(impatient, monkeypatch):
    with pytest.raises(SearchLimitError, match=r"'F\(a\.p & X a\.q\).*\.\.\.' .* is not made within 0\.2 s"):
        automaton(HARD, "small")
    with monkeypatch.context() as patch:
        patch.setattr(spot_questions, "apart", None)  # nothing is asked twice in vain
        with pytest.raises(SearchLimitError, match=r"not made within 0\.2 s"):
            automaton(HARD, "small")
    with pytest.raises(SearchLimitError, match=r"not made within 0\.1 s"):
        automaton(f"{HARD} & G a.r", "small")
    with pytest.raises(TimeoutError):
        ask(sleep, LARGE, seconds=0.0)


def test_patience_comes_back(impatient, monkeypatch):
    now = spot_questions.time.monotonic()
    spot_questions._given_up[:] = [now - 2 * spot_questions.RECOVERY, now, now]
    assert spot_questions._patience() == pytest.approx(0.2 / 4)
    spot_questions._given_up += [now] * 50
    assert spot_questions._patience() == 0.01


def greedy(formula: str) -> int:
    return len(bytearray(1 << 30))


def refuse(formula: str) -> None:
    raise RuntimeError("Too many acceptance sets used.\nIf you do not mind")


def test_questions_that_take_too_much_memory(monkeypatch, capfd):
    monkeypatch.setattr(spot_questions, "MOST_MEMORY", 1 << 28)
    with pytest.raises(SearchLimitError, match="beyond what Spot can do"):
        ask(greedy, LARGE)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("formula", ["a.p", LARGE])
def test_what_spot_refuses(formula):
    with pytest.raises(SearchLimitError, match="beyond what Spot can do") as caught:
        ask(refuse, formula)
    assert "\n" not in str(caught.value)
