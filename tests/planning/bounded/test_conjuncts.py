"""Automata of conjuncts against Spot's own judgement of words."""

from __future__ import annotations

from itertools import product

import pytest

from drake_ltl.planning.bounded.conjuncts import automaton, automaton_of_each_member, conjuncts, is_contradictory
from drake_ltl.planning.words import satisfies

FORMULAS = [
    "1",
    "0",
    "F a.p",
    "G !a.p",
    "GF a.p & GF a.q",
    "FG a.p",
    "FG a.p | (GF a.q & GF !a.q)",
    "G(a.p -> X a.q)",
    "G(a.p -> F a.q)",
    "GF a.p -> GF b.q",
    "GF(a.p & X a.q)",
    "a.p U (b.q & X !a.p)",
    "F(a.p & X(a.q & F a.p))",
]
LETTERS = [frozenset(), frozenset({"a.p"}), frozenset({"a.q", "b.q"}), frozenset({"a.p", "b.q"})]


def accepts(conjunct, prefix, cycle):
    """By as many rounds as it needs to settle, then one more whose marks recur."""
    state = conjunct.initial
    for letter in (*prefix, *(cycle * conjunct.settles)):
        if state is None:
            return False
        state, _ = conjunct.read(state, letter)
    first, met = state, set()
    for letter in cycle:
        if state is None:
            return False
        state, marks = conjunct.read(state, letter)
        met |= marks
    assert state is None or state == first, "it has not settled"
    return state is not None and any(c.often <= met and not c.never & met for c in conjunct.clauses)


@pytest.mark.parametrize("formula", FORMULAS)
def test_accepts_the_words_of_its_formula(formula):
    conjunct = automaton(formula)
    assert conjunct.settles is not None
    for n_prefix, n_cycle in ((0, 1), (0, 2), (1, 1), (1, 2), (0, 3)):
        for word in product(LETTERS, repeat=n_prefix + n_cycle):
            prefix, cycle = word[:n_prefix], word[n_prefix:]
            assert accepts(conjunct, prefix, cycle) == satisfies(formula, prefix, cycle), (prefix, cycle)


def test_formulas_are_split(make_scenario):
    scenario = make_scenario({"a1": (1.0, "GF pi1 & G !pi3")}, {"o1": (1.0, "F pi2")}, spec="F(a1.pi2 & o1.pi2)")
    assert sorted(len(c.members) for c in conjuncts(scenario)) == [1, 1, 1, 2]
    assert set(automaton_of_each_member(scenario)) == {"a1", "o1"}
    assert not is_contradictory(scenario)
    assert is_contradictory(make_scenario({"a1": (1.0, "G !pi3 & F pi3")}, {}))


def test_what_makes_the_automaton_of_a_member_too_large_is_left_out(make_scenario):
    """It must allow no less than the formula does."""
    formula = " & ".join(["GF r0", *(f"F(r0 & {'X' * n} r1)" for n in range(1, 8))])
    scenario = make_scenario({"a1": (1.0, formula)}, {}, {"r0": (0.0, 0.0, 0.0), "r1": (9.0, 0.0, 0.0)})
    own = automaton_of_each_member(scenario)["a1"]
    assert 1 < own.n_states <= 3000
    assert own.accepts([], [frozenset({"a1.r0"}), *[frozenset({"a1.r1"})] * 7])
    assert not own.accepts([], [frozenset({"a1.r1"})])
