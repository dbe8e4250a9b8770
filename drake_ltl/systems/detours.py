"""What happens when all movers have come to rest short of their goals.

A navigation function has saddles, and among many bodies that stand close also other minima. Then travellers whose
places are alike take those that leave the shortest ways (`exchange`). If that changes nothing, movers go on one after
another, those first whose places lie innermost, each by way points around the others as they stand; every leg
between way points has its own navigation function, and its own V. If nobody left has a way, one that bars another's
gets out of it, lets it by and follows (`evasion`). If that cannot be either, all go at once again: under one
navigation function those who stand in the way give way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.navigation import StepRelations
from drake_ltl.navigation.detour import arrival_order, detour, run_up
from drake_ltl.navigation.evasion import evasion
from drake_ltl.systems.arrival import Arrival
from drake_ltl.systems.drive_stages import set_out
from drake_ltl.systems.exchange import better_rank, exchanged
from drake_ltl.systems.legs import ALL, Leg, moving_tasks
from drake_ltl.systems.program import MissionProgram, StepProgram, TransportTask, TravelTask
from drake_ltl.systems.progress import Measurement, Progress
from drake_ltl.systems.signals import Mode, reach_ends
from drake_ltl.systems.step_field import FieldBuilder

STALL_SPEED = 0.02
"""Movers slower than this have come to rest [m/s, rad/s]: below the speed at which goals count as reached."""
STALL_TIME = 3.0
"""Movers at rest for so long short of their goals do not get there on this way [s]."""
AT_REST = 0.08
"""V begins anew once no joint is faster, wheels included [m/s, rad/s]: a drive that creeps is still on its way, and
verdicts bear 0.1."""
PASSED = 0.15
"""A way point counts as passed at this distance [m] ..."""
PASSED_SPEED = 0.05
"""... and the last one at this speed [m/s, rad/s]: a swinging arm would overshoot where room is scarce."""
MOST_EXCHANGES = 6
"""In one step; who stalls oftener goes on one by one."""


def started(state: Progress, task: TravelTask | TransportTask, models: MeasuredModels, now: Measurement) -> Progress:
    """With the task's agents in the mode in which they carry it out."""
    names = list(models.agents)
    if isinstance(task, TravelTask):
        state = state.with_agent(names.index(task.agent), mode=Mode.TRANSITION)
        return state if models.agents[task.agent].has_arm else set_out(state, task, models, now)
    mode = Mode.TRANSPORT + list(models.objects).index(task.object)
    for agent in task.team:
        state = state.with_agent(names.index(agent), mode=mode)
    return state


@dataclass(frozen=True)
class Detours:
    """The rules by which movers go on that a step's own navigation function does not bring to their goals."""

    fields: FieldBuilder
    models: MeasuredModels
    arrival: Arrival
    program: MissionProgram

    def keep_moving(self, state: Progress, step: StepProgram, now: Measurement) -> Progress:
        """Looks after way points passed, lone movers that have arrived, and stalls."""
        tasks = (*step.travels, *step.transports)
        if state.active != ALL:
            if state.way and self._passed(state, tasks[state.active], now):
                if len(state.way) > 1 or state.lets_by == ALL:
                    return state.new_interval(now, way=state.way[1:])
                if self.may_begin_anew(step, now):
                    return self._on_its_way(state, step, state.lets_by, now) or self._next_mover(state, step, now)
            if not state.way and self.arrival.is_done(tasks[state.active], now):
                return self._next_mover(state, step, now)
        if any(self.arrival.speed(task, now) > STALL_SPEED for task in tasks):
            return state if state.slow_since == np.inf else replace(state, slow_since=np.inf)
        if any(signals.mode == Mode.REACH for signals in state.agents):
            return state
        if state.slow_since == np.inf:
            return replace(state, slow_since=now.time)
        if now.time - state.slow_since < STALL_TIME or not self.may_begin_anew(step, now):
            return state
        return self._exchange(state, step, now) or self._next_mover(state, step, now)

    def may_begin_anew(self, step: StepProgram, now: Measurement) -> bool:
        """Whether V may: no mover is on its way, wheels and all."""
        moving = [now.qd[task.agent] for task in step.travels] + [now.V_WO[task.object] for task in step.transports]
        return all(np.abs(rates).max() <= AT_REST for rates in moving)

    def _exchange(self, state: Progress, step: StepProgram, now: Measurement) -> Progress | None:
        """All at once again, some of them to other places, if that leaves shorter ways."""
        if state.exchanges >= MOST_EXCHANGES:
            return None
        here = [self.models.agents[task.agent].centre(now.q[task.agent]) for task in step.travels]
        number = self.program.index(state.count)
        rank = better_rank(self.program, number, state.exchange, self.models, here)
        if rank is None:
            return None
        state = replace(state, exchange=rank, exchanges=state.exchanges + 1)
        return self._all_at_once(state, exchanged(self.program.steps[number], rank, self.models), now)

    def _all_at_once(self, state: Progress, step: StepProgram, now: Measurement) -> Progress:
        state = state.new_interval(now, way=(), active=ALL, lets_by=ALL)
        for task in (*step.travels, *step.transports):
            state = started(state, task, self.models, now)
        return state

    def _next_mover(self, state: Progress, step: StepProgram, now: Measurement) -> Progress:
        """The next mover in order that is not at its goal and can get there; else one that gets out of another's way;
        else all at once again."""
        tasks = (*step.travels, *step.transports)
        order = arrival_order(np.array([self._place(task) for task in tasks]))
        after = order.index(state.active) + 1 if state.active != ALL else 0
        for index in order[after:] + order[:after]:
            if going := self._on_its_way(state, step, index, now):
                return going
        if evading := self._evade(state, step, order, now):
            return evading
        if state.active == ALL:
            return replace(state, slow_since=now.time)
        return self._all_at_once(state, step, now)

    def _on_its_way(self, state: Progress, step: StepProgram, index: int, now: Measurement) -> Progress | None:
        """With one mover on its way alone; None if it has arrived, or has none."""
        tasks = (*step.travels, *step.transports)
        if self.arrival.is_done(tasks[index], now) or (way := self._way(state, step, index, now)) is None:
            return None
        return self._alone(state, tasks[index], now, active=index, way=tuple(way), lets_by=ALL)

    def _evade(self, state: Progress, step: StepProgram, order: list[int], now: Measurement) -> Progress | None:
        """With one mover on its way to where it lets another by."""
        tasks = (*step.travels, *step.transports)
        relations = [self._relations(state, step, index, now) for index in range(len(tasks))]
        for barred, evader in permutations(order, 2):
            if self.arrival.is_done(tasks[barred], now):
                continue
            if way := evasion(relations[evader], relations[barred]):
                return self._alone(state, tasks[evader], now, active=evader, way=tuple(way), lets_by=barred)
        return None

    def _alone(self, state: Progress, task: TravelTask | TransportTask, now: Measurement, **leg) -> Progress:
        state = state.holding(now, but=frozenset({Mode.REACH})).new_interval(now, **leg)
        return started(state, task, self.models, now)

    def _place(self, task: TravelTask | TransportTask) -> np.ndarray:
        """Centre of the mover's sphere at its goal (3,) [m]."""
        return self.models.agents[task.agent].centre(task.q_goal) if isinstance(task, TravelTask) else task.p_goal

    def _way(
        self, state: Progress, step: StepProgram, index: int, now: Measurement
    ) -> list[tuple[float, float]] | None:
        relations = self._relations(state, step, index, now)
        if any(relations.relations.violated(ends) for ends in (relations.start, relations.goal)):
            return None  # somebody stands where this mover is to go
        stuck_ahead_of_goal = state.active == index and not state.way
        return run_up(relations) if stuck_ahead_of_goal else detour(relations)

    def _relations(self, state: Progress, step: StepProgram, index: int, now: Measurement) -> StepRelations:
        """Of one mover alone, all others standing where they are."""
        reaching = {task.weld.agent for task in (*step.grasps, *step.releases)}
        reaches = {
            name: reach_ends(signals.reach)
            for name, signals in zip(self.models.agents, state.agents, strict=True)
            if name in reaching
        }
        return self.fields.relations(moving_tasks(step, Leg(index), self.models), now.snapshot, reaches)

    def _passed(self, state: Progress, task: TravelTask | TransportTask, now: Measurement) -> bool:
        if isinstance(task, TravelTask):
            here = self.models.agents[task.agent].centre(now.q[task.agent])
        else:
            here = now.X_WO[task.object].translation()
        slow = len(state.way) > 1 or self.arrival.speed(task, now) <= PASSED_SPEED
        return slow and float(np.linalg.norm(here[:2] - state.way[0])) <= PASSED
