"""How a mission proceeds from phase to phase: pure functions on immutable data, without Drake's systems.

A step begins with all its actions at once. Travellers and teams move under the navigation function, agents at their
stand-off grasp, holders release. When every mover has arrived and every grasp and release of this phase is done,
agents that first had to drive to their stand-off grasp; then the step is done. So V of the movers is one function
from the begin of a phase to its end.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from pydrake.math import RigidTransform

from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.multibody.postures import pose_error
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
    """Where the mission stands. `revision` counts changes of commanded grasps."""

    count: int
    """Number of the step being carried out, from 0."""
    phase: Phase
    step_start: float
    """[s]"""
    revision: int
    anchor: np.ndarray
    """All configurations and all objects' origins when the phase began."""
    agents: tuple[AgentSignals, ...]


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


class Supervision:
    """The rules of a mission: `begin` makes its first Progress, `advance` every further one."""

    def __init__(self, program: MissionProgram, scenario: Scenario, models: MeasuredModels, num_steps: int):
        """`num_steps` steps are carried out, then everything holds (Phase.DONE)."""
        if num_steps < 0:
            raise ValueError(f"num_steps must not be negative, not {num_steps!r}")
        self.program = program
        self.num_steps = num_steps
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
        if applied != state.revision or self.waiting_for(state, now):
            return state
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
            for task in self.step(state).transports:
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
            reasons += [text for task in step.travels if (text := self._travel_left(task, now))]
            reasons += [text for task in step.transports if (text := self._transport_left(task, now))]
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
        state = replace(self._all_hold(state, now), phase=Phase.NAVIGATE, step_start=now.time, anchor=now.anchor)
        step = self.step(state)
        for task in step.travels:
            state = self._set(state, task.agent, mode=Mode.TRANSITION)
        for task in step.transports:
            mode = Mode.TRANSPORT + self._objects.index(task.object)
            for agent in task.team:
                state = self._set(state, agent, mode=mode)
        for task in step.grasps:
            state = self._approach(state, task, now)
        for task in step.releases:
            state = self._retreat(state, task, now)
        return replace(state, revision=state.revision + bool(step.releases))

    def _begin_late_grasps(self, state: Progress, step: StepProgram, now: Measurement) -> Progress:
        state = replace(self._all_hold(state, now), phase=Phase.REACH, anchor=now.anchor)
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
        if close and np.abs(now.qd[name]).max() <= WELD_SPEED:
            state = self._set(state, name, grasp=task.weld_index)
            return replace(state, revision=state.revision + 1)
        if now.time >= signals.reach[0] + signals.reach[1] + PATIENCE:
            return self._approach(state, task, now)
        return state

    def _settle_release(self, state: Progress, task: ReleaseTask, signals: AgentSignals, now: Measurement) -> Progress:
        name = task.weld.agent
        goal = reach_ends(signals.reach)[1]
        if np.abs(now.q[name] - goal).max() <= RETREATED:
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
        speed = float(np.abs(now.qd[task.agent]).max())
        if distance <= tolerances.position and joint <= tolerances.joint and speed <= tolerances.speed:
            return ""
        return f"{task.agent} is {distance:.2f} m from its place in {task.goal} (speed {speed:.2f} m/s)"

    def _transport_left(self, task: TransportTask, now: Measurement) -> str:
        distance = float(np.linalg.norm(now.X_WO[task.object].translation() - task.p_goal))
        speed = float(np.linalg.norm(now.V_WO[task.object][3:]))
        if distance <= self._tolerances.position and speed <= self._tolerances.speed:
            return ""
        team = ", ".join(task.team)
        return f"{task.object} (carried by {team}) is {distance:.2f} m from its place in {task.goal} (speed {speed:.2f} m/s)"

    def _set(self, state: Progress, agent: str, **changes) -> Progress:
        index = self._names.index(agent)
        agents = list(state.agents)
        agents[index] = replace(agents[index], **changes)
        return replace(state, agents=tuple(agents))
