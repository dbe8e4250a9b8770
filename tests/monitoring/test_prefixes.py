"""Standings of prefixes against Spot's satisfiability of the formula with the prefix written into it."""

from __future__ import annotations

import pickle

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_ltl.errors import SearchLimitError
from drake_ltl.monitoring import prefixes as module
from drake_ltl.monitoring.prefixes import START, Standing, prefixes
from drake_ltl.spot_questions import is_contradiction

NAMES = ("a", "b")
LETTERS = st.frozensets(st.sampled_from(NAMES))
FORMULAS = st.recursive(
    st.sampled_from([*NAMES, "1", "0"]),
    lambda part: st.one_of(
        st.builds("{}({})".format, st.sampled_from(["!", "X ", "F ", "G "]), part),
        st.builds("({}) {} ({})".format, part, st.sampled_from(["&", "|", "->", "U", "R", "W"]), part),
    ),
    max_leaves=4,
)


def standing(formula: str, word: list[frozenset[str]]) -> Standing:
    watched, place = prefixes(formula), START
    for letter in word:
        place = watched.after(place, letter)
    return place.standing


def beginning(word: list[frozenset[str]]) -> str:
    """The formula of all words that begin so."""
    literals = [name if name in letter else f"!{name}" for letter in word for name in NAMES]
    shifted = [f"{'X ' * (index // len(NAMES))}({literal})" for index, literal in enumerate(literals)]
    return " & ".join(shifted)


@settings(max_examples=30)  # some 0.05 s each
@given(FORMULAS, st.lists(LETTERS, min_size=1, max_size=4))
def test_standings_are_those_of_all_continuations(formula, word):
    found, so_far = standing(formula, word), beginning(word)
    assert (found is Standing.BAD) == is_contradiction(f"({formula}) & {so_far}")
    if found is not Standing.BAD:
        assert (found is Standing.GOOD) == is_contradiction(f"!({formula}) & {so_far}")


@pytest.mark.parametrize(
    ("formula", "word", "wanted"),
    [
        ("G !a", [set(), {"b"}], Standing.UNDECIDED),
        ("G !a", [set(), {"a"}], Standing.BAD),
        ("G !a", [{"a"}, set()], Standing.BAD),  # and nothing makes it good again
        ("F a", [set(), {"a"}, set()], Standing.GOOD),
        ("GF a", [set()] * 9, Standing.UNDECIDED),
        ("X b", [{"b"}, set()], Standing.BAD),
        ("1", [set()], Standing.GOOD),
        ("0", [set()], Standing.BAD),
        ("(F a) & G !b", [{"a"}, {"b"}], Standing.BAD),
    ],
)
def test_standings(formula, word, wanted):
    assert standing(formula, [frozenset(letter) for letter in word]) is wanted


def test_nothing_of_spot_s_stays():
    """A Drake Value that holds it must be copied with its Context."""
    watched = prefixes("G(a -> X b)")
    assert pickle.loads(pickle.dumps(watched)) == watched


def test_time_is_limited(monkeypatch):
    def ask(question, formula, seconds):
        raise TimeoutError

    monkeypatch.setattr(module, "ask", ask)
    with pytest.raises(SearchLimitError, match="not made within 2 s"):
        prefixes("G a", seconds=2.0)
