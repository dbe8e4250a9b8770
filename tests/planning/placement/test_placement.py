"""Placed missions against a checker that knows distances alone."""

from __future__ import annotations

from drake_ltl.planning.placement import place


def test_table_2_of_the_paper_is_placed(case_ii, tools):
    mission = place(case_ii.plan, case_ii.scenario, case_ii.geometry, case_ii.starts)
    assert tools.violations(mission, case_ii.scenario, case_ii.geometry, case_ii.starts, margin=0.1 - 0.05) == []
    assert (len(mission.steps), mission.loop) == (len(case_ii.plan.states), case_ii.plan.loop)
