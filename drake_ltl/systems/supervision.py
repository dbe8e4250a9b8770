"""How a mission proceeds from phase to phase: pure functions on immutable data, without Drake's systems.

A step begins with all its actions at once. Travellers and teams move under the navigation function, agents at their
stand-off grasp, holders release. When every mover has arrived and every grasp and release of this phase is done,
agents that first had to drive to their stand-off grasp; then the step is done. So V of the movers is one function
from the begin of a phase to its end.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from drake_ltl.dynamics import heading_difference
from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.arrival import Arrival
from drake_ltl.systems.detours import Detours, started
from drake_ltl.systems.drive_stages import with_stages
from drake_ltl.systems.exchange import exchanged
from drake_ltl.systems.legs import ALL, moving_tasks
from drake_ltl.systems.program import GraspTask, MissionProgram, ReleaseTask, StepProgram
from drake_ltl.systems.progress import AgentSignals, Measurement, Progress
from drake_ltl.systems.safe_mode import SafeMode
from drake_ltl.systems.signals import NO_GRASP, Mode, Phase, pack_course, pack_reach, reach_ends
from drake_ltl.systems.step_field import FieldBuilder

REACH_SPEED = 0.3
"""Peak speed of an approach or a retreat [m/s]."""
LEAST_REACH_TIME = 1.0
"""[s]"""
PATIENCE = 0.8
"""An approach that ends off the grasp is corrected this long after its end [s], but not while others are on their way,
for V begins anew then."""

UNREST = 1.5
"""A step does not end while who only holds is faster than the tolerance by this factor; verdicts bear 2."""


class Supervision:
    """The rules of a mission: `begin` makes its first Progress, `advance` every further one."""

    def __init__(
        self,
        program: MissionProgram,
        scenario: Scenario,
        models: MeasuredModels,
        num_steps: int,
        holds: Mapping[str, int] | None = None,
        ignored: frozenset[str] = frozenset(),
    ):
        """`num_steps` steps are carried out, then everything holds (Phase.DONE). `holds` are the welds with which it
        begins: agent -> index. Nobody waits for the members `ignored`, of whose faults is known, to come to rest."""
        if num_steps < 0:
            raise ValueError(f"num_steps must not be negative, not {num_steps!r}")
        self.program = program
        self.num_steps = num_steps
        self.safe_mode = SafeMode(models, program.welds)
        self._holds, self._ignored = holds or {}, ignored
        self._names = list(models.agents)
        self._models = models
        self._has_drives = not all(model.has_arm for model in models.agents.values())
        self._arrival = Arrival.of(models, scenario)
        self._detours = Detours(FieldBuilder(scenario, models), models, self._arrival, program)

    def begin(self, now: Measurement) -> Progress:
        """The mission's first phase."""
        rest = tuple(
            AgentSignals(Mode.HOLD, q, pack_reach(now.time, LEAST_REACH_TIME, q, q), self._holds.get(name, NO_GRASP))
            for name, q in now.q.items()
        )
        return self._begin_step(Progress(0, Phase.NAVIGATE, now.time, 0, now.anchor, rest), now)

    def advance(self, state: Progress, applied: int, now: Measurement) -> Progress:
        """The next Progress; `state` itself if nothing changes.

        Args:
            applied: the revision of grasps that has been applied to the plant.
        """
        if state.phase is Phase.DONE or applied != state.revision:
            return state
        if state.phase is Phase.SAFE:
            return self.safe_mode.advance(state, now)
        state = self._settle_reaches(state, now)
        if applied != state.revision:
            return state
        if any(self._reasons_to_wait(state, now)):
            return self._keep_moving(state, now) if state.phase is Phase.NAVIGATE else state
        step = self.step(state)
        if state.phase is Phase.NAVIGATE and step.late_grasps:
            return self._begin_late_grasps(state, step, now)
        return self._begin_step(replace(state, count=state.count + 1), now)

    def _keep_moving(self, state: Progress, now: Measurement) -> Progress:
        step = self.step(state)
        if self._has_drives:
            state = with_stages(state, moving_tasks(step, state.leg, self._models).travels, self._models, now)
        return self._detours.keep_moving(state, step, now)

    def halt(self, state: Progress, now: Measurement, unable: frozenset[str] = frozenset()) -> Progress:
        """Safe mode begins, see `SafeMode`; the same if it has begun."""
        if state.phase in (Phase.SAFE, Phase.DONE):
            return state
        reaching = [n for n, told in zip(self._names, state.agents, strict=True) if told.mode == Mode.REACH]
        return self.safe_mode.halt(state, now, {name: self._reach_task(state, name) for name in reaching}, unable)

    def step(self, state: Progress) -> StepProgram:
        """The tasks of the step being carried out, with the places that travellers have exchanged."""
        return exchanged(self.program.steps[self.program.index(state.count)], state.exchange, self._models)

    def shares(self, state: Progress, obj: str) -> np.ndarray:
        """c_tau (N,) for the object; zeros while nobody carries it."""
        if state.phase is Phase.NAVIGATE:
            moving = moving_tasks(self.step(state), state.leg, self._models).transports
            for task in moving:
                if task.object == obj:
                    return task.shares
        return np.zeros(len(self._names))

    def course(self, state: Progress, agent: str) -> np.ndarray:
        """Of a differential drive, see `signals.pack_course`; to where it holds while it does not travel."""
        told = state.agents[self._names.index(agent)]
        if told.mode == Mode.TRANSITION:
            for task in moving_tasks(self.step(state), state.leg, self._models).travels:
                if task.agent == agent:
                    return pack_course(told.stage, task.q_goal)
        return pack_course(told.stage, told.hold)

    def waiting_for(self, state: Progress, now: Measurement) -> list[str]:
        """What keeps the phase from ending, for people; empty when it can end."""
        return [text() for text in self._reasons_to_wait(state, now)]

    def _reasons_to_wait(self, state: Progress, now: Measurement) -> Iterator[Callable[[], str]]:
        """As texts, which are made of those alone that people are to see."""
        if state.phase is Phase.NAVIGATE:
            step = self.step(state)
            for task in (*step.travels, *step.transports):
                if not self._arrival.is_done(task, now):
                    yield partial(self._arrival.left, task, now)
        for name, signals in zip(self._names, state.agents, strict=True):
            if signals.mode == Mode.REACH and state.phase not in (Phase.DONE, Phase.SAFE):
                yield partial(self._reach_text, state, name, now)
            elif signals.mode == Mode.HOLD and state.phase not in (Phase.DONE, Phase.SAFE):
                yield from self._unrest(name, signals, now)

    def _reach_text(self, state: Progress, name: str, now: Measurement) -> str:
        task = self._reach_task(state, name)
        verb = "grasping" if isinstance(task, GraspTask) else "releasing"
        return f"{name} is still {verb} {task.weld.object}{self._gap_text(task, now)}"

    def _unrest(self, name: str, signals: AgentSignals, now: Measurement) -> Iterator[Callable[[], str]]:
        """Of who holds still, and of what it holds: what was carried settles on the floor, however short the step."""
        if name in self._ignored:
            return
        if not self._arrival.rests(name, now, UNREST):
            yield partial("{} has not come to rest".format, name)
        if signals.grasp != NO_GRASP:
            obj = self.program.welds[signals.grasp].object
            if not self._arrival.lies_still(obj, now, UNREST):
                yield partial("{} has not come to rest".format, obj)

    # Phases begin.

    def _begin_step(self, state: Progress, now: Measurement) -> Progress:
        if state.count >= self.num_steps:
            return replace(state, phase=Phase.DONE, step_start=now.time).holding(now)
        state = replace(
            state.holding(now),
            phase=Phase.NAVIGATE,
            step_start=now.time,
            anchor=now.anchor,
            interval=0,
            active=ALL,
            way=(),
            slow_since=np.inf,
            exchange=0,
            exchanges=0,
            lets_by=ALL,
        )
        step = self.step(state)
        for task in (*step.travels, *step.transports):
            state = started(state, task, self._models, now)
        for task in step.grasps:
            state = self._approach(state, task, now)
        for task in step.releases:
            state = self._retreat(state, task, now)
        return replace(state, revision=state.revision + bool(step.releases))

    def _begin_late_grasps(self, state: Progress, step: StepProgram, now: Measurement) -> Progress:
        state = replace(state.holding(now), phase=Phase.REACH, anchor=now.anchor, interval=state.interval + 1)
        for task in step.late_grasps:
            state = self._approach(state, task, now)
        return state

    def _approach(self, state: Progress, task: GraspTask, now: Measurement) -> Progress:
        goal = self._models.agents[task.weld.agent].nearest_turn(self._following(task, now), now.q[task.weld.agent])
        return self._reach(state, task.weld.agent, goal, now)

    def _following(self, task: GraspTask, now: Measurement) -> np.ndarray:
        """q that grasps the object where it is, and as it is turned if the agent can turn."""
        model, X_WO = self._models.agents[task.weld.agent], now.X_WO[task.weld.object]
        orientation = X_WO.rotation().ToQuaternion().wxyz()
        turn = heading_difference(orientation, task.orientation) if model.yaw_direction else 0.0
        q = model.turned(task.q_OE, turn).copy()
        q[:NUM_BASE_JOINTS] += X_WO.translation()[:2]
        return q

    def _retreat(self, state: Progress, task: ReleaseTask, now: Measurement) -> Progress:
        goal = now.q[task.weld.agent].copy()
        goal[:NUM_BASE_JOINTS] += task.retreat
        state = self._set(state, task.weld.agent, grasp=NO_GRASP)
        return self._reach(state, task.weld.agent, goal, now)

    def _reach(self, state: Progress, agent: str, goal: np.ndarray, now: Measurement) -> Progress:
        start = now.q[agent]
        peak = 1.875  # of a rest-to-rest quintic, relative to its mean speed
        duration = max(LEAST_REACH_TIME, peak * float(np.abs(goal - start).max()) / REACH_SPEED)
        return self._set(state, agent, mode=Mode.REACH, reach=pack_reach(now.time, duration, start, goal))

    # Reaches end.

    def _settle_reaches(self, state: Progress, now: Measurement) -> Progress:
        for name, signals in zip(self._names, state.agents, strict=True):
            if signals.mode == Mode.REACH and now.time >= signals.reach[0] + signals.reach[1]:
                task = self._reach_task(state, name)
                settle = self._settle_grasp if isinstance(task, GraspTask) else self._settle_release
                state = settle(state, task, signals, now)
        return state

    def _settle_grasp(self, state: Progress, task: GraspTask, signals: AgentSignals, now: Measurement) -> Progress:
        name = task.weld.agent
        if signals.grasp == task.weld_index:  # commanded before, and applied since
            at_rest = self._arrival.rests(name, now)
            return self._set(state, name, mode=Mode.HOLD, hold=now.q[name]) if at_rest else state
        if self._arrival.can_weld(task, now):
            state = self._set(state, name, grasp=task.weld_index)
            return replace(state, revision=state.revision + 1)
        late = now.time >= signals.reach[0] + signals.reach[1] + PATIENCE
        if late and (state.phase is Phase.REACH or self._detours.may_begin_anew(self.step(state), now)):
            return self._approach(state.new_interval(now), task, now)  # phi keeps clear of the new way
        return state

    def _settle_release(self, state: Progress, task: ReleaseTask, signals: AgentSignals, now: Measurement) -> Progress:
        if self._arrival.has_retreated(task, signals.reach, now):
            return self._set(state, task.weld.agent, mode=Mode.HOLD, hold=reach_ends(signals.reach)[1])
        return state

    def _reach_task(self, state: Progress, agent: str) -> GraspTask | ReleaseTask:
        step = self.step(state)
        grasps = step.grasps if state.phase is Phase.NAVIGATE else step.late_grasps
        return next(task for task in (*grasps, *step.releases) if task.weld.agent == agent)

    def _gap_text(self, task: GraspTask | ReleaseTask, now: Measurement) -> str:
        if isinstance(task, ReleaseTask):
            return ""
        angle, gap = self._arrival.misalignment(task, now)
        return f" ({1e3 * gap:.1f} mm and {np.rad2deg(angle):.2f} degrees off)"

    def _set(self, state: Progress, agent: str, **changes) -> Progress:
        return state.with_agent(self._names.index(agent), **changes)
