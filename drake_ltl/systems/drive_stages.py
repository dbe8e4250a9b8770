"""When travelling differential drives drive forwards, drive backwards or turn on the spot: rules on immutable data."""

from __future__ import annotations

from collections.abc import Iterable

from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.systems.drive_law import next_stage, sense
from drake_ltl.systems.program import TravelTask
from drake_ltl.systems.progress import Measurement, Progress


def set_out(state: Progress, task: TravelTask, models: MeasuredModels, now: Measurement) -> Progress:
    """With the sense in which the task's drive goes to its goal."""
    name = task.agent
    return state.with_agent(list(models.agents).index(name), stage=sense(now.q[name], task.q_goal))


def with_stages(state: Progress, travels: Iterable[TravelTask], models: MeasuredModels, now: Measurement) -> Progress:
    """With the stages that follow; `state` itself if all stay as they are."""
    names = list(models.agents)
    for task in travels:
        model, index = models.agents[task.agent], names.index(task.agent)
        if model.has_arm:
            continue
        before = state.agents[index].stage
        stage = next_stage(model, before, now.q[task.agent], now.qd[task.agent], task.q_goal)
        if stage != before:
            state = state.with_agent(index, stage=stage)
    return state
