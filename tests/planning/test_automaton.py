"""Automata as tables against Spot's own judgement of words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.acceptance import Clause
from drake_ltl.planning.automaton import Automaton, buchi_size, joint, letters, tabulate, translate
from drake_ltl.planning.conjunction import tabulate_all, translate_each
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.orbits import accepted, closed, row_of
from drake_ltl.planning.power import sum_rule
from drake_ltl.planning.profiles import all_profiles
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


def state_after(automaton, word):
    state = automaton.initial
    for letter in word:
        state = automaton.successors[state, letter] if state >= 0 else -1
    return state


def accepted_states(automaton, cycle):
    """States from which the cycle, read for ever, is accepted: by reading on until a state comes again."""
    return {q for q in range(automaton.n_states) if _accepts_from(automaton, q, cycle)}


def _accepts_from(automaton, q, cycle):
    begins, met = [], []
    while q >= 0 and q not in begins:
        begins.append(q)
        marks = 0
        for letter in cycle:
            marks |= int(automaton.marks[q, letter]) if q >= 0 else 0
            q = automaton.successors[q, letter] if q >= 0 else -1
        met.append(marks)
    if q < 0:
        return False
    recurring = {mark for marks in met[begins.index(q) :] for mark in range(marks.bit_length()) if marks >> mark & 1}
    return any(clause.often <= recurring and not clause.never & recurring for clause in automaton.clauses)


def accepts(automaton, prefix, cycle):
    return state_after(automaton, prefix) in accepted_states(automaton, cycle)


def profile(automaton, cycle):
    """What the tables of profiles say of one word: accepted and closed states."""
    row = row_of(automaton, cycle)[None]
    return tuple(set(np.flatnonzero(table(automaton, row)[0]).tolist()) for table in (accepted, closed))


@settings(deadline=None, max_examples=150)
@given(formula=FORMULAS, prefix=WORDS, cycle=WORDS.filter(len))
def test_tables_and_profiles_accept_what_spot_accepts(formula, prefix, cycle):
    expected, automaton = satisfies(formula, as_letters(prefix), as_letters(cycle)), table_of(formula)
    assert accepts(automaton, prefix, cycle) == expected
    good, once = profile(automaton, cycle)
    assert good == accepted_states(automaton, cycle)
    assert once == {q for q in good if state_after(replace(automaton, initial=q), cycle) == q}


@settings(deadline=None, max_examples=100)
@given(formula=FORMULAS, cycle=WORDS.filter(len))
def test_what_loops_may_use_is_what_clauses_ask_for(formula, cycle):
    """A loop closed after one round is accepted by some clause: it keeps to the edges left, and meets all marks."""
    automaton = table_of(formula)
    _, once = profile(automaton, cycle)
    found = set()
    for rules in automaton.for_loops():
        found |= profile(rules, cycle)[1] if (rules.successors >= 0).any() else set()
        assert rules.full > 0
    assert found == once


@settings(deadline=None, max_examples=60)
@given(formula=FORMULAS, cycle=WORDS.filter(len))
def test_the_profiles_of_all_words_are_an_automaton(formula, cycle):
    automaton = table_of(formula)
    profiles = all_profiles(automaton, np.arange(4), most=2000)
    state = state_after(profiles.automaton, cycle)
    found = set(np.flatnonzero(profiles.accepted[state]).tolist()) if state >= 0 else set()
    assert found == accepted_states(automaton, cycle)


@settings(deadline=None, max_examples=60)
@given(formula=FORMULAS, cycle=WORDS.filter(len))
@example(formula="F p & G(q -> X !q) & G(!q -> X q)", cycle=[2])
def test_what_closes_later_is_read_by_a_smaller_automaton(formula, cycle):
    automaton = table_of(formula)
    profiles = all_profiles(automaton, np.arange(4), most=2000)
    good, once = profile(automaton, cycle)
    for q in range(automaton.n_states):
        expected = q in good - once
        later = profiles.closed_later(q)
        if later is None:
            assert not expected
            continue
        reader, final = later
        assert reader.n_states <= profiles.automaton.n_states
        state = state_after(reader, cycle)
        assert expected == (state >= 0 and final[state])


@settings(deadline=None, max_examples=100)
@given(formula=FORMULAS, seen=WORDS, cycle=WORDS.filter(len))
@example(formula="FG p | FG q", seen=[2, 1], cycle=[1])
def test_an_automaton_after_a_word_goes_on_from_there(formula, seen, cycle):
    later = table_of(formula).after(seen)
    assert accepts(later, [], cycle) == satisfies(formula, as_letters(seen), as_letters(cycle))


def test_too_many_profiles_are_given_up():
    with pytest.raises(SearchLimitError, match="more than 3 profiles"):
        all_profiles(table_of("GF(p & X q) & GF(q & X p)"), np.arange(4), most=3)


@pytest.mark.parametrize(
    ("formula", "expected"),
    [("GF p & GF q", [(2, 0)]), ("FG p", [(0, 1)]), ("GF p & FG q", [(1, 1)]), ("FG p | GF q", [(0, 1), (1, 0)])],
)
def test_clauses(formula, expected):
    """Numbers of marks that must recur, and of marks that must not."""
    assert sorted((len(c.often), len(c.never)) for c in table_of(formula).clauses) == expected


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
    table = np.array(successors)
    return Automaton(0, table, np.ones_like(table), (Clause(frozenset({0}), frozenset()),))


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
    assert automaton_of(successors).never_counts is expected


@settings(deadline=None, max_examples=100)
@given(formula=FORMULAS, cycle=WORDS.filter(len))
def test_an_automaton_that_never_counts_closes_within_a_round(formula, cycle):
    automaton = table_of(formula)
    if not automaton.never_counts:
        return
    good, once = profile(automaton, cycle)
    for q in range(automaton.n_states):
        after = state_after(replace(automaton, initial=q), cycle * automaton.n_states)
        assert (after in once) == (q in good)


@settings(deadline=None, max_examples=100)
@given(parts=st.lists(FORMULAS, min_size=1, max_size=3), prefix=WORDS, cycle=WORDS.filter(len))
def test_joint_and_simpler_automata_accept_the_same_words(parts, prefix, cycle):
    formula = " & ".join(f"({part})" for part in parts)
    expected = satisfies(formula, as_letters(prefix), as_letters(cycle))
    plain = tabulate(joint(formula), ATOMS, ALL_LETTERS)
    product = tabulate_all(translate_each(formula), ATOMS, ALL_LETTERS)
    for automaton in (plain, plain.saturated(), plain.reduced(), product, product.saturated().reduced()):
        assert (state_after(automaton, prefix) in accepted_states(automaton, cycle)) == expected


def test_marks_that_make_no_difference_are_set_and_equal_states_made_one():
    """Mark 0 is missing on the way back to state 0; states 1 and 2 are alike; nothing leads to state 3."""
    successors = [[0, 1], [0, 2], [0, 1], [3, 3]]
    automaton = replace(automaton_of(successors), marks=np.array([[1, 1], [0, 0], [0, 0], [0, 0]]))
    saturated = automaton.saturated()
    assert saturated.marks.tolist() == [[1, 1], [1, 0], [1, 0], [0, 0]]
    simpler = saturated.reduced()
    assert simpler.n_states == 2
    assert sorted(simpler.marks.tolist()) == [[1, 0], [1, 1]]


def test_conjunctions_that_spot_cannot_translate_as_a_whole():
    parts = ["G(p -> XXp)", "G(q -> XXr)", "G(s -> XXs)", "GF(t & F(u & Ft))", "G(v -> X(!v U w))", "Fx", "G(y -> XFu)"]
    assert joint(" & ".join(parts)).num_states() <= 512


def test_products_over_letters_have_the_states_that_letters_lead_to():
    """p and q never hold together, so that one of the two is still to come after the first letter."""
    letters_shown = np.array([[True, False], [False, True]])
    assert joint("Fp & Fq").num_states() == 4
    table = tabulate_all(translate_each("Fp & Fq & G !r"), ["p", "q", "r"], np.pad(letters_shown, ((0, 0), (0, 1))))
    assert table.n_states == 4
    assert sorted(table.successors[table.initial].tolist()) == [1, 2]
    assert not (tabulate_all(translate_each("G p & G q"), ["p", "q"], letters_shown).successors >= 0).any()


def test_joint_automata_are_given_up_when_they_grow_too_large(monkeypatch):
    monkeypatch.setattr("drake_ltl.planning.conjunction.MOST_STATES", 20)
    five, letters_shown = translate_each("Fa & Fb & Fc & Fd & Fe"), np.eye(5, dtype=bool)
    with pytest.raises(SearchLimitError, match="more than 20 states"):
        tabulate_all(five, list("abcde"), letters_shown)
    monkeypatch.setattr("drake_ltl.planning.automaton.MOST_STATES", 20)
    with pytest.raises(SearchLimitError, match="more than 20 states"):
        joint("Fa & Fb & Fc & Fd & Fe")
