"""Which formulas count plan steps, against repeating letters one by one."""

from __future__ import annotations

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from drake_ltl.planning.stuttering import is_stutter_sensitive, stutter_note
from drake_ltl.planning.words import satisfies

LETTERS = st.lists(
    st.sampled_from([frozenset(), frozenset({"p"}), frozenset({"q"}), frozenset({"p", "q"})]), max_size=3
)


@pytest.mark.parametrize(
    ("formula", "sensitive"),
    [
        ("GF pi1 & G(pi1 -> F pi4)", False),
        ("G(pi1 -> X pi4)", True),
        ("X pi1", True),
        ("F(pi1 & X pi1) | F pi1", False),
        ("F(pi1 & X !pi1)", False),
        ("F(pi1 & X pi1)", True),
        ("F(pi1 & X(pi1 U !pi1))", False),
        ("X X 1", False),
        ("0", False),
    ],
)
def test_known_formulas(formula, sensitive):
    assert is_stutter_sensitive(formula) == sensitive


FORMULAS = st.sampled_from(
    [
        "X p",
        "G(p -> X q)",
        "GF(p & X q)",
        "F(p & X !p)",
        "p U X q",
        "(p & X p) | F p",
        "F(p & X(p U !p))",
        "G(p <-> X p)",
    ]
)


@settings(deadline=None)
@given(formula=FORMULAS, prefix=LETTERS, cycle=LETTERS.filter(bool), data=st.data())
@example(formula="F(p & X(p U !p))", prefix=[frozenset({"p"})], cycle=[frozenset()], data=None)
def test_repeating_letters_changes_nothing_for_insensitive_formulas(formula, prefix, cycle, data):
    if is_stutter_sensitive(formula):
        return
    counts = st.integers(1, 3)
    repeated = [
        [letter for letter in part for _ in range(data.draw(counts) if data else 2)] for part in (prefix, cycle)
    ]
    assert satisfies(formula, *repeated) == satisfies(formula, prefix, cycle)


@pytest.mark.parametrize(
    ("formula", "short", "long"),
    [
        ("G(p -> X q)", ([{"p"}], [{"q"}]), ([{"p"}, {"p"}], [{"q"}])),
        ("X p", ([{"q"}], [{"p"}]), ([{"q"}, {"q"}], [{"p"}])),
    ],
)
def test_sensitive_formulas_have_words_that_show_it(formula, short, long):
    short, long = ([[frozenset(x) for x in part] for part in word] for word in (short, long))
    assert is_stutter_sensitive(formula)
    assert satisfies(formula, *short) != satisfies(formula, *long)


def test_notes(case_i, case_ii, make_scenario):
    assert stutter_note(case_i[0]) == "o1: G(pi1 -> X pi4) counts plan steps"
    assert stutter_note(case_ii[0]) is None
    two = make_scenario({"a1": (1.0, "X pi1 & F pi2")}, {}, spec="X X a1.pi2")
    assert stutter_note(two) == "a1: X pi1 and 1 more count plan steps"
