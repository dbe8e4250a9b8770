"""A whole recovery: noticed, halted, planned again, carried out by somebody else, and judged as one run."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

from drake_ltl import mission
from drake_ltl.errors import InvalidInputError
from drake_ltl.execution.recording import Recording
from drake_ltl.verification import verify

NOTICED_WITHIN = 0.25
"""What docs/faults.md promises of an agent that stops on its way [s]."""


def test_it_is_noticed_soon_and_somebody_else_goes_on(recovered, traveller):
    run, _ = recovered
    ((time, fault),) = run.happened
    assert (time, fault.who) == (1.5, traveller)
    (noticed,) = run.noticed
    assert noticed.seen.who == (traveller,)
    assert time <= noticed.seen.time <= time + NOTICED_WITHIN
    assert noticed.went_on == "planned again"
    travels = [action["agents"] for step in run.recording.steps for action in step.actions]
    (other,) = {"a1", "a2"} - {traveller}
    assert [traveller] in travels[:1]
    assert [other] in travels[1:]


def test_the_parts_are_one_run(recovered):
    recording = recovered[0].recording
    np.testing.assert_allclose(np.diff(recording.time), 0.005, rtol=1e-6)
    assert [step.number for step in recording.steps] == list(range(len(recording.steps)))
    assert [bool(step.halted) for step in recording.steps] == [True, *[False] * (len(recording.steps) - 1)]
    assert recording.completed


def test_the_whole_run_is_judged_and_satisfied(recovered):
    run, scenario = recovered
    verdict = verify(run.recording, scenario)
    assert verdict.satisfied, [str(violation) for violation in verdict.violations]
    assert len(verdict.word) == len(run.recording.steps) + 1


def test_a_file_says_the_same(recovered, tmp_path):
    run, scenario = recovered
    run.recording.save(tmp_path / "run.npz")
    again = Recording.load(tmp_path / "run.npz")
    assert again.steps == run.recording.steps
    assert verify(again).satisfied
    assert scenario.faults  # which the recording's text has as well


def test_who_hides_the_fault_is_found_out(recovered):
    """Without a word of a fault a mover has to be where its action leads."""
    run, scenario = recovered
    first, *rest = run.recording.steps
    silent = dataclasses.replace(run.recording, steps=(dataclasses.replace(first, halted="", faulty=()), *rest))
    assert any("has not come to" in violation.what for violation in verify(silent, scenario).violations)


def test_only_scenarios_with_faults_have_steps_that_are_halted(recovered, relay):
    with pytest.raises(InvalidInputError, match="was halted by a fault; its scenario has no `faults`"):
        verify(recovered[0].recording, relay[0])


def test_a_fault_befalls_members_alone(recovered):
    run, scenario = recovered
    first, *rest = run.recording.steps
    other = dataclasses.replace(run.recording, steps=(dataclasses.replace(first, faulty=("nobody",)), *rest))
    with pytest.raises(InvalidInputError, match="a fault befell nobody"):
        verify(other, scenario)


def test_who_stands_stays_out_of_the_way(recovered, traveller):
    """Brakes are on: it does not move any more."""
    recording = recovered[0].recording
    after = recording.time > recovered[0].noticed[0].seen.time
    way = recording.centre[traveller][after]
    assert np.abs(way - way[0]).max() < 1e-3  # brakes are dampers: they creep


def test_without_anybody_else_the_run_ends_with_the_reason(relay, with_fault):
    _, models, planned = relay
    scenario = with_fault(*(f"{{kind: agent_stops, agent: {name}, time: 0.5}}" for name in ("a1", "a2")))
    run = mission.simulate(planned, scenario, models, announce=lambda line: None)
    assert not run.recording.completed
    assert "a1 is out of service; a2 is out of service: no run" in run.recording.reason
    assert "satisfies the global formula" in run.recording.reason
    assert [noticed.went_on.split(":")[0] for noticed in run.noticed] == ["planned again", "stopped"]


def test_what_is_not_for_such_runs_is_refused(relay, with_fault):
    _, models, planned = relay
    with pytest.raises(InvalidInputError, match="has no live pages"):
        mission.simulate(planned, with_fault("{kind: sensors, delay: 0.01}"), models, live=True)


# The monitors that watch every run.


def test_who_coasts_and_cannot_be_held_ends_the_run(relay, traveller, with_fault):
    """Before it is out of the workspace, and with the reason; that it coasts is no part of any fault."""
    _, models, planned = relay
    scenario = with_fault(f"{{kind: agent_stops, agent: {traveller}, time: 1.5, how: limp}}")
    run = mission.simulate(planned, scenario, models, announce=lambda line: None)
    assert re.search(rf"{traveller} coasts at .* nobody can hold it, .* within [\d.]+ s", run.recording.reason)
    assert run.noticed[-1].went_on.startswith(f"stopped: {traveller} coasts")
    assert run.recording.monitored == ()
    verdict = verify(run.recording, scenario)
    assert [v.who for v in verdict.violations if "under no navigation function" in v.what] == [(traveller,)]


def test_who_is_slowed_by_friction_is_waited_for(relay, traveller, with_fault):
    """From 2 m/s 1.5 kg go 0.38 m on against 8 N s/m: less than the 50 cm that a mover may brake."""
    _, models, planned = relay
    scenario = with_fault(f"{{kind: agent_stops, agent: {traveller}, time: 1.5, how: limp, friction: 8.0}}")
    run = mission.simulate(planned, scenario, models, announce=lambda line: None)
    halted = next(step for step in run.recording.steps if step.halted)
    end = np.searchsorted(run.recording.time, halted.start + halted.duration)
    assert np.abs(run.recording.qd[traveller][end, :2]).max() <= 0.02  # as everybody else in safe mode
    assert run.noticed[-1].went_on == "planned again"
    assert verify(run.recording, scenario).satisfied


def test_a_run_that_recovers_has_nothing_for_them_to_see(recovered):
    assert recovered[0].recording.monitored == ()
