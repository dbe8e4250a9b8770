"""Missions that cannot be run are refused before they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from drake_ltl.errors import InvalidInputError
from drake_ltl.systems.preflight import check_fields, snapshot


def test_case_ii_can_be_run(program, case_ii, models):
    check_fields(program, case_ii, models)


def test_verification_functions_of_all_relations_that_can_be_realised_are_few_enough_in_case_ii(
    program, case_ii, models
):
    check_fields(program, replace(case_ii, controller=replace(case_ii.controller, lambda_=0.5)), models)


def test_settings_that_allow_no_navigation_function_are_refused(program, case_ii, models):
    scenario = replace(case_ii, controller=replace(case_ii.controller, shaping=len))
    with pytest.raises(InvalidInputError, match=r"controller\.shaping"):
        check_fields(program, scenario, models)


def test_snapshot_stands_where_the_layout_says(mission, models):
    for step in mission.steps:
        found = snapshot(step.before, models)
        for name, stand in step.before.agents.items():
            np.testing.assert_allclose(models.agents[name].centre(found.q[name]), stand.p_WC, atol=1e-5)
