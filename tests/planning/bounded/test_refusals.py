"""What is learnt from lassos that are none."""

from __future__ import annotations

from drake_ltl.planning.bounded.problem import Problem
from drake_ltl.planning.bounded.refusals import Refusals
from drake_ltl.planning.plan import State
from drake_ltl.planning.power import sum_rule


def at(*regions):
    return State(regions, (), (None,) * len(regions))


def test_what_is_refused_stays_refused_when_nothing_is_left_to_learn(make_scenario):
    """Two threads of the solver may offer the same run before either learns of the cut."""
    scenario = make_scenario({"a1": (1.0, "1"), "a2": (1.0, "1")}, {})
    problem = Problem(scenario, at("pi1", "pi1"), sum_rule(scenario), True)
    refusals = Refusals(problem, lambda region, content: region.name != "pi3" or len(content.free_agents) < 2)
    crowded, roomy = (((at("pi1", "pi1"), at("pi3", other)), 1) for other in ("pi3", "pi2"))
    assert refusals.find(crowded)
    assert len(refusals.cuts) == 1
    assert refusals.find(crowded)
    assert len(refusals.cuts) == 1
    assert not refusals.find(roomy)
