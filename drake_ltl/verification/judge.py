"""From a recording to its verdict: all checks, in order."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, replace

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.execution.recording_versions import whose_potential
from drake_ltl.scenario import Scenario, loads
from drake_ltl.scenario.table import printable
from drake_ltl.verification.arrivals import arrival_violations
from drake_ltl.verification.befallen import befallen, moved_since
from drake_ltl.verification.blocked import blocked_violations
from drake_ltl.verification.bodies import body_violations
from drake_ltl.verification.clearances import (
    KINDS,
    clearance_violations,
    least_of_each_kind,
    step_clearances,
)
from drake_ltl.verification.data import data_violations, finite_part
from drake_ltl.verification.detours import detoured_steps, exchanged_steps
from drake_ltl.verification.drives import arrival_turns, drive_violations, slides
from drake_ltl.verification.expected import CanCarry, Expected, action_violations, expectations, powers_add_up
from drake_ltl.verification.grasps import WeldErrors, grasp_violations, weld_errors, weld_violations
from drake_ltl.verification.headings import heading_errors, heading_violations
from drake_ltl.verification.inside_teams import inside_team_violations, inside_teams
from drake_ltl.verification.intervals import interval_violations
from drake_ltl.verification.left_alone import left_alone_violations
from drake_ltl.verification.lyapunov import lyapunov_rises, lyapunov_violations
from drake_ltl.verification.mechanics import Mechanics
from drake_ltl.verification.motion import motion_violations
from drake_ltl.verification.objects import broken_grasp_violations, largest_tilt, object_violations
from drake_ltl.verification.pushes import push_violations
from drake_ltl.verification.regions import found_at, region_violations, start_violations
from drake_ltl.verification.rest import rest_violations
from drake_ltl.verification.roles import Roles, step_roles
from drake_ltl.verification.sizes import radius_violations
from drake_ltl.verification.soundness import check_sound
from drake_ltl.verification.spans import Span, step_spans
from drake_ltl.verification.starts import start_pose_violations
from drake_ltl.verification.stops import stop_violations
from drake_ltl.verification.verdict import Verdict
from drake_ltl.verification.violations import Violation, merged
from drake_ltl.verification.word import readings, word_violations


def verify(
    recording: Recording,
    scenario: Scenario | None = None,
    mechanics: Mechanics | None = None,
    *,
    can_carry: CanCarry | None = None,
) -> Verdict:
    """Judges a run by its recording alone.

    The recording has to agree with itself and with the scenario's models: spheres with joints, positions with
    velocities, grippers with what they hold, V with the motion. Of the motion every premise and every clause of
    Defs. 1 to 4 is judged (regions, clearances, regions that are to be kept away from, grasps), V that does not
    increase, rest at the ends of steps, and the temporal logic formulas on the word that the poses spell. A run that
    ends early is judged as far as it goes, and violated.

    Args:
        scenario: what the run should do; by default what the recording's own text says.
        mechanics: what the scenario's models make of the recorded joints; by default worked out with Drake
            (`models.work_out`), which takes the longest of all.
        can_carry: Lambda; by default the powers of a team must add up to what the object needs.

    Raises:
        InvalidInputError: it is no recording of its scenario, or a model cannot be used.
        MissingDependencyError: Spot is not installed.
    """
    if scenario is None:
        scenario = loads(recording.scenario, source_name="the recording's scenario", check_models=mechanics is None)
    check_sound(recording, scenario)
    violations = [*data_violations(recording, scenario)]
    if not recording.completed:
        violations.append(_stopped(recording))
    violations += _monitored(recording)
    whole, recording = recording, finite_part(recording)
    if not len(recording.time):
        return Verdict(False, tuple(violations), (), whole.steps, dict.fromkeys(KINDS), 0.0, 0.0, 0.0, 0.0, 0.0)
    if mechanics is None:
        from drake_ltl.verification.models import work_out  # loads Drake

        mechanics = work_out(recording, scenario)
    if _too_old(recording):
        violations.append(Violation("data", (), "the recording is too old to say what V is a function of"))
        mechanics = dataclasses.replace(mechanics, lyapunov=recording.lyapunov)
    run = _run(recording, scenario)
    welds = weld_errors(recording, mechanics, run.spans, befallen(recording, scenario, "weld_breaks"))
    clearances = [c for pair in run.pairs for c in step_clearances(recording, scenario, *pair, welds.open)]
    rises = lyapunov_rises(recording, mechanics.lyapunov, run.spans, moved_since(recording, scenario))
    nearest = inside_teams(recording, mechanics, run.spans, run.roles)
    turned = heading_errors(recording, scenario, run.spans, run.roles)
    aside, arrived = slides(recording, scenario), arrival_turns(recording, scenario, run.spans, run.roles)
    states = readings(recording, scenario, run.spans)
    violations += start_pose_violations(recording, scenario)
    violations += radius_violations(recording, mechanics)
    violations += motion_violations(recording, run.spans)
    if not _too_old(recording):
        violations += interval_violations(recording, run.spans, mechanics.goals)
        violations += arrival_violations(recording, scenario, run.spans, mechanics.limits)
        stopped = befallen(recording, scenario, "agent_stops")
        violations += left_alone_violations(recording, run.spans, run.roles, welds.open, stopped)
    violations += action_violations(run.expected, run.spans, recording.time, can_carry or powers_add_up(scenario))
    violations += clearance_violations(clearances)
    violations += inside_team_violations(nearest)
    violations += _conduct_violations(recording, scenario, run, mechanics, welds)
    violations += stop_violations(recording, scenario)
    violations += blocked_violations(recording, scenario, run.spans)
    violations += heading_violations(recording, scenario, run.spans, turned)
    violations += drive_violations(recording, scenario, run.spans, aside, arrived)
    exact = not any(fault.kind == "sensors" for fault in scenario.faults)
    violations += lyapunov_violations(recording, mechanics.lyapunov, run.spans, run.roles, rises, exact=exact)
    violations += word_violations(recording, scenario, states)
    return Verdict(
        satisfied=not violations,
        violations=merged(violations),
        word=tuple(tuple(sorted(state.letter)) for state in states),
        steps=whole.steps,
        min_clearance=least_of_each_kind(clearances),
        max_lyapunov_increase=float(rises.max()),
        max_weld_error=float(welds.gap.max(initial=0.0)),
        max_weld_angle=float(welds.angle.max(initial=0.0)),
        max_tilt=largest_tilt(recording),
        min_inside_teams=min((pair.distance for pair in nearest), default=None),
        max_heading_error=max(turned.values(), default=None),
        max_arrival_turn=max(arrived.values(), default=None),
        max_slide=max((float(speed.max()) for speed in aside.values()), default=None),
        simulated_seconds=float(recording.time[-1] - recording.time[0]),
        detours=detoured_steps(recording),
        exchanges=exchanged_steps(recording),
        version_of_V=whose_potential(recording.lacks),
        max_effort=_by_agent(recording, recording.agents, "effort", np.max),
        min_manipulability=_by_agent(recording, mechanics.gripper, "manipulability", np.min),
    )


@dataclass(frozen=True)
class _Run:
    """What should happen, step by step."""

    spans: tuple[Span, ...]
    roles: tuple[Roles, ...]
    expected: tuple[Expected, ...]
    """Before each span and after the last."""

    @property
    def pairs(self) -> Iterator[tuple[Span, Roles]]:
        return zip(self.spans, self.roles, strict=True)


def _run(recording: Recording, scenario: Scenario) -> _Run:
    """Regions of the start are read off the poses; nobody grasps anything yet (a scenario cannot say otherwise)."""
    spans = step_spans(recording)
    start = replace(found_at(recording, scenario, 0), grasps=dict.fromkeys(recording.agents))
    expected = expectations(start, spans, lambda sample: found_at(recording, scenario, sample))
    roles = [step_roles(before, span) for before, span in zip(expected, spans, strict=False)]
    return _Run(spans, tuple(roles), tuple(expected))


def _conduct_violations(
    recording: Recording, scenario: Scenario, run: _Run, mechanics: Mechanics, welds: WeldErrors
) -> Iterator[Violation]:
    """Everybody where they should be, welded to what they should hold, at rest when a step ends."""
    pushed, breaks = (befallen(recording, scenario, kind) for kind in ("push", "weld_breaks"))
    yield from start_violations(recording, run.expected[0])
    for index, (span, roles) in enumerate(run.pairs):
        before, after = run.expected[index], run.expected[index + 1]
        yield from region_violations(recording, scenario, span, roles, before, after)
        yield from grasp_violations(recording, span, roles, before, after)
        yield from weld_violations(recording, welds, span, scenario.tolerances)
        yield from broken_grasp_violations(recording, welds.open, span, roles)
        yield from body_violations(recording, mechanics, span, roles, breaks)
        yield from rest_violations(recording, span, scenario.tolerances)
    yield from object_violations(recording, run.spans, run.roles, scenario.tolerances, pushed, breaks)
    yield from push_violations(recording, scenario, mechanics, run.spans, run.roles)


def _stopped(recording: Recording) -> Violation:
    number = recording.steps[-1].number if recording.steps else None
    reason = printable(recording.reason) or "no reason is recorded"
    return Violation("run", (), f"the run ended early: {reason}", _end(recording), number)


def _monitored(recording: Recording) -> Iterator[Violation]:
    """What the run's monitors saw, but for what ended it: whether it is seen anew here or not, all was not well."""
    for seen in recording.monitored:
        if not recording.reason.endswith(str(seen)):
            what = printable(f"the {seen.monitor} monitor saw: {seen.what}")
            yield Violation(
                "monitor", seen.who, what, seen.time, seen.step, seen.value, seen.time, printable(seen.unit)
            )


def _too_old(recording: Recording) -> bool:
    """Whether all that is known of V is what the controllers wrote down; no run is satisfied on their word."""
    return "intervals" in recording.lacks


def _by_agent(
    recording: Recording, agents: Collection[str], field: str, extreme: Callable[..., np.ndarray]
) -> dict[str, float]:
    """The extreme of a field for each of the agents; empty if the recording is too old to have it."""
    if field in recording.lacks:
        return {}
    found = zip(recording.agents, extreme(getattr(recording, field), axis=0).tolist(), strict=True)
    return {name: value for name, value in found if name in agents}


def _end(recording: Recording) -> float | None:
    return float(recording.time[-1]) if len(recording.time) else None
