"""How a mission proceeds from phase to phase: pure functions on immutable data, without Drake's systems.

A step begins with all its actions at once. Travellers and teams move under the navigation function, agents at their
stand-off grasp, holders release. When every mover has arrived and every grasp and release of this phase is done,
agents that first had to drive to their stand-off grasp; then the step is done. So V of the movers is one function
from the begin of a phase to its end.

A navigation function has saddles, and among many bodies that stand close also other minima. If all movers have come
to rest short of their goals, they go on one after another, each by way points around the others as they stand; every
leg between way points has its own navigation function, and its own V.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from pydrake.math import RigidTransform

from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.multibody.postures import pose_error
from drake_ltl.navigation.detour import detour
from drake_ltl.scenario.model import Scenario, Tolerances
from drake_ltl.systems.program import (
    GraspTask,
    MissionProgram,
    ReleaseTask,
    StepProgram,
    TransportTask,
    TravelTask,
)
from drake_ltl.systems.signals import NO_GRASP, Mode, Phase, pack_reach, reach_ends
from drake_ltl.systems.step_field import ALL, FieldBuilder, Leg, Snapshot, moving_tasks

REACH_SPEED = 0.3
"""Peak speed of an approach or a retreat [m/s]."""
LEAST_REACH_TIME = 1.0
"""[s]"""
PATIENCE = 0.8
"""An approach that ends off the grasp is corrected this long after its end [s]."""
WELD_SPEED = 0.005
"""Joints slower than this count as at rest for a weld [m/s, rad/s]."""
RETREATED = 0.002
"""A retreat ends this close to its goal [m, rad]."""
STALL_SPEED = 0.02
"""Movers slower than this have come to rest [m/s, rad/s]: below the speed at which goals count as reached."""
STALL_TIME = 3.0
"""Movers at rest for so long short of their goals do not get there on this way [s]."""
PASSED = 0.15
"""A way point counts as passed at this distance [m]."""


@dataclass(frozen=True)
class AgentSignals:
    """What the supervisor tells one agent's controllers."""

    mode: int
    hold: np.ndarray
    """Configuration (n,) that the hold controller keeps."""
    reach: np.ndarray
    """See `signals.pack_reach`."""
    grasp: int = NO_GRASP
    """Index of the commanded weld."""


@dataclass(frozen=True)
class Progress:
    """Where the mission stands."""

    count: int
    """Number of the step being carried out, from 0."""
    phase: Phase
    step_start: float
    """[s]"""
    revision: int
    """Counts changes of commanded grasps."""
    anchor: np.ndarray
    """All configurations and all objects' origins when the interval began."""
    agents: tuple[AgentSignals, ...]
    interval: int = 0
    """Counts, within the step, the intervals of one navigation function each."""
    active: int = ALL
    """The mover that is on its way alone, see `Leg`."""
    way: tuple[tuple[float, float], ...] = ()
    """Way points that it has ahead, before its goal."""
    slow_since: float = np.inf
    """Since when all movers have been at rest [s]."""

    @property
    def leg(self) -> Leg:
        """What moves now, and by way of which point."""
        return Leg(self.active, self.way[0] if self.way else None)


@dataclass(frozen=True)
class Measurement:
    """What the supervisor sees at one instant."""

    time: float
    q: Mapping[str, np.ndarray]
    qd: Mapping[str, np.ndarray]
    X_WO: Mapping[str, RigidTransform]
    V_WO: Mapping[str, np.ndarray]
    """(6,) (rotational; translational) [rad/s, m/s]."""

    @property
    def anchor(self) -> np.ndarray:
        """All configurations, then all objects' origins."""
        return np.concatenate([*self.q.values(), *(X.translation() for X in self.X_WO.values())])

    @property
    def snapshot(self) -> Snapshot:
        """The same, by name."""
        return Snapshot(self.q, {name: X.translation() for name, X in self.X_WO.items()})


class Supervision:
    """The rules of a mission: `begin` makes its first Progress, `advance` every further one."""

    def __init__(self, program: MissionProgram, scenario: Scenario, models: MeasuredModels, num_steps: int):
        """`num_steps` steps are carried out, then everything holds (Phase.DONE)."""
        if num_steps < 0:
            raise ValueError(f"num_steps must not be negative, not {num_steps!r}")
        self.program = program
        self.num_steps = num_steps
        self._fields = FieldBuilder(scenario, models)
        self._tolerances: Tolerances = scenario.tolerances
        self._names = list(models.agents)
        self._objects = list(models.objects)
        self._models = models

    def begin(self, now: Measurement) -> Progress:
        """The mission's first phase."""
        rest = tuple(AgentSignals(Mode.HOLD, q, pack_reach(now.time, LEAST_REACH_TIME, q, q)) for q in now.q.values())
        return self._begin_step(Progress(0, Phase.NAVIGATE, now.time, 0, now.anchor, rest), now)

    def advance(self, state: Progress, applied: int, now: Measurement) -> Progress:
        """The next Progress; `state` itself if nothing changes.

        Args:
            applied: the revision of grasps that has been applied to the plant.
        """
        if state.phase is Phase.DONE or applied != state.revision:
            return state
        state = self._settle_reaches(state, now)
        if applied != state.revision:
            return state
        if self.waiting_for(state, now):
            return self._keep_moving(state, now) if state.phase is Phase.NAVIGATE else state
        step = self.step(state)
        if state.phase is Phase.NAVIGATE and step.late_grasps:
            return self._begin_late_grasps(state, step, now)
        return self._begin_step(replace(state, count=state.count + 1), now)

    def step(self, state: Progress) -> StepProgram:
        """The tasks of the step being carried out."""
        return self.program.steps[self.program.index(state.count)]

    def shares(self, state: Progress, obj: str) -> np.ndarray:
        """c_tau (N,) for the object; zeros while nobody carries it."""
        if state.phase is Phase.NAVIGATE:
            moving = moving_tasks(self.step(state), state.leg, self._models)[1]
            for task in moving:
                if task.object == obj:
                    return task.shares
        return np.zeros(len(self._names))

    def waiting_for(self, state: Progress, now: Measurement) -> list[str]:
        """What keeps the phase from ending, for people; empty when it can end."""
        if state.phase is Phase.DONE:
            return []
        reasons = []
        if state.phase is Phase.NAVIGATE:
            step = self.step(state)
            reasons += [text for task in (*step.travels, *step.transports) if (text := self._left(task, now))]
        for name, signals in zip(self._names, state.agents, strict=True):
            if signals.mode == Mode.REACH:
                task = self._reach_task(state, name)
                verb = "grasping" if isinstance(task, GraspTask) else "releasing"
                reasons.append(f"{name} is still {verb} {task.weld.object}{self._gap_text(task, now)}")
        return reasons

    # Phases begin.

    def _begin_step(self, state: Progress, now: Measurement) -> Progress:
        if state.count >= self.num_steps:
            return self._all_hold(replace(state, phase=Phase.DONE, step_start=now.time), now)
        state = replace(
            self._all_hold(state, now),
            phase=Phase.NAVIGATE,
            step_start=now.time,
            anchor=now.anchor,
            interval=0,
            active=ALL,
            way=(),
            slow_since=np.inf,
        )
        step = self.step(state)
        for task in (*step.travels, *step.transports):
            state = self._start(state, task)
        for task in step.grasps:
            state = self._approach(state, task, now)
        for task in step.releases:
            state = self._retreat(state, task, now)
        return replace(state, revision=state.revision + bool(step.releases))

    def _begin_late_grasps(self, state: Progress, step: StepProgram, now: Measurement) -> Progress:
        state = replace(self._all_hold(state, now), phase=Phase.REACH, anchor=now.anchor, interval=state.interval + 1)
        for task in step.late_grasps:
            state = self._approach(state, task, now)
        return state

    def _all_hold(self, state: Progress, now: Measurement) -> Progress:
        """Everyone holds; who held before keeps its configuration."""
        for name, signals in zip(self._names, state.agents, strict=True):
            if signals.mode != Mode.HOLD:
                state = self._set(state, name, mode=Mode.HOLD, hold=now.q[name])
        return state

    def _approach(self, state: Progress, task: GraspTask, now: Measurement) -> Progress:
        goal = task.q_OE.copy()
        goal[:NUM_BASE_JOINTS] += now.X_WO[task.weld.object].translation()[:2]
        return self._reach(state, task.weld.agent, goal, now)

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

    def _start(self, state: Progress, task: TravelTask | TransportTask) -> Progress:
        if isinstance(task, TravelTask):
            return self._set(state, task.agent, mode=Mode.TRANSITION)
        mode = Mode.TRANSPORT + self._objects.index(task.object)
        for agent in task.team:
            state = self._set(state, agent, mode=mode)
        return state

    # Movers that do not get there.

    def _keep_moving(self, state: Progress, now: Measurement) -> Progress:
        """Looks after way points passed, lone movers that have arrived, and stalls."""
        tasks = (*self.step(state).travels, *self.step(state).transports)
        if state.active != ALL:
            if state.way and self._passed(state, tasks[state.active], now):
                return self._begin_interval(state, now, way=state.way[1:])
            if not state.way and not self._left(tasks[state.active], now):
                return self._next_mover(state, now)
        if any(self._speed(task, now) > STALL_SPEED for task in tasks):
            return state if state.slow_since == np.inf else replace(state, slow_since=np.inf)
        if any(signals.mode == Mode.REACH for signals in state.agents):
            return state
        if state.slow_since == np.inf:
            return replace(state, slow_since=now.time)
        return self._next_mover(state, now) if now.time - state.slow_since >= STALL_TIME else state

    def _next_mover(self, state: Progress, now: Measurement) -> Progress:
        """The next mover in turn that is not at its goal and can get there; all wait if there is none."""
        step = self.step(state)
        tasks = (*step.travels, *step.transports)
        for offset in range(1, len(tasks) + 1):
            index = (state.active + offset) % len(tasks)
            if self._left(tasks[index], now) and (way := self._way(state, Leg(index), now)) is not None:
                state = self._begin_interval(self._movers_hold(state, now), now, way=tuple(way), active=index)
                return self._start(state, tasks[index])
        return replace(state, slow_since=now.time)

    def _way(self, state: Progress, leg: Leg, now: Measurement) -> list[tuple[float, float]] | None:
        step = self.step(state)
        reaching = {task.weld.agent for task in (*step.grasps, *step.releases)}
        reaches = {
            name: reach_ends(signals.reach)
            for name, signals in zip(self._names, state.agents, strict=True)
            if name in reaching
        }
        relations = self._fields.relations(*moving_tasks(step, leg, self._models), now.snapshot, reaches)
        if any(relations.relations.violated(ends) for ends in (relations.start, relations.goal)):
            return None  # somebody stands where this mover is to go
        return detour(relations)

    def _begin_interval(self, state: Progress, now: Measurement, **changes) -> Progress:
        return replace(state, interval=state.interval + 1, anchor=now.anchor, slow_since=np.inf, **changes)

    def _movers_hold(self, state: Progress, now: Measurement) -> Progress:
        for name, signals in zip(self._names, state.agents, strict=True):
            if signals.mode not in (Mode.HOLD, Mode.REACH):
                state = self._set(state, name, mode=Mode.HOLD, hold=now.q[name])
        return state

    def _passed(self, state: Progress, task: TravelTask | TransportTask, now: Measurement) -> bool:
        if isinstance(task, TravelTask):
            here = self._models.agents[task.agent].centre(now.q[task.agent])
        else:
            here = now.X_WO[task.object].translation()
        return float(np.linalg.norm(here[:2] - state.way[0])) <= PASSED

    def _left(self, task: TravelTask | TransportTask, now: Measurement) -> str:
        return self._travel_left(task, now) if isinstance(task, TravelTask) else self._transport_left(task, now)

    def _speed(self, task: TravelTask | TransportTask, now: Measurement) -> float:
        return _fastest(now.qd[task.agent] if isinstance(task, TravelTask) else now.V_WO[task.object])

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
            return self._set(state, name, mode=Mode.HOLD, hold=now.q[name])
        angle, gap = self._misalignment(task, now)
        close = angle <= self._tolerances.weld_angle and gap <= self._tolerances.weld_position
        if close and _fastest(now.qd[name]) <= WELD_SPEED:
            state = self._set(state, name, grasp=task.weld_index)
            return replace(state, revision=state.revision + 1)
        if now.time >= signals.reach[0] + signals.reach[1] + PATIENCE:
            return self._approach(self._begin_interval(state, now), task, now)  # phi keeps clear of the new way
        return state

    def _settle_release(self, state: Progress, task: ReleaseTask, signals: AgentSignals, now: Measurement) -> Progress:
        name = task.weld.agent
        goal = reach_ends(signals.reach)[1]
        if np.abs(now.q[name] - goal).max() <= RETREATED and _fastest(now.qd[name]) <= self._tolerances.speed:
            return self._set(state, name, mode=Mode.HOLD, hold=goal)
        return state

    def _reach_task(self, state: Progress, agent: str) -> GraspTask | ReleaseTask:
        step = self.step(state)
        grasps = step.grasps if state.phase is Phase.NAVIGATE else step.late_grasps
        return next(task for task in (*grasps, *step.releases) if task.weld.agent == agent)

    # What is left to do.

    def _misalignment(self, task: GraspTask, now: Measurement) -> tuple[float, float]:
        """Angle [rad] and gap [m] between the gripper and the grasp frame."""
        weld = task.weld
        (configuration,) = (g for g in self._models.grasps[weld.agent, weld.object] if g.name == weld.option)
        X_WE = self._models.agents[weld.agent].grasp_pose(now.q[weld.agent])
        error = pose_error(X_WE, now.X_WO[weld.object] @ configuration.X_OE)
        return float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))

    def _gap_text(self, task: GraspTask | ReleaseTask, now: Measurement) -> str:
        if isinstance(task, ReleaseTask):
            return ""
        angle, gap = self._misalignment(task, now)
        return f" ({1e3 * gap:.1f} mm and {np.rad2deg(angle):.2f} degrees off)"

    def _travel_left(self, task: TravelTask, now: Measurement) -> str:
        error, tolerances = now.q[task.agent] - task.q_goal, self._tolerances
        distance = float(np.linalg.norm(error[:NUM_BASE_JOINTS]))
        joint = float(np.abs(error[NUM_BASE_JOINTS:]).max())
        speed = _fastest(now.qd[task.agent])
        if distance <= tolerances.position and joint <= tolerances.joint and speed <= tolerances.speed:
            return ""
        return f"{task.agent} is {distance:.2f} m from its place in {task.goal} (speed {speed:.2f} m/s)"

    def _transport_left(self, task: TransportTask, now: Measurement) -> str:
        distance = float(np.linalg.norm(now.X_WO[task.object].translation() - task.p_goal))
        speed = max([float(np.linalg.norm(now.V_WO[task.object][3:])), *(_fastest(now.qd[a]) for a in task.team)])
        if distance <= self._tolerances.position and speed <= self._tolerances.speed:
            return ""
        team = f"{task.object} (carried by {', '.join(task.team)})"
        return f"{team} is {distance:.2f} m from its place in {task.goal} (speed {speed:.2f} m/s)"

    def _set(self, state: Progress, agent: str, **changes) -> Progress:
        index = self._names.index(agent)
        agents = list(state.agents)
        agents[index] = replace(agents[index], **changes)
        return replace(state, agents=tuple(agents))


def _fastest(qd: np.ndarray) -> float:
    """Of all joints [m/s, rad/s]."""
    return float(np.abs(qd).max())
