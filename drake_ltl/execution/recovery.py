"""Carries a mission out although things go wrong: until a fault is noticed, then in safe mode, then on.

Every part of a run has a diagram of its own that begins in the state in which the part before it has ended: the
mission's steps; after a fault what is left of the step that was halted, everybody's release and the way back to a
region for those who can; then the mission that was planned again from what is measured. `joined` makes one recording
of all.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from pydrake.systems.framework import Context

from drake_ltl.diagrams.mission_diagram import MissionDiagram
from drake_ltl.errors import InfeasibleError, SearchLimitError
from drake_ltl.execution.adrift import adrift
from drake_ltl.execution.joined import joined
from drake_ltl.execution.leg import Leg
from drake_ltl.execution.runner import Run, RunProgress
from drake_ltl.execution.situations import situation, whereabouts
from drake_ltl.execution.under_way import Noticed, UnderWay
from drake_ltl.faults.injection import Injector
from drake_ltl.faults.lateness import slowed
from drake_ltl.faults.weights import check_burdens
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.planning.fits import Fits
from drake_ltl.planning.mission import Mission
from drake_ltl.planning.replanning import replan
from drake_ltl.scenario.faults import Fault
from drake_ltl.scenario.model import Scenario

MOST_HALTS = 10
"""Of one run."""


@dataclass(frozen=True)
class FaultRun(Run):
    """A run with what went wrong in it."""

    happened: tuple[tuple[float, Fault], ...] = ()
    """Faults with the times at which they came [s]."""
    noticed: tuple[Noticed, ...] = ()


def RunWithFaults(
    mission: Mission,
    scenario: Scenario,
    models: MeasuredModels,
    fits: Fits,
    *,
    suffix_rounds: int = 1,
    keep_going: bool = False,
    report: Callable[[RunProgress], None] | None = None,
    disturb: Callable[[MissionDiagram, Context], None] | None = None,
) -> FaultRun:
    """Carries a mission out with the scenario's `faults:`; notices them by what is measured, recovers, goes on.

    Args:
        fits: P_{s,0}, for planning again.
        suffix_rounds: rounds of the suffix that are carried out, of the plan that is followed in the end.
        keep_going: what monitors see is recorded, but does not end the run.
        report: called once per simulated second.
        disturb: changes the context in which the run starts.

    Returns:
        The run. If it ends early its recording says why: a step that does not end, or a fault after which nothing lets
        the whole run satisfy the formulas.
    """
    going = UnderWay(scenario, models, fits, suffix_rounds, report, Injector(scenario.faults), keep_going)
    begin, cpu, interrupted = time.perf_counter(), time.process_time(), False
    try:
        leg = Leg.of_mission(going, mission, None)
        if disturb is not None:
            disturb(leg.diagram, leg.context)
        reason = _carry_out(going, leg)
    except KeyboardInterrupt:
        reason, interrupted = "interrupted", True
    seconds = time.perf_counter() - begin, time.process_time() - cpu
    recording = joined(going.parts, reason)
    return FaultRun(
        recording, seconds[0], interrupted, seconds[1], tuple(going.injector.happened), tuple(going.noticed)
    )


def _carry_out(going: UnderWay, leg: Leg) -> str:
    """From its first part on. Empty when the mission is done, else why it cannot be."""
    while True:
        reason = leg.run()
        if reason:
            return reason
        if leg.is_mission and not leg.halted:
            return ""
        if sum(bool(part.halted) for part in going.parts) > MOST_HALTS:
            return f"halted more than {MOST_HALTS} times"
        if text := adrift(leg.bodies, going.losses) or _late(going):
            return _stopped(going, text)
        program = leg.next_program()
        if program.actions:
            leg = Leg.of_program(going, program, leg)
            continue
        try:
            now, seen = situation(leg.bodies, going.losses), whereabouts(going.scenario, going.parts)
            again = replan(going.scenario, going.models.geometry, going.fits, now, seen)
            check_burdens(again.plan, going.losses.masses, going.scenario, going.models)
        except (InfeasibleError, SearchLimitError) as error:
            return _stopped(going, " ".join(str(error).split()))
        _note(going, "planned again")
        leg = Leg.of_mission(going, again, leg)


def _late(going: UnderWay) -> str:
    """Lets the rest of the run bear measurements that come late; what is against that, if anything."""
    try:
        if going.losses.delay:
            going.scenario = slowed(going.scenario, going.models.agents, going.losses.delay)
    except InfeasibleError as error:
        return str(error)
    return ""


def _stopped(going: UnderWay, why: str) -> str:
    """What the run's end is put down to."""
    _note(going, f"stopped: {why}")
    return f"after {going.seen[-1]}; {going.losses}: {why}"


def _note(going: UnderWay, how: str) -> None:
    """How the run went on after what has been seen since it was noted last."""
    new = going.seen[len(going.noticed) :]
    going.noticed += [Noticed(seen, str(going.losses), how) for seen in new]
