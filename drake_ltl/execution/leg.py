"""One part of a run, with a diagram of its own: carried out until it is done or halted, then made safe."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Set
from dataclasses import replace

import numpy as np
from pydrake.systems.analysis import Simulator, SimulatorStatus
from pydrake.systems.framework import Context

from drake_ltl.diagrams.fault_parts import FaultParts
from drake_ltl.diagrams.mission_diagram import MakeMissionDiagram, MissionDiagram
from drake_ltl.diagrams.transport_plant import TransportPlant
from drake_ltl.errors import DrakeLtlError, ExecutionError
from drake_ltl.execution.grasping import ApplyGrasps
from drake_ltl.execution.joined import Part
from drake_ltl.execution.log_reader import read_logs
from drake_ltl.execution.runner import REPORT_PERIOD, RunProgress, look_once_more
from drake_ltl.execution.under_way import UnderWay
from drake_ltl.faults.legs import Bodies, finishing, gathering, releasing, sound
from drake_ltl.faults.losses import CLOCK, DOOR
from drake_ltl.monitoring.violation import Violation
from drake_ltl.planning.mission import Mission
from drake_ltl.systems.program import MissionProgram, StepProgram
from drake_ltl.systems.signals import NO_GRASP, Mode, Phase

LOOK = 0.02
"""How often it is looked whether a fault is due that waits for a step or a grasp, and whether all rest [s]."""
BRAKING_LIMIT = 10.0
"""After so long in safe mode those who do not rest are left alone [s]."""
LOST_LIMIT = 3.0
"""... and those who are out of service after so long [s], unless they come to rest by themselves: halve their speed."""
MOST_LOWERINGS = 5
"""Of what is held: more is not tried if it does not come to lie flat."""
ALWAYS_MONITORS = frozenset({"geometry"})
"""Of the monitors of docs/monitors.md, what keeps its meaning even while everybody goes to some region."""
MONITORS = ALWAYS_MONITORS | {"spheres", "arrival"}
"""While a plan is carried out ..."""
FIRST_MONITORS = MONITORS | {"word"}
"""... and while it is the first one: later ones begin with the word so far."""


class Leg:
    """One part of a run, with its diagram."""

    def __init__(self, going: UnderWay, diagram: MissionDiagram, context: Context, num_steps: int, is_mission: bool):
        self.going, self.diagram, self.num_steps, self.is_mission = going, diagram, num_steps, is_mission
        self.halted = ""
        self._first_step, self._known = going.first_step, len(going.seen)
        self._simulator = Simulator(diagram.diagram, context)
        self._context = self._simulator.get_mutable_context()
        self._own = diagram.supervisor.GetMyMutableContextFromRoot(self._context)
        self._step: StepProgram | None = None

    @staticmethod
    def of_mission(going: UnderWay, mission: Mission, before: Leg | None) -> Leg:
        """The steps of a plan; `before` is the part that it follows."""
        steps = len(mission.plan.prefix) + going.suffix_rounds * len(mission.plan.suffix)
        faults = FaultParts(going.first_step, going.ignored, going.losses.regions)
        monitors = FIRST_MONITORS if before is None else MONITORS
        diagram = MakeMissionDiagram(
            mission, going.scenario, going.models, num_steps=steps, monitors=monitors, faults=faults
        )
        context = diagram.CreateStartContext() if before is None else _going_on(diagram, before)
        return Leg(going, diagram, context, steps, True)

    @staticmethod
    def of_program(going: UnderWay, step: StepProgram, before: Leg) -> Leg:
        """One step of its own."""
        old = before.diagram.program
        program = MissionProgram(old.mission, (step,), 0, old.welds)
        diagram = MakeMissionDiagram(
            old.mission,
            going.scenario,
            going.models,
            num_steps=1,
            program=program,
            holds=before.holds(),
            monitors=ALWAYS_MONITORS,
            faults=FaultParts(going.first_step, going.ignored, going.losses.regions),
        )
        return Leg(going, diagram, _going_on(diagram, before), 1, False)

    @property
    def context(self) -> Context:
        return self._context

    @property
    def bodies(self) -> Bodies:
        """Where everything is."""
        measured = self.diagram.supervisor.measured(self._own)
        return Bodies(self.going.scenario, self.going.models, measured)

    def holds(self) -> dict[str, int]:
        """agent -> the weld by which it holds something."""
        agents = zip(self.going.models.agents, self.diagram.supervisor.GetProgress(self._own).agents, strict=True)
        return {name: told.grasp for name, told in agents if told.grasp != NO_GRASP}

    def run(self) -> str:
        """Until it is done or halted, and then through safe mode. Returns why it cannot end."""
        reason = ""
        try:
            self._initialize()
            reason = self._advance()
            if self.halted:
                self._make_safe()
                reason = self._seen()
        except KeyboardInterrupt:
            self._record("interrupted")
            raise
        except (DrakeLtlError, RuntimeError) as error:  # Drake's own checks raise RuntimeError
            reason = " ".join(str(error).split())
        self._record(reason)
        return reason

    def _record(self, reason: str) -> None:
        recording = read_logs(self.diagram, self._context, self.num_steps, reason or self.halted)
        faulty = befallen(self.going.seen[self._known :])
        self.going.parts.append(Part(recording, self.halted, faulty, self.is_mission))

    def _initialize(self) -> None:
        step = self._first_step
        self.going.injector.Inject(self.diagram, self._context, step)
        self._notice(self._simulator.Initialize())

    def _advance(self) -> str:
        """Until done, halted, or too long in a step."""
        supervisor, going = self.diagram.supervisor, self.going
        limit, next_report = going.scenario.simulation.step_time_limit, -np.inf
        while not self.halted:
            if seen := self._seen():
                return seen
            self._apply_grasps()
            progress, now = supervisor.GetProgress(self._own), self._context.get_time()
            if progress.phase is Phase.DONE:
                look_once_more(self.diagram, self._context)
                return self._seen()
            going.injector.Inject(self.diagram, self._context, self._first_step + progress.count)
            if now >= next_report:
                next_report = now + REPORT_PERIOD
                waiting = tuple(supervisor.waiting_for(self._own))
                if going.report is not None:
                    steps = self._first_step + self.num_steps
                    going.report(RunProgress(now, self._first_step + progress.count, steps, waiting))
                if now - progress.step_start > limit:
                    number = self._first_step + progress.count + 1
                    return f"step {number} did not finish within {limit:g} s: {'; '.join(waiting)}"
            soon = min(now + REPORT_PERIOD, going.injector.next_time(now, LOOK))
            self._notice(self._simulator.AdvanceTo(self._boundary(soon)))
        return ""

    def _seen(self) -> str:
        """What ends the run, if anything: a fault may excuse much, but nothing of what these monitors look at."""
        seen = self.diagram.violations(self._context)
        if not seen or self.going.keep_going:
            return ""
        return f"a monitor saw: {replace(seen[0], step=self._first_step + seen[0].step)}"

    def _apply_grasps(self) -> None:
        if self.diagram.supervisor.grasps_pending(self._own):
            ApplyGrasps(self.diagram, self._context, self.going.injector.broken)

    def _boundary(self, when: float) -> float:
        """A time of a plant's step, to the last bit, later than now."""
        time_step = self.diagram.transport_plant.plant.time_step()
        now = round(self._context.get_time() / time_step)
        return max(now + 1, round(when / time_step)) * time_step

    def _notice(self, status: SimulatorStatus) -> None:
        """What a monitor of faults has seen halts the mission, whoever ended the advance at that instant."""
        diagram = self.diagram
        own = (diagram.supervisor, *diagram.monitors.values(), *diagram.fault_monitors)
        stopped = status.reason() != SimulatorStatus.ReturnReason.kReachedBoundaryTime
        if stopped and not any(status.system() is system for system in own):
            raise ExecutionError(status.FormatMessage())
        new = [
            seen
            for monitor in diagram.fault_monitors
            for seen in monitor.violations(monitor.GetMyContextFromRoot(self._context))
            if seen not in self.going.seen
        ]
        for seen in [seen for seen in new if not self.going.knows(seen)]:
            self.going.see(seen)
            self.halted = f"{self.halted}; {seen}" if self.halted else str(seen)

    # Safe mode.

    def _make_safe(self) -> None:
        supervisor = self.diagram.supervisor
        self._apply_grasps()
        self._step = supervisor.step_program(self._own)
        leaving = [action for action in self._step.actions if action.kind != "release"]  # that is done anywhere
        self.going.ways |= {agent: (action.start, action.goal) for action in leaving for agent in action.agents}
        supervisor.Halt(self._own, self._unable)
        self._settle()
        self._let_go(self.holds().keys() & self.going.losses.agents)  # held fast by them nothing could be lowered
        for _ in range(MOST_LOWERINGS):
            supervisor.SetDown(self._own, self.holds(), self._unable)
            if all(told.mode != Mode.REACH for told in supervisor.GetProgress(self._own).agents):
                break
            self._settle()
        losses = self.going.losses
        carrying = {name for task in self._step.transports if sound(task, losses) for name in task.team}
        self._let_go(self.holds().keys() - carrying)

    @property
    def _unable(self) -> frozenset[str]:
        """Who bears no load any more."""
        return self.going.losses.agents | self.going.losses.grippers

    def _let_go(self, agents: Set[str]) -> None:
        if agents:
            self.diagram.supervisor.LetGo(self._own, agents)
            self._apply_grasps()
            self._settle()

    def _settle(self) -> None:
        """Until all rest, after the supervisor has changed its mind."""
        self._restart_monitors()
        self._wait()

    def _restart_monitors(self) -> None:
        for monitor in self.diagram.fault_monitors:
            monitor.Restart(monitor.GetMyMutableContextFromRoot(self._context))

    def _wait(self) -> None:
        """Until all rest; for those out of service not so long. What is noticed meanwhile is counted in."""
        begin, supervisor = self._context.get_time(), self.diagram.supervisor
        first = supervisor.measured(self._own).qd
        step = self._first_step + supervisor.GetProgress(self._own).count
        while (now := self._context.get_time()) < begin + BRAKING_LIMIT:
            self.going.injector.Inject(self.diagram, self._context, step)
            self._notice(self._simulator.AdvanceTo(self._boundary(now + LOOK)))
            lost = self._unheld(first) if now > begin + LOST_LIMIT else frozenset()
            if now >= begin + self.going.losses.delay and supervisor.is_quiet(self._own, lost):
                return  # what is measured late shows later that it moves

    def _unheld(self, first: Mapping[str, np.ndarray]) -> frozenset[str]:
        """Who is out of service and does not come to rest, as velocities (n,) at the begin and now show."""
        now = self.diagram.supervisor.measured(self._own).qd
        lost = self.going.losses.agents
        return frozenset(name for name in lost if 2.0 * np.abs(now[name]).max() > np.abs(first[name]).max())

    # What comes next.

    def next_program(self) -> StepProgram:
        """What is to be done before the mission is planned again; without actions if that can be done."""
        going, bodies = self.going, self.bodies
        if self._step is not None:
            program = finishing(self._step, going.losses, bodies, self._began())
            if program.actions:
                return program
        if holds := self.holds():
            return releasing([self.diagram.program.welds[index] for index in holds.values()], bodies)
        outside = {
            name: ends
            for name, ends in going.ways.items()
            if name not in going.losses.agents and bodies.region(name) is None
        }
        return gathering(outside, going.losses, bodies)

    def _began(self) -> dict[str, np.ndarray]:
        """Where objects were when the step began that was carried out last (3,) [m]."""
        recording = self.going.parts[-1].recording
        first = int(np.searchsorted(recording.step, recording.step[-1]))
        return {name: pose[first, 4:] for name, pose in recording.pose.items()}


def befallen(seen: Iterable[Violation]) -> tuple[str, ...]:
    """Whom faults befell, of all that were seen: no later one undoes an earlier one. Regions and clocks are nobody."""
    return tuple(dict.fromkeys(name for one in seen if one.monitor not in (CLOCK, DOOR) for name in one.who))


def _going_on(diagram: MissionDiagram, before: Leg) -> Context:
    """A context in which the part before goes on: the same state, welds, brakes, masses, drives and doors."""
    context = diagram.CreateStartContext()
    time_step = diagram.transport_plant.plant.time_step()
    context.SetTime(round(before.context.get_time() / time_step) * time_step)
    for system in (lambda d: d.transport_plant.plant, lambda d: d.drives, lambda d: d.doors):
        old = system(before.diagram).GetMyContextFromRoot(before.context)
        new = system(diagram).GetMyMutableContextFromRoot(context)
        for index in range(old.num_numeric_parameter_groups()):
            new.get_mutable_numeric_parameter(index).SetFromVector(old.get_numeric_parameter(index).value())
    _same_state(before.diagram.transport_plant, before.context, diagram.transport_plant, context)
    return context


def _same_state(old: TransportPlant, old_root: Context, new: TransportPlant, new_root: Context) -> None:
    """Positions, velocities and active welds."""
    old_context, new_context = old.plant.GetMyContextFromRoot(old_root), new.plant.GetMyMutableContextFromRoot(new_root)
    new.plant.SetPositionsAndVelocities(new_context, old.plant.GetPositionsAndVelocities(old_context))
    for old_id, new_id in zip(old.weld_ids, new.weld_ids, strict=True):
        is_active = old.plant.GetConstraintActiveStatus(old_context, old_id)
        new.plant.SetConstraintActiveStatus(new_context, new_id, is_active)
