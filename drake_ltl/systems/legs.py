"""What moves in a step at one time: all movers at once, or one alone on a leg of its detour."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.systems.program import StepProgram, TransportTask, TravelTask

ALL = -1
"""In place of the index of a mover: all of them."""


@dataclass(frozen=True)
class Leg:
    """What moves under the navigation function now: everything at once, or one mover by way of a point."""

    active: int = ALL
    """Index into the step's travels, then transports; ALL if every one moves."""
    via: tuple[float, float] | None = None
    """Where that mover goes first, (x, y) of its sphere's centre [m]; None if straight to its goal."""
    exchange: int = 0
    """Rank of the permutation by which the step's travellers have taken each other's places, see `exchange`."""


class Moving(NamedTuple):
    """Who moves under one navigation function."""

    travels: tuple[TravelTask, ...] = ()
    transports: tuple[TransportTask, ...] = ()
    waiting: tuple[TransportTask, ...] = ()
    """Teams that stand still for now, to move later; they count as one sphere already."""


def moving_tasks(step: StepProgram, leg: Leg, models: MeasuredModels) -> Moving:
    """What moves, and what waits, while this leg of a step is driven."""
    if leg.active == ALL:
        return Moving(step.travels, step.transports)
    if leg.active < len(step.travels):
        return Moving((_travel_via(step.travels[leg.active], leg.via, models),), (), step.transports)
    number = leg.active - len(step.travels)
    waiting = step.transports[:number] + step.transports[number + 1 :]
    return Moving((), (_transport_via(step.transports[number], leg.via),), waiting)


def _travel_via(task: TravelTask, via: tuple[float, float] | None, models: MeasuredModels) -> TravelTask:
    if via is None:
        return task
    q = task.q_goal.copy()
    q[:NUM_BASE_JOINTS] += via - models.agents[task.agent].centre(task.q_goal)[:2]
    return replace(task, q_goal=q)


def _transport_via(task: TransportTask, via: tuple[float, float] | None) -> TransportTask:
    if via is None:
        return task
    return replace(task, p_goal=np.array([*via, task.p_goal[2]]))
