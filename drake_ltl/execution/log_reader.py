"""Turns the diagram's logs into a Recording."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterator

import numpy as np
from pydrake.systems.framework import Context

import drake_ltl
from drake_ltl.diagrams.mission_diagram import MissionDiagram
from drake_ltl.execution.crew_motion import crew_motion
from drake_ltl.execution.intervals import read_intervals
from drake_ltl.execution.lyapunov_values import Bodies, lyapunov_values, moving_velocities
from drake_ltl.execution.recording import NOTHING, Recording, StepRecord
from drake_ltl.multibody.crew import CrewModel
from drake_ltl.multibody.manipulability import manipulability
from drake_ltl.planning.plan_json import action_to_json
from drake_ltl.systems.record_signal import split_record
from drake_ltl.systems.signals import NO_GRASP


def read_logs(mission: MissionDiagram, root_context: Context, num_steps: int, reason: str) -> Recording:
    """The run so far, from the logs in the context."""
    time, logged = _samples(mission, root_context)
    sizes = {name: model.n for name, model in mission.models.agents.items()}
    status, signal, reaches = split_record(_taking_effect(logged["record"]), sizes)
    torque = np.split(logged["torque"], np.cumsum(list(sizes.values())), axis=1)[: len(sizes)]
    bodies = _by_member(mission, logged["state"])
    q, qd, pose, velocity = bodies.q, bodies.qd, bodies.pose, bodies.velocity
    agents = tuple(q)
    weld_index = status[:, 2 + len(agents) :].astype(int)
    step, phase = status[:, 0].astype(int), status[:, 1].astype(int)
    intervals = list(read_intervals(mission, step, phase, signal, reaches))
    motion = crew_motion(CrewModel(mission.scenario.agents), q, moving_velocities(mission, bodies, intervals))
    plan = mission.program.mission.plan
    geometry = mission.models.geometry
    return Recording(
        scenario=mission.scenario.source,
        versions=_versions(),
        seed=mission.scenario.seed,
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
        intervals=tuple(interval.record for interval in intervals),
        monitored=mission.violations(root_context),
        time=time,
        q=q,
        qd=qd,
        centre=dict(motion.centre),
        pose=pose,
        velocity=velocity,
        step=step,
        phase=phase,
        mode=status[:, 2 : 2 + len(agents)].astype(int),
        grasp=_grasped(mission, tuple(pose), weld_index),
        lyapunov=lyapunov_values(mission, intervals, bodies, motion),
        effort=np.column_stack([_effort(mission, name, tau) for name, tau in zip(agents, torque, strict=True)]),
        manipulability=np.column_stack([_manipulability(motion.grasp_jacobian.get(n), len(time)) for n in agents]),
    )


def _samples(mission: MissionDiagram, root_context: Context) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Times (T,), and each log (T, ..) with one row per step of the plant.

    Of several samples at one time the last counts (welds are switched there).
    """
    logs = {name: sink.FindLog(root_context) for name, sink in mission.logs.items()}
    whole = min(log.num_samples() for log in logs.values())  # a run that fails may leave one log ahead of another
    time = logs["state"].sample_times()[:whole]
    time_step = mission.transport_plant.plant.time_step()
    number = np.round(time / time_step)
    on_step = np.abs(time - number * time_step) < 1e-6 * time_step  # pages are published in between
    keep = np.flatnonzero(on_step)
    keep = keep[np.append(np.diff(number[keep]) > 0, True)] if len(keep) else keep
    return time[keep], {name: log.data().T[:whole][keep] for name, log in logs.items()}


def _taking_effect(record: np.ndarray) -> np.ndarray:
    """What the supervisor decides in a state is logged one step later; here it stands beside that state."""
    return np.concatenate([record[1:], record[-1:]])


def _by_member(mission: MissionDiagram, state: np.ndarray) -> Bodies:
    plant, parts = mission.transport_plant.plant, mission.transport_plant
    n_q = plant.num_positions()
    q, qd, pose, velocity = {}, {}, {}, {}
    indices = np.arange(plant.num_multibody_states(), dtype=float)
    for name, instance in (parts.agents | parts.objects).items():
        positions = plant.GetPositionsFromArray(instance, indices[:n_q]).astype(int)
        velocities = plant.GetVelocitiesFromArray(instance, indices[n_q:]).astype(int)
        here, fast = (q, qd) if name in parts.agents else (pose, velocity)
        here[name], fast[name] = state[:, positions], state[:, velocities]
    for rows in pose.values():  # the plant's discrete steps let their length grow as they turn
        rows[:, :4] /= np.linalg.norm(rows[:, :4], axis=1, keepdims=True)
    return Bodies(q, qd, pose, velocity)


def _effort(mission: MissionDiagram, agent: str, torque: np.ndarray) -> np.ndarray:
    """(T,) of torques (T, n)."""
    return np.abs(torque / mission.models.agents[agent].effort_limits).max(axis=1)


def _manipulability(J: np.ndarray | None, samples: int) -> np.ndarray:
    """(T,) of Jacobians (T, 6, n); 0 of an agent that has no arm."""
    return np.zeros(samples) if J is None or not samples else manipulability(J)


def _grasped(mission: MissionDiagram, objects: tuple[str, ...], weld_index: np.ndarray) -> np.ndarray:
    of_weld = np.array([objects.index(weld.object) for weld in mission.program.welds] + [NOTHING], dtype=int)
    return of_weld[np.where(weld_index == NO_GRASP, len(of_weld) - 1, weld_index)]


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
