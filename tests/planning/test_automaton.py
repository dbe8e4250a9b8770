"""Automata as tables against Spot's own judgement of words."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from drake_ltl.planning.automaton import Automaton, buchi_size, letters, never_counts, tabulate, translate
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.power import sum_rule
from drake_ltl.planning.profiles import accepted_from, all_profiles, profile_of
from drake_ltl.planning.transition_system import form
from drake_ltl.planning.words import letter_of, satisfies

ATOMS = ["p", "q"]
ALL_LETTERS = np.array([[False, False], [False, True], [True, False], [True, True]])
FORMULAS = st.recursive(
    st.sampled_from([*ATOMS, "!p", "!q"]),
    lambda inner: st.one_of(
        st.tuples(st.sampled_from(["X", "F", "G", "GF", "FG"]), inner).map(lambda x: f"{x[0]}({x[1]})"),
        st.tuples(inner, st.sampled_from(["&", "|", "U", "R"]), inner).map(lambda x: f"({x[0]}) {x[1]} ({x[2]})"),
    ),
    max_leaves=6,
)
WORDS = st.lists(st.integers(0, 3), max_size=4)


def table_of(formula):
    return tabulate(translate(formula), ATOMS, ALL_LETTERS)


def as_letters(word):
    return [frozenset(np.array(ATOMS)[ALL_LETTERS[letter]].tolist()) for letter in word]


def states_after(automaton, word):
    states = {automaton.initial}
    for letter in word:
        states = {t for q in states for t in automaton.successors[q, letter].tolist()} - {-1}
    return states


def accepts(automaton, prefix, cycle):
    return bool(states_after(automaton, prefix) & accepted_from(profile_of(automaton, cycle), automaton.full))


@settings(deadline=None, max_examples=150)
@given(formula=FORMULAS, prefix=WORDS, cycle=WORDS.filter(len))
def test_tables_and_profiles_accept_what_spot_accepts(formula, prefix, cycle):
    expected = satisfies(formula, as_letters(prefix), as_letters(cycle))
    assert accepts(table_of(formula), prefix, cycle) == expected


@settings(deadline=None, max_examples=60)
@given(formula=FORMULAS, cycle=WORDS.filter(len))
def test_the_profiles_of_all_words_are_an_automaton(formula, cycle):
    automaton = table_of(formula)
    profiles = all_profiles(automaton, np.arange(4), most=2000)
    state = 0
    for letter in cycle:
        state = profiles.automaton.successors[state, letter, 0] if state >= 0 else -1
    accepted = frozenset(np.flatnonzero(profiles.accepted[state]).tolist()) if state >= 0 else frozenset()
    assert accepted == accepted_from(profile_of(automaton, cycle), automaton.full)


@settings(deadline=None, max_examples=60)
@given(formula=FORMULAS, cycle=WORDS.filter(len))
@example(formula="F p & G(q -> X !q) & G(!q -> X q)", cycle=[2])
def test_what_closes_later_is_read_by_a_smaller_automaton(formula, cycle):
    automaton = table_of(formula)
    profiles = all_profiles(automaton, np.arange(4), most=2000)
    profile = profile_of(automaton, cycle)
    for q in range(automaton.n_states):
        expected = q in accepted_from(profile, automaton.full) and (q, q, automaton.full) not in profile
        later = profiles.closed_later(q)
        if later is None:
            assert not expected
            continue
        reader, final = later
        assert reader.n_states <= profiles.automaton.n_states
        reached = states_after(reader, cycle)
        assert expected == any(final[state] for state in reached)


@settings(deadline=None, max_examples=100)
@given(formula=FORMULAS, seen=WORDS, cycle=WORDS.filter(len))
@example(formula="FG p | FG q", seen=[2, 1], cycle=[1])
def test_an_automaton_after_a_word_goes_on_from_there(formula, seen, cycle):
    later = table_of(formula).after(seen)
    assert accepts(later, [], cycle) == satisfies(formula, as_letters(seen), as_letters(cycle))


def test_too_many_profiles_are_given_up():
    assert all_profiles(table_of("GF(p & X q) & GF(q & X p)"), np.arange(4), most=3) is None


@pytest.mark.parametrize(
    ("formula", "deterministic"), [("GF p & GF q", True), ("FG p", False), ("G(p -> X q)", True), ("1", True)]
)
def test_deterministic_where_there_is_such_an_automaton(formula, deterministic):
    assert table_of(formula).deterministic is deterministic


def test_an_empty_language_has_no_way_out():
    assert translate("G p & F !p").is_empty()
    assert not accepts(table_of("G p & F !p"), [], [2])


def test_the_size_of_the_papers_automaton():
    formula = "G !a.r3 & GF b.r3 & GF o.r1 & G(o.r1 -> X o.r4) & F p.r4"
    assert buchi_size(formula) == (7, 29)


def test_letters_are_what_the_states_show(case_i):
    scenario, _ = case_i
    system = form(scenario, published_fits(scenario.fits), sum_rule(scenario))
    names = ["a1.pi1", "o1.pi2", "o2.pi4"]
    different, letter = letters(system, names)
    assert len(different) == 8
    for index in range(0, system.n_states, 7):
        shown = letter_of(scenario, system.state(index))
        assert different[letter[index]].tolist() == [name in shown for name in names]


def test_without_propositions_there_is_one_letter(case_i):
    scenario, _ = case_i
    system = form(scenario, published_fits(scenario.fits), sum_rule(scenario))
    different, letter = letters(system, [])
    assert different.shape == (1, 0)
    assert set(letter.tolist()) == {0}


def automaton_of(successors):
    table = np.array(successors)[:, :, None]
    return Automaton(0, table, np.ones_like(table), 1)


@pytest.mark.parametrize(
    ("successors", "expected"),
    [
        ([[0, 1], [0, 1]], True),  # the last letter
        ([[0, 1], [1, 1]], True),  # whether a letter was met
        ([[0, 1], [1, 0]], False),  # parity of a letter
        ([[0, 1], [1, 2], [2, 0]], False),  # number of letters modulo three
        ([[0, -1], [1, 0]], True),
    ],
)
def test_counting_is_recognised(successors, expected):
    assert never_counts(automaton_of(successors)) is expected


@settings(deadline=None, max_examples=100)
@given(formula=FORMULAS, cycle=WORDS.filter(len))
def test_an_automaton_that_never_counts_closes_within_a_round(formula, cycle):
    automaton = table_of(formula)
    if not never_counts(automaton):
        return
    profile = profile_of(automaton, cycle)
    closed = {q for q, target, marks in profile if q == target and marks == automaton.full}
    reaching = {q for q in range(automaton.n_states) if closed & _reachable(profile, q)}
    assert reaching == accepted_from(profile, automaton.full)


def _reachable(profile, state):
    reached, frontier = {state}, [state]
    while frontier:
        q = frontier.pop()
        new = {t for s, t, _ in profile if s == q} - reached
        reached |= new
        frontier += new
    return reached
