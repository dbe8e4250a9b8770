"""The certificate refuses plans that were tampered with, and says what is wrong."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import pytest

from drake_ltl.errors import CertificateError
from drake_ltl.planning.actions import actions_between, apply_actions
from drake_ltl.planning.certificate import check, transition_fault
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.plan import Action, State
from drake_ltl.planning.planner import plan
from drake_ltl.planning.power import sum_rule
from drake_ltl.planning.transition_system import form
from drake_ltl.planning.words import satisfies


@pytest.fixture(scope="module")
def planned(case_ii):
    scenario, start = case_ii
    fits = published_fits(scenario.fits)
    return plan(scenario, start, fits), scenario, start, fits


def with_moves(found, scenario):
    """The plan with actions and costs that agree with its states."""
    run = (*found.states, found.suffix[0])
    moves = tuple(actions_between(scenario, a, b) for a, b in pairwise(run))
    return replace(found, moves=moves)


def test_an_honest_plan_passes(planned):
    check(*planned)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"prefix_cost": 4940.0}, "prefix is said to cost 4940.0"),
        ({"suffix_cost": float("nan")}, "suffix is said to cost nan"),
        ({"lower_bound": 7000.0}, "no lower bound"),
        ({"lower_bound": 8000.0, "status": "feasible"}, "no lower bound"),
        ({"suffix": ()}, "suffix is empty"),
        ({"moves": ()}, "0 moves"),
    ],
)
def test_wrong_numbers_and_shapes(planned, changes, message):
    found, *rest = planned
    with pytest.raises(CertificateError, match=message):
        check(replace(found, **changes), *rest)


def test_another_start(planned):
    found, scenario, _, fits = planned
    with pytest.raises(CertificateError, match="begins in"):
        check(found, scenario, found.states[1], fits)


def test_wrong_actions(planned):
    found, *rest = planned
    idle = (*found.moves[:1], (), *found.moves[2:])
    with pytest.raises(CertificateError, match=r"step 2, .*actions"):
        check(replace(found, moves=idle), *rest)


def test_an_illegal_transition(planned):
    found, scenario, *rest = planned
    shorter = replace(found, prefix=found.prefix[:2] + found.prefix[3:])
    with pytest.raises(CertificateError, match="step 2"):
        check(with_moves(shorter, scenario), scenario, *rest)


def test_a_wrong_word(planned):
    """Staying where nothing more happens is legal and free, but no plan."""
    found, scenario, start, fits = planned
    lazy = replace(found, prefix=(), suffix=(start,), prefix_cost=0.0, suffix_cost=0.0, lower_bound=0.0)
    with pytest.raises(CertificateError, match="does not satisfy"):
        check(with_moves(lazy, scenario), scenario, start, fits)


def test_a_team_without_power_and_a_full_region(planned):
    found, scenario, start, fits = planned
    with pytest.raises(CertificateError, match=r"cannot carry o2 \(5\)"):
        check(found, scenario, start, fits, can_carry=lambda obj, team: obj != "o2")
    with pytest.raises(CertificateError, match="no room for"):
        check(found, scenario, start, lambda region, content: not content.carried)


FREE, HOLD = (None, None), ("o1", "o1")


@pytest.mark.parametrize(
    ("before", "after", "fault"),
    [
        ((("pi1", "pi1"), ("pi1", "pi2"), FREE), (("pi2", "pi1"), ("pi1", "pi2"), FREE), None),
        ((("pi1", "pi1"), ("pi1", "pi2"), FREE), (("pi1", "pi1"), ("pi1", "pi2"), HOLD), None),
        ((("pi1", "pi1"), ("pi1", "pi2"), HOLD), (("pi2", "pi2"), ("pi2", "pi2"), HOLD), None),
        ((("pi2", "pi1"), ("pi1", "pi2"), FREE), (("pi1", "pi1"), ("pi1", "pi2"), ("o1", None)), "1, 2"),
        ((("pi1", "pi1"), ("pi1", "pi2"), ("o1", None)), (("pi2", "pi1"), ("pi1", "pi2"), FREE), "1, 2"),
        ((("pi1", "pi1"), ("pi1", "pi1"), ("o1", None)), (("pi1", "pi1"), ("pi1", "pi1"), ("o2", None)), "3"),
        ((("pi1", "pi1"), ("pi1", "pi2"), FREE), (("pi1", "pi1"), ("pi3", "pi2"), FREE), "4"),
        (
            (("pi1", "pi1"), ("pi1", "pi2"), HOLD),
            (("pi3", "pi1"), ("pi3", "pi2"), ("o1", None)),
            "4",
        ),
        (
            (("pi1", "pi1"), ("pi1", "pi2"), ("o1", None)),
            (("pi3", "pi1"), ("pi3", "pi2"), ("o1", None)),
            "5",
        ),
        ((("pi1", "pi1"), ("pi1", "pi2"), HOLD), (("pi2", "pi1"), ("pi1", "pi2"), HOLD), "grasps o1 in pi1"),
    ],
)
def test_the_clauses_of_def_5(case_i, before, after, fault):
    scenario, _ = case_i
    found = transition_fault(scenario, State(*before), State(*after), lambda region, content: True, sum_rule(scenario))
    if fault is None:
        assert found is None
    else:
        assert fault in found


def test_actions_lead_from_state_to_state(case_i):
    scenario, _ = case_i
    system = form(scenario, published_fits(scenario.fits), sum_rule(scenario))
    for edge in range(0, system.n_transitions, 11):
        before, after = (system.state(int(end[edge])) for end in (system.sources, system.targets))
        actions = actions_between(scenario, before, after)
        assert apply_actions(scenario, before, actions) == after
        assert sum(len(action.agents) for action in actions) == system.actions[edge]


def test_a_transport_is_one_action_of_its_team(case_i):
    scenario, _ = case_i
    before = State(("pi1", "pi1"), ("pi1", "pi2"), HOLD)
    after = State(("pi4", "pi4"), ("pi4", "pi2"), HOLD)
    carried = Action("transport", ("a1", "a2"), "pi1", "pi4", "o1")
    assert actions_between(scenario, before, after) == (carried,)


@pytest.mark.parametrize(
    ("formula", "prefix", "cycle", "expected"),
    [
        ("GF p & GF !p", [], ["p", ""], True),
        ("FG p", ["", ""], ["p"], True),
        ("G p", [""], ["p"], False),
        ("X p", [], ["", "p"], True),
        ("m.p & !m.q", [], ["m.p"], True),
        ("1", [], [""], True),
        ("0", [], [""], False),
    ],
)
def test_words(formula, prefix, cycle, expected):
    def letters(word):
        return [frozenset(letter.split()) for letter in word]

    assert satisfies(formula, letters(prefix), letters(cycle)) is expected


def test_a_word_never_ends():
    with pytest.raises(ValueError, match="at least one letter"):
        satisfies("1", [], [])
