"""Programs with a mistake in them: monitors, verdict and second look find each (benchmarks/mutants.py).

A gradient of the wrong sign in case ii is in test_missions.py; recordings that are spoilt are in tests/verification.
"""

from __future__ import annotations

import dataclasses
import importlib

import pytest

from drake_ltl.verification import verify

pytestmark = pytest.mark.mission


@pytest.fixture(scope="module")
def mutants(request):
    """The module."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(request.config.rootpath / "benchmarks")
        yield importlib.import_module("mutants")


@pytest.fixture(scope="module")
def sound(mutants):
    """A run without a mistake."""
    return mutants.carry_out(mutants.NONE)


def test_nothing_is_found_where_nothing_is_wrong(mutants, sound):
    assert mutants.noticed(sound, mutants.FORMULAS["apart"]) == mutants.Noticed((), (), ())


@pytest.mark.parametrize(
    ("number", "monitors", "verdict", "finding"),
    [
        (0, {"region", "word"}, {"region", "formula"}, "a1 touches ne in step 0"),
        (1, {"lyapunov"}, {"lyapunov", "run"}, "ended after 0 of 2 steps"),
        (2, {"weld"}, {"weld", "run"}, "ended after"),
        (3, {"word"}, {"formula"}, "the word does not satisfy ('X', ('is', 'a1', 'nw'))"),
    ],
    ids=["swapped goals", "wrong sign", "open weld", "negated formula"],
)
def test_every_mistake_is_found_three_times(mutants, number, monitors, verdict, finding):
    mutant = mutants.MUTANTS[number]
    recording = mutants.carry_out(mutant)
    found = mutants.noticed(recording, mutants.FORMULAS[mutant.mission])
    assert monitors <= set(found.monitors)
    assert verdict <= set(found.verdict)
    assert any(one.startswith(finding) for one in found.second_look)
    if mutant.planned_for != ("", ""):  # only the planner was wrong: the run is as it should be, but for what it is for
        assert (set(found.monitors), set(found.verdict)) == (monitors, verdict)


def test_a_pair_that_the_potential_forgets_is_found_by_the_verdict(mutants):
    """Nobody comes near to anybody in this mission: it ends as it should."""
    mutant = mutants.MUTANTS[6]
    assert "lyapunov" in mutants.noticed(mutants.carry_out(mutant), mutants.FORMULAS[mutant.mission]).verdict


@pytest.mark.parametrize("number", [4, 5], ids=["too much", "too little"])
def test_a_team_whose_shares_do_not_add_up_does_not_begin_to_carry(mutants, number):
    """What is held up by a spring is off by a millimetre or two then: no motion shows it."""
    with pytest.raises(ValueError, match="must be positive and of sum 1"):
        mutants.carry_out(mutants.MUTANTS[number])


def test_the_word_is_judged_not_the_plan(sound):
    negated = dataclasses.replace(sound, scenario=sound.scenario.replace('"X nw"', '"!(X nw)"'))
    assert {violation.kind for violation in verify(negated).violations} == {"formula"}
