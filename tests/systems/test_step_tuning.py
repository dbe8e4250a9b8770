"""The tuner sees the steps as the mission places them."""

from __future__ import annotations

from drake_ltl.navigation.tuning import tune_kappa
from drake_ltl.systems.step_tuning import relations_of_step, tune_steps


def test_steps_are_seen_with_their_movers(program, case_ii, models):
    for number, step in enumerate(program.steps):
        relations = relations_of_step(program, number, case_ii, models)
        movers = [task.agent for task in step.travels] + [task.object for task in step.transports]
        assert (relations is None) == (not movers)
        if relations is not None:
            assert list(relations.movers) == movers


def test_the_report_of_a_step_is_that_of_its_relations(program, case_ii, models):
    tunings = tune_steps(program, case_ii, models, n_starts=1)

    assert sorted(tunings) == [n for n, step in enumerate(program.steps) if step.travels or step.transports]
    first = relations_of_step(program, 0, case_ii, models)
    assert str(tunings[0]) == str(tune_kappa(first, n_starts=1))
    for tuning in tunings.values():
        assert tuning.trials[-1].descents[0].outcome == "goal"
