"""How long a plant's time step may be for movers that start close to what drives them off.

A controller's torque is held for a time step. The plant's step takes velocities by it, then positions by these: from
rest, for a force -g of the potential k Phi and its Hessian K, M w = -dt g and q' = q + dt w, by which

    V' - V = w^T M w / 2 + dt g^T w + dt^2 w^T K w / 2 = -w^T (M - dt^2 K) w / 2.

V falls whatever the force as long as dt is below the inverse of the fastest natural frequency of the movers in their
field, dt^2 lambda_max(M^-1 K) < 1. Damping, which only takes more, is left out.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.linalg import block_diag, eigh

from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.navigation import StepRelations
from drake_ltl.scenario.model import ControllerSettings
from drake_ltl.systems.field_value import evaluate_field
from drake_ltl.systems.program import StepProgram
from drake_ltl.systems.step_field import Snapshot, StepField

NEAR = 0.1
"""Of movers that are farther from everything K is left out [m]: barriers are steep where they are close."""
LEAST_RATE = 1.0
"""Longer time steps than its inverse need not be told apart [1/s]."""
STEP = 1e-5
"""Of the differences that K is formed of [m, rad]."""


def longest_time_step(
    field: StepField, snapshot: Snapshot, settings: ControllerSettings, models: MeasuredModels
) -> float:
    """The time step [s] beyond which V may rise as travellers with arms set out; inf if none is near anything.

    Args:
        field: of the step, for the bodies as they stand in `snapshot`.
    """
    names = [task.agent for task in field.travels if models.agents[task.agent].has_arm]
    if not names:
        return np.inf
    M = block_diag(*[models.agents[name].inertia(snapshot.q[name]) for name in names])
    K = _stiffness(field, snapshot, settings.force, models, names)
    fastest = float(eigh(K, M, eigvals_only=True)[-1])
    return 1.0 / np.sqrt(fastest) if fastest > LEAST_RATE**2 else np.inf


def nearest(relations: StepRelations) -> tuple[float, str]:
    """How near movers are to something at the start [m], at the least, and who to what."""
    return min(_slacks(relations), key=lambda slack: slack[0])[:2]


def reaches_at_begin(step: StepProgram, snapshot: Snapshot) -> Mapping[str, tuple[np.ndarray, np.ndarray]]:
    """Both ends of the ways of those who grasp or release as the step begins, for `FieldBuilder.field`."""
    moves = {task.weld.agent: task.q_OE[:2] + snapshot.p_WO[task.weld.object][:2] for task in step.grasps}
    moves |= {task.weld.agent: snapshot.q[task.weld.agent][:2] + task.retreat for task in step.releases}
    return {name: (snapshot.q[name], np.append(base, snapshot.q[name][2:])) for name, base in moves.items()}


def _slacks(relations: StepRelations) -> list[tuple[float, str, tuple[int, ...]]]:
    p, found = relations.start, []
    for pair in relations.relations.apart:
        gap = float(np.linalg.norm(p[pair.a] - p[pair.b])) - pair.radius
        found.append((gap, " and ".join(pair.label.names), (pair.a, pair.b)))
    for ball in relations.relations.inside:
        gap = ball.radius - float(np.linalg.norm(p[ball.a] - np.array(ball.centre)))
        mover, *region = ball.label.names
        found.append((gap, f"{mover} and the border of {region[0] if region else 'the workspace'}", (ball.a,)))
    return found


def _stiffness(
    field: StepField, snapshot: Snapshot, force: float, models: MeasuredModels, names: list[str]
) -> np.ndarray:
    """K (n, n) of the joints of these travellers, 0 for those that are near nothing."""
    close = {index for gap, _, points in _slacks(field.relations) if gap < NEAR for index in points}
    sizes = [models.agents[name].n for name in names]
    rows = dict(zip(names, np.split(np.arange(sum(sizes)), np.cumsum(sizes)[:-1]), strict=True))
    movers = field.relations.movers
    near = [rows[name] for name in names if movers.index(name) in close]
    K = np.zeros((sum(sizes), sum(sizes)))
    if not near:
        return K
    chosen = np.concatenate(near)

    def gradient(joint: int, away: float) -> np.ndarray:
        world = _Still(snapshot, models, field)
        (name,) = (name for name in names if joint in rows[name])
        world.configurations[name] = snapshot.q[name] + away * (rows[name] == joint)
        value = evaluate_field(field, force, models.agents, world)
        return np.concatenate([value.agents[name] for name in names])[chosen]

    columns = [(gradient(joint, STEP) - gradient(joint, -STEP)) / (2.0 * STEP) for joint in chosen]
    K[np.ix_(chosen, chosen)] = 0.5 * (np.array(columns) + np.array(columns).T)
    return K


class _Still:
    """Kinematics of agents that stand as they are told, and of loads that are turned as they are to arrive."""

    def __init__(self, snapshot: Snapshot, models: MeasuredModels, field: StepField):
        self._models, self.configurations = models, dict(snapshot.q)
        self._loads = {
            task.object: np.concatenate([task.orientation_goal, snapshot.p_WO[task.object]])
            for task in field.transports
        }

    def q(self, name: str) -> np.ndarray:
        return self._loads[name] if name in self._loads else self.configurations[name]

    def centre(self, agent: str) -> np.ndarray:
        return self._models.agents[agent].centre(self.configurations[agent])

    def centre_jacobian(self, agent: str) -> np.ndarray:
        return self._models.agents[agent].centre_jacobian(self.configurations[agent])
