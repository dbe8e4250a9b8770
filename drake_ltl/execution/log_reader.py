"""Turns the diagram's logs into a Recording."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterator

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context

import drake_ltl
from drake_ltl.diagrams.mission_diagram import MissionDiagram
from drake_ltl.execution.recording import NOTHING, Recording, StepRecord
from drake_ltl.multibody.postures import pose_error
from drake_ltl.planning.plan_json import action_to_json
from drake_ltl.systems.signals import NO_GRASP


def read_logs(mission: MissionDiagram, root_context: Context, num_steps: int, reason: str) -> Recording:
    """The run so far, from the logs in the context."""
    time, state, status, lyapunov = _samples(mission, root_context)
    q, qd, pose, velocity = _by_member(mission, state)
    agents = tuple(q)
    weld_index = status[:, 2 + len(agents) :].astype(int)
    gap, angle = _weld_errors(mission, agents, q, pose, weld_index)
    step = status[:, 0].astype(int)
    plan = mission.program.mission.plan
    geometry = mission.models.geometry
    return Recording(
        scenario=mission.scenario.source,
        versions=_versions(),
        agents=agents,
        objects=tuple(pose),
        agent_radius=dict(geometry.agent_radius),
        object_radius=dict(geometry.object_radius),
        team_radius=dict(geometry.team_radius),
        prefix_length=len(plan.prefix),
        suffix_length=len(plan.suffix),
        steps=tuple(_steps(mission, time, step, num_steps)),
        completed=not reason,
        reason=reason,
        time=time,
        q=q,
        qd=qd,
        centre={name: _centres(mission, name, q[name]) for name in agents},
        pose=pose,
        velocity=velocity,
        step=step,
        phase=status[:, 1].astype(int),
        mode=status[:, 2 : 2 + len(agents)].astype(int),
        grasp=_grasped(mission, tuple(pose), weld_index),
        weld_gap=gap,
        weld_angle=angle,
        lyapunov=lyapunov,
    )


def _samples(mission: MissionDiagram, root_context: Context) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """One row per step of the plant: of several samples at one time the last counts (welds are switched there)."""
    logs = {name: sink.FindLog(root_context) for name, sink in mission.logs.items()}
    whole = min(log.num_samples() for log in logs.values())  # a run that fails may leave one log ahead of another
    time = logs["state"].sample_times()[:whole]
    time_step = mission.transport_plant.plant.time_step()
    number = np.round(time / time_step)
    on_step = np.abs(time - number * time_step) < 1e-6 * time_step  # pages are published in between
    keep = np.flatnonzero(on_step)
    keep = keep[np.append(np.diff(number[keep]) > 0, True)] if len(keep) else keep
    state, status, lyapunov = (logs[name].data().T[:whole][keep] for name in ("state", "status", "lyapunov"))
    return time[keep], state, status, lyapunov[:, 0]


def _by_member(mission: MissionDiagram, state: np.ndarray):
    plant, parts = mission.transport_plant.plant, mission.transport_plant
    n_q = plant.num_positions()
    q, qd, pose, velocity = {}, {}, {}, {}
    indices = np.arange(plant.num_multibody_states(), dtype=float)
    for name, instance in (parts.agents | parts.objects).items():
        positions = plant.GetPositionsFromArray(instance, indices[:n_q]).astype(int)
        velocities = plant.GetVelocitiesFromArray(instance, indices[n_q:]).astype(int)
        here, fast = (q, qd) if name in parts.agents else (pose, velocity)
        here[name], fast[name] = state[:, positions], state[:, velocities]
    return q, qd, pose, velocity


def _centres(mission: MissionDiagram, agent: str, q: np.ndarray) -> np.ndarray:
    model = mission.models.agents[agent]
    return np.array([model.centre(row) for row in q]).reshape(-1, 3)


def _grasped(mission: MissionDiagram, objects: tuple[str, ...], weld_index: np.ndarray) -> np.ndarray:
    of_weld = np.array([objects.index(weld.object) for weld in mission.program.welds] + [NOTHING], dtype=int)
    return of_weld[np.where(weld_index == NO_GRASP, len(of_weld) - 1, weld_index)]


def _weld_errors(mission, agents, q, pose, weld_index) -> tuple[np.ndarray, np.ndarray]:
    gap, angle = np.zeros(weld_index.shape), np.zeros(weld_index.shape)
    for column, agent in enumerate(agents):
        model = mission.models.agents[agent]
        for row in np.flatnonzero(weld_index[:, column] != NO_GRASP):
            weld = mission.program.welds[weld_index[row, column]]
            (configuration,) = (g for g in mission.models.grasps[agent, weld.object] if g.name == weld.option)
            x = pose[weld.object][row]
            X_WO = RigidTransform(Quaternion(x[:4] / np.linalg.norm(x[:4])), x[4:])
            error = pose_error(model.grasp_pose(q[agent][row]), X_WO @ configuration.X_OE)
            angle[row, column], gap[row, column] = np.linalg.norm(error[:3]), np.linalg.norm(error[3:])
    return gap, angle


def _steps(mission: MissionDiagram, time: np.ndarray, step: np.ndarray, num_steps: int) -> Iterator[StepRecord]:
    for number in range(min(num_steps, step.max(initial=-1) + 1)):
        start = time[np.searchsorted(step, number, side="left")]
        after = np.searchsorted(step, number, side="right")
        finished = after < len(step)
        end = time[after] if finished else time[-1]
        actions = mission.program.steps[mission.program.index(number)].actions
        yield StepRecord(
            number,
            tuple(action_to_json(action) for action in actions),
            float(start),
            float(end - start),
            bool(finished),
        )


def _versions() -> dict[str, str]:
    versions = {name: importlib.metadata.version(name) for name in ("drake", "numpy")}
    return {"drake_ltl": drake_ltl.__version__, **versions}
