"""V of a run, worked out from its logs for all samples at once: a simulation does not stop for it at every step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from drake_ltl.diagrams.mission_diagram import MissionDiagram
from drake_ltl.dynamics.load_spring import LoadSpring
from drake_ltl.execution.crew_motion import CrewMotion
from drake_ltl.execution.intervals import Interval
from drake_ltl.multibody.agent_model import AgentModel
from drake_ltl.systems.field_value import ROTATION_WEIGHT
from drake_ltl.systems.posture_springs import posture_spring
from drake_ltl.systems.program import TransportTask
from drake_ltl.systems.step_field import FieldBuilder, Snapshot

TOUCHING = 1e300
"""V where spheres touch [J]: a recording has finite numbers only."""


@dataclass(frozen=True)
class Bodies:
    """Where everything was, one row per sample."""

    q: Mapping[str, np.ndarray]
    """agent -> (T, n_i)"""
    qd: Mapping[str, np.ndarray]
    """agent -> (T, n_i)"""
    pose: Mapping[str, np.ndarray]
    """object -> unit quaternion and origin (T, 7)"""
    velocity: Mapping[str, np.ndarray]
    """object -> (T, 6) (rotational; translational)"""

    def snapshot(self, row: int) -> Snapshot:
        """Where all stood at one sample."""
        q = {name: rows[row] for name, rows in self.q.items()}
        return Snapshot(q, {name: rows[row, 4:] for name, rows in self.pose.items()})


def moving_velocities(mission: MissionDiagram, bodies: Bodies, intervals: Sequence[Interval]) -> np.ndarray:
    """qd of all agents, stacked (T, n); 0 of those who do not move under a navigation function, and of drives, of whose
    energy not all counts."""
    moving = {name: np.zeros_like(qd) for name, qd in bodies.qd.items()}
    for interval in intervals:
        travels, transports, _ = interval.moving
        travelling = (task.agent for task in travels if mission.models.agents[task.agent].has_arm)
        for name in (*travelling, *(agent for task in transports for agent in task.team)):
            moving[name][interval.rows] = bodies.qd[name][interval.rows]
    return np.concatenate([*moving.values()], axis=1)


def lyapunov_values(
    mission: MissionDiagram, intervals: Sequence[Interval], bodies: Bodies, motion: CrewMotion
) -> np.ndarray:
    """V (T,) [J], see `systems.NavigationField`; 0 while nothing moves under a navigation function.

    Args:
        motion: of `bodies`, with the energy of `moving_velocities`.
    """
    V, builder = np.zeros(len(motion.kinetic_energy)), FieldBuilder(mission.scenario, mission.models)
    begins: dict[int, int] = {}  # of steps: where springs rest
    for interval in intervals:
        here = interval.rows
        begin = begins.setdefault(interval.step, here.start)
        V[here] = mission.scenario.controller.force * _potential(mission, builder, interval, bodies, motion)
        V[here] += motion.kinetic_energy[here]
        for task in interval.moving.travels:
            V[here] += _drive_energy(mission.models.agents[task.agent], bodies, here)
        for task in interval.moving.transports:
            V[here] += _kinetic_energy(mission, task.object, bodies, here)
            V[here] += LoadSpring(task.p_goal, task.orientation_goal).energy(bodies.pose[task.object][here])
            for name in task.team:
                V[here] += _posture_energy(mission.models.agents[name], bodies.q[name], begin, motion, here)
    return np.where(np.isfinite(V), V, TOUCHING)


def _potential(
    mission: MissionDiagram, builder: FieldBuilder, interval: Interval, bodies: Bodies, motion: CrewMotion
) -> np.ndarray:
    """Phi (m,)."""
    here, (travels, transports, _) = interval.rows, interval.moving
    field = builder.field(interval.moving, bodies.snapshot(here.start), interval.reaches)
    gamma, p = np.zeros(here.stop - here.start), []
    for task in travels:
        gamma += mission.models.agents[task.agent].gamma(bodies.q[task.agent][here], task.q_goal)
        p.append(motion.centre[task.agent][here])
    for task in transports:
        pose = bodies.pose[task.object][here]
        gamma += ((pose[:, 4:] - task.p_goal) ** 2).sum(axis=1) + ROTATION_WEIGHT * _mismatch(pose, task)
        p.append(np.column_stack([pose[:, 4:6], np.full(len(pose), task.p_goal[2])]))
    return field.function.value(gamma, field.relations.at(np.stack(p, axis=1)))


def _mismatch(pose: np.ndarray, task: TransportTask) -> np.ndarray:
    """2 (1 - cos angle) (m,) between orientations and their goal: 4 (1 - <quaternion, goal>^2)."""
    goal = task.orientation_goal / np.linalg.norm(task.orientation_goal)
    away = pose[:, :4] - (pose[:, :4] @ goal)[:, None] * goal  # its square is 1 - <, >^2 without cancellation
    return 4.0 * (away**2).sum(axis=1)


def _kinetic_energy(mission: MissionDiagram, obj: str, bodies: Bodies, here: slice) -> np.ndarray:
    model = mission.models.objects[obj]
    states = zip(bodies.pose[obj][here, :4], bodies.velocity[obj][here], strict=True)
    return np.array([model.kinetic_energy(quaternion, V_WO) for quaternion, V_WO in states])


def _drive_energy(model: AgentModel, bodies: Bodies, here: slice) -> np.ndarray | float:
    """Of a differential drive."""
    if model.has_arm:
        return 0.0
    name = model.agent.name
    return np.array([model.energy(*row) for row in zip(bodies.q[name][here], bodies.qd[name][here], strict=True)])


def _posture_energy(
    model: AgentModel, q: np.ndarray, begin: int, motion: CrewMotion, here: slice
) -> np.ndarray | float:
    """h of a redundant agent that carries; its spring rests where the step began."""
    if not model.is_redundant:
        return 0.0
    spring, J = posture_spring(model, q[begin]), motion.grasp_jacobian[model.agent.name]
    return np.array([spring.energy(*row) for row in zip(q[here], J[here], strict=True)])
