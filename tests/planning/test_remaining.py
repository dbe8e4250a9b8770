"""Progression of formulas along words."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_ltl.planning.remaining import Pursuit, Standing, begins_round, progressed, pursuits
from drake_ltl.scenario.model import Agent, Region, Scenario
from drake_ltl.spot_support import require_spot
from drake_ltl.verification.ltl import holds

ATOMS = st.sampled_from(["p", "q", "1", "0"])
FORMULAS = st.recursive(
    ATOMS,
    lambda inner: st.one_of(
        st.tuples(st.sampled_from("!XFG"), inner).map(lambda parts: f"{parts[0]}({parts[1]})"),
        st.tuples(inner, st.sampled_from(["&", "|", "->", "<->", "xor", "U", "W", "R", "M"]), inner).map(
            lambda parts: f"({parts[0]}) {parts[1]} ({parts[2]})"
        ),
    ),
    max_leaves=6,
)
LETTERS = st.frozensets(st.sampled_from("pq"))


@given(FORMULAS, LETTERS, st.lists(LETTERS, max_size=2), st.lists(LETTERS, min_size=1, max_size=2))
def test_the_rest_decides_what_the_first_letter_left_open(formula, letter, prefix, cycle):
    rest = str(progressed(require_spot().formula(formula), letter))
    assert holds(formula, [letter, *prefix], cycle) == holds(rest, prefix, cycle)


def scenario(spec: str) -> Scenario:
    regions = tuple(Region(name, (x, 0.0, 0.0), 1.0) for name, x in (("here", 0.0), ("there", 5.0)))
    agent = Agent("a", "model.urdf", (0.0, 0.0), 0.0, 1.0, spec=spec)
    return Scenario(name="s", workspace_radius=9.0, regions=regions, agents=(agent,), objects=())


def standings(spec: str, *word: str, prefix: int = 99, suffix: int = 1) -> list[str]:
    letters = [frozenset({f"a.{name}"} if name else ()) for name in word]
    return [goals[0].standing.value for goals in pursuits(scenario(spec), letters, prefix, suffix)]


@pytest.mark.parametrize(
    ("spec", "word", "expected"),
    [
        ("F there", ["here", "there", "here"], ["owed", "met", "met"]),
        ("G !there", ["here", "there", "here"], ["kept", "broken", "broken"]),
        ("G(here -> F there)", ["", "here", "", "there", ""], ["kept", "owed", "owed", "kept", "kept"]),
        ("FG there", ["here", "there", "here"], ["owed", "kept", "owed"]),
        ("here U there", ["here", "here", "there"], ["owed", "owed", "met"]),
        ("here -> GF there", ["here", "there"], ["owed", "owed"]),
    ],
)
def test_how_demands_stand(spec, word, expected):
    assert standings(spec, *word) == expected


def test_what_recurs_is_owed_anew_in_every_round():
    word = ["here", "there", "here", "there", "here"]
    assert standings("GF there", *word, prefix=1, suffix=2) == ["owed", "met", "met", "met", "met"]
    assert standings("GF there", *word, prefix=2, suffix=2) == ["owed", "met", "owed", "met", "owed"]


def test_what_is_left_says_so():
    first, second = pursuits(scenario("F(here & F there)"), [frozenset({"a.here"}), frozenset({"a.there"})], 9, 1)
    assert (first[0].standing, first[0].left) == (Standing.OWED, "F there")
    assert (second[0].standing, second[0].left) == (Standing.MET, "")


def test_the_global_formula_uses_canonical_names():
    both = dataclasses.replace(scenario("1"), spec="F a.there")
    (goals,) = pursuits(both, [frozenset({"a.there"})], 9, 1)
    assert [(goal.demand.owner, goal.standing) for goal in goals] == [("", Standing.MET)]


def test_formulas_that_are_too_large_are_not_followed():
    large = " & ".join(f"F(here & X{'X' * n} there)" for n in range(9))
    pursuit = Pursuit.of(scenario(f"F({large})")).after(frozenset({"a.here"}))
    assert pursuit.goals[0].standing is Standing.UNKNOWN


def test_rounds_begin_after_the_prefix():
    assert [begins_round(position, 2, 3) for position in range(7)] == [False, False, True, False, False, True, False]
    assert not begins_round(0, 0, 0)
