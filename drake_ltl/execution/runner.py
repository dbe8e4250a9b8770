"""Carries a mission out: advances the Simulator, switches welds in between, watches the clock, records."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from pydrake.systems.analysis import Simulator, SimulatorStatus
from pydrake.systems.framework import Context

from drake_ltl.diagrams.mission_diagram import MissionDiagram
from drake_ltl.errors import DrakeLtlError, ExecutionError
from drake_ltl.execution.grasping import ApplyGrasps
from drake_ltl.execution.log_reader import read_logs
from drake_ltl.execution.recording import Recording
from drake_ltl.execution.resting import Resting
from drake_ltl.scenario import loads
from drake_ltl.systems.signals import Phase

REPORT_PERIOD = 1.0
"""Simulated time between reports of progress and looks at the step's time limit [s]."""


@dataclass(frozen=True)
class RunProgress:
    """What a run says of itself while it goes on."""

    time: float
    """Simulated [s]."""
    step: int
    """Steps done."""
    num_steps: int
    waiting_for: tuple[str, ...]


class Pace(Protocol):
    """Somebody who watches a run and may hold it up."""

    @property
    def period(self) -> float:
        """Simulated time after which `hold` is called again [s]."""

    def hold(self, simulator: Simulator) -> None:
        """Called between advances; returns when the run may go on."""

    def finish(self, simulator: Simulator, reason: str) -> None:
        """Called when the run is over, with the reason if it ended early."""


@dataclass(frozen=True)
class Run:
    """A recording, and how long the run took by the wall's clock (which no recording carries)."""

    recording: Recording
    wall_seconds: float
    interrupted: bool = False
    """By KeyboardInterrupt, that is, by Ctrl-C."""
    cpu_seconds: float = 0.0
    """Of this process, in the same time."""

    def __repr__(self) -> str:
        name = loads(self.recording.scenario, check_models=False).name
        steps = sum(step.finished for step in self.recording.steps)
        end = f", ended early: {self.recording.reason}" if self.recording.reason else ""
        return (
            f"Run({name!r}, {steps} steps, {self.recording.time[-1]:.1f} s simulated in {self.wall_seconds:.1f} s{end})"
        )


def RunMission(
    mission: MissionDiagram,
    *,
    num_steps: int,
    report: Callable[[RunProgress], None] | None = None,
    simulator: Simulator | None = None,
    keep_going: bool = False,
    pace: Pace | None = None,
) -> Run:
    """Runs until `num_steps` steps are done, a monitor sees something wrong, a step exceeds its time limit, a check
    fails, or Ctrl-C.

    Whatever of these ends the run, the recording holds all that happened until then and says why it ended. Other
    exceptions are defects of a program, and pass.

    Args:
        report: called once per simulated second, with a pace oftener.
        simulator: one whose context is the diagram's (`CreateStartContext`); made here if not given.
        keep_going: what monitors see is recorded, but does not end the run.
        pace: somebody who watches; without one the run is as fast as the computer.
    """
    simulator = Simulator(mission.diagram, mission.CreateStartContext()) if simulator is None else simulator
    begin, cpu, interrupted = time.perf_counter(), time.process_time(), False
    try:
        reason = _advance(mission, simulator, num_steps, report, pace, keep_going)
    except KeyboardInterrupt:
        reason, interrupted = "interrupted", True
    except (DrakeLtlError, RuntimeError) as error:  # Drake's own checks raise RuntimeError
        reason = " ".join(str(error).split())
    if pace is not None:
        pace.finish(simulator, reason)
    wall_seconds, cpu_seconds = time.perf_counter() - begin, time.process_time() - cpu
    return Run(read_logs(mission, simulator.get_context(), num_steps, reason), wall_seconds, interrupted, cpu_seconds)


def _advance(
    mission: MissionDiagram,
    simulator: Simulator,
    num_steps: int,
    report: Callable[[RunProgress], None] | None,
    pace: Pace | None,
    keep_going: bool,
) -> str:
    """Empty when the mission is done, else why it cannot be, or should not go on."""
    context = simulator.get_mutable_context()
    supervisor = mission.supervisor
    supervisor_context, resting = supervisor.GetMyContextFromRoot(context), Resting(mission)
    _expect_own(mission, simulator.Initialize())
    while True:
        if supervisor.GetProgress(supervisor_context).phase is Phase.DONE:
            look_once_more(mission, context)
        seen = mission.violations(context)
        if seen and not keep_going:
            return f"a monitor saw: {seen[0]}"
        if supervisor.grasps_pending(supervisor_context):
            ApplyGrasps(mission, context)
        resting.look(context)
        progress = supervisor.GetProgress(supervisor_context)
        if progress.phase is Phase.DONE:
            return ""
        waiting = supervisor.waiting_for(supervisor_context)
        if report is not None:
            report(RunProgress(context.get_time(), progress.count, num_steps, tuple(waiting)))
        limit = mission.scenario.simulation.step_time_limit
        if context.get_time() - progress.step_start > limit:
            return f"step {progress.count + 1} did not finish within {limit:g} s: {'; '.join(waiting)}"
        if pace is not None:
            pace.hold(simulator)
        period = REPORT_PERIOD if pace is None else pace.period
        _expect_own(mission, simulator.AdvanceTo(_next_boundary(mission, context.get_time(), period)))


def _next_boundary(mission: MissionDiagram, now: float, period: float) -> float:
    """A time of a plant's step, to the last bit: else the boundary would be a sample of its own next to the step's."""
    time_step = mission.transport_plant.plant.time_step()
    return max(round((now + period) / time_step), round(now / time_step) + 1) * time_step


def look_once_more(mission: MissionDiagram, root_context: Context) -> None:
    """The last step's end need not be an instant at which monitors look."""
    for monitor in mission.monitors.values():
        monitor.Look(monitor.GetMyContextFromRoot(root_context))


def _expect_own(mission: MissionDiagram, status: SimulatorStatus) -> None:
    """The supervisor and monitors alone end an advance early; another system that does so ends the run."""
    stopped = status.reason() != SimulatorStatus.ReturnReason.kReachedBoundaryTime
    if stopped and not any(status.system() is own for own in (mission.supervisor, *mission.monitors.values())):
        raise ExecutionError(status.FormatMessage())
