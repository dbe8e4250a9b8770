"""Simpler lassos of the same cost."""

from __future__ import annotations

from itertools import pairwise

from drake_ltl.planning.bounded.polish import stretched
from drake_ltl.planning.bounded.tidying import earlier, shortened, tidied, without_vain_grasps
from drake_ltl.planning.plan import State
from drake_ltl.planning.words import letter_of, satisfies


def holds(scenario, *formulas):
    """Whether formulas hold on a lasso's word."""

    def is_lasso(run):
        states, loop = run
        word = [letter_of(scenario, state) for state in states]
        return all(satisfies(formula, word[:loop], word[loop:]) for formula in formulas)

    return is_lasso


def test_repeated_states_are_left_out_unless_a_formula_counts_them(make_scenario):
    scenario = make_scenario({"a1": (1.0, "GF pi2 & GF pi1")}, {})
    states = tuple(State((region,), (), (None,)) for region in ("pi1", "pi3", "pi2", "pi1"))
    run = states, 1
    longer = stretched(run, 9)
    assert len(longer[0]) == 9
    assert longer[0][longer[1]] == states[1]
    assert longer[0][longer[1] - 1] == states[0]
    assert shortened(longer, holds(scenario, "GF a1.pi2 & GF a1.pi1")) == run
    counting = holds(scenario, "GF a1.pi2", "a1.pi1 & X a1.pi1")
    assert shortened(longer, counting)[0][:3] == (states[0], states[0], states[1])


def test_a_suffix_keeps_one_state(make_scenario):
    scenario = make_scenario({"a1": (1.0, "1")}, {})
    state = State(("pi1",), (), (None,))
    assert shortened(((state,) * 4, 2), holds(scenario, "1")) in (((state,), 0), ((state, state), 1))


def test_grasps_in_vain_are_left_out_and_others_kept():
    def state(agent, obj, grasp):
        return State((agent,), (obj,), (grasp,))

    vain = state("pi1", "pi1", None), state("pi1", "pi1", "o1"), state("pi1", "pi1", None)
    assert without_vain_grasps((vain, 2)) == ((vain[0],) * 3, 2)
    carries = state("pi1", "pi1", None), state("pi1", "pi1", "o1"), state("pi2", "pi2", "o1"), state("pi2", "pi2", None)
    assert without_vain_grasps((carries, 3)) == (carries, 3)
    for_ever = carries[0], carries[1], carries[1]  # grasps for ever
    assert without_vain_grasps((for_ever, 2)) == ((carries[0],) * 3, 2)
    commutes = carries[0], carries[1], carries[2]  # the grasp goes on through the end of each round
    assert without_vain_grasps((commutes, 1)) == (commutes, 1)


def test_acts_are_brought_forward_as_far_as_room_allows():
    """a1 fetches o1 from pi2 while a2 goes from pi1 to pi3, one after the other."""
    rows = [
        ("pi1", "pi1", "pi2", None),
        ("pi2", "pi1", "pi2", None),
        ("pi2", "pi1", "pi2", "o1"),
        ("pi1", "pi1", "pi1", "o1"),
        ("pi1", "pi1", "pi1", None),
        ("pi1", "pi3", "pi1", None),
    ]
    run = tuple(State((a, b), (o,), (g, None)) for a, b, o, g in rows), 5
    moved, loop = earlier(("o1",), run, lambda before, after: True, lambda: False)
    assert loop == 5
    assert [state.agents for state in moved][:3] == [("pi1", "pi1"), ("pi2", "pi3"), ("pi2", "pi3")]
    assert [state.grasps[0] for state in moved] == [None, None, "o1", "o1", None, None]

    def lonely(before, after):  # a2 waits until the transport is over
        return all(s.agents[1] != "pi3" or s.objects == ("pi1",) for s in (before, after))

    moved, _ = earlier(("o1",), run, lonely, lambda: False)
    assert [state.agents[1] for state in moved] == ["pi1", "pi1", "pi1", "pi3", "pi3", "pi3"]


def test_nobody_joins_a_team_in_the_step_in_which_it_carries():
    rows = [(("pi1", "pi1"), "pi1", ("o1", None)), (("pi2", "pi1"), "pi2", ("o1", None))]
    rows += [(("pi2", "pi2"), "pi2", ("o1", None)), (("pi2", "pi2"), "pi2", ("o1", "o1"))]
    run = tuple(State(agents, (obj,), grasps) for agents, obj, grasps in rows), 3
    moved, _ = earlier(("o1",), run, lambda before, after: True, lambda: False)
    assert [state.grasps[1] for state in moved] == [None, None, "o1", "o1"]
    assert moved[1].agents == ("pi2", "pi2")


def test_formulas_have_the_last_say(make_scenario):
    scenario = make_scenario({"a1": (1.0, "1"), "a2": (1.0, "1")}, {})
    regions = [("pi1", "pi1"), ("pi2", "pi1"), ("pi2", "pi2")]
    run = tuple(State(pair, (), (None, None)) for pair in regions), 2
    together = tidied((), run, holds(scenario, "F a2.pi2"), lambda a, b: True, lambda: False)
    assert [state.agents for state in together[0]] == [("pi1", "pi1"), ("pi2", "pi2")]
    alone = tidied((), run, holds(scenario, "F(a1.pi2 & !a2.pi2)"), lambda a, b: True, lambda: False)
    assert alone == run
    assert all(before != after for before, after in pairwise(alone[0]))
