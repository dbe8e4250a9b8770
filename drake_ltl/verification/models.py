"""Works out, with Drake, what a scenario's models make of a recording (`mechanics.Mechanics`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache

import numpy as np

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.execution.recording import Recording
from drake_ltl.multibody.agent_model import AgentModel
from drake_ltl.multibody.drive_agent import YAW, make_agent_model
from drake_ltl.multibody.object_model import ObjectModel
from drake_ltl.multibody.pair_distance import PairDistance
from drake_ltl.multibody.radii import bounding_radius, object_radius
from drake_ltl.scenario.model import Scenario
from drake_ltl.verification.headings import headings, orientation
from drake_ltl.verification.mechanics import Mechanics
from drake_ltl.verification.poses import matrices
from drake_ltl.verification.postures import springs
from drake_ltl.verification.potential import Interval, Motion, lyapunov

REACH_PERIOD = 0.05
"""Time between samples at which all collision geometry is held against the bounding spheres [s]."""


def work_out(recording: Recording, scenario: Scenario) -> Mechanics:
    """Forms all of it with Drake, from models that nothing else has touched.

    Raises:
        InvalidInputError: a model of the scenario cannot be used, or has other joints than the recorded ones.
    """
    agents = {agent.name: make_agent_model(agent, scenario) for agent in scenario.agents}
    objects = {obj.name: ObjectModel(obj) for obj in scenario.objects}
    _check_joints(recording, agents)
    centre = {name: _rows(model.centre, recording.q[name], (3,)) for name, model in agents.items()}
    pose = {name: matrices(recording.pose[name]) for name in objects}
    every = max(1, round(REACH_PERIOD / scenario.simulation.time_step))
    seen = np.arange(0, len(recording.time), every)
    volumes = {name: [model.inner_volume(q) for q in recording.q[name][seen]] for name, model in agents.items()}
    reach = {name: _farthest(volumes[name], centre[name][seen]) for name in agents}
    return Mechanics(
        centre=centre,
        gripper={
            name: _rows(lambda q, model=model: model.grasp_pose(q).GetAsMatrix4(), recording.q[name], (4, 4))
            for name, model in agents.items()
            if model.has_arm
        },
        ring={name: model.X_OG.GetAsMatrix4() for name, model in objects.items()},
        mass={name: model.mass for name, model in objects.items()},
        kinetic={name: _energy(model, recording, name) for name, model in objects.items()},
        lowest={name: _lowest(pose[name], model.balls_O) for name, model in objects.items()},
        seen=seen,
        reach=reach | {name: np.array([model.inner_radius]) for name, model in objects.items()},
        team_reach={
            (obj, agent): _farthest(volumes[agent], recording.pose[obj][seen, 4:])
            for obj in objects
            for agent in agents
        },
        lyapunov=_lyapunov(recording, scenario, agents, objects, centre),
        goals=tuple(
            {name: agents[name].centre(np.array(q)) for name, q in record.travels.items()}
            | {name: np.array(p) for name, p in record.transports.items()}
            for record in recording.intervals
        ),
        limits={
            name: (model.plant.GetPositionLowerLimits(), model.plant.GetPositionUpperLimits())
            for name, model in agents.items()
        },
        distance=_distances(recording, scenario, objects),
        measured_radius={
            **{agent.name: bounding_radius(agents[agent.name]) for agent in scenario.agents if agent.radius is None},
            **{obj.name: object_radius(objects[obj.name]) for obj in scenario.objects if obj.radius is None},
        },
    )


def _distances(
    recording: Recording, scenario: Scenario, objects: Mapping[str, ObjectModel]
) -> Callable[[str, str, int], float]:
    """Between the members of a pair at a sample; a pair's models are loaded when it is first asked for."""
    agents, places = {agent.name: agent for agent in scenario.agents}, {**recording.q, **recording.pose}

    @cache
    def scene(agent: str, other: str) -> PairDistance:
        return PairDistance(agents[agent], agents[other] if other in agents else objects[other])

    return lambda agent, other, sample: scene(agent, other)(places[agent][sample], places[other][sample])


def _check_joints(recording: Recording, agents: Mapping[str, AgentModel]) -> None:
    mistakes = [
        Mistake(f"recording.q.{name}", f"has {recording.q[name].shape[1]} joints", f"its model has {model.n}")
        for name, model in agents.items()
        if recording.q[name].shape[1] != model.n
    ]
    if mistakes:
        raise InvalidInputError(mistakes)


def _rows(function, rows: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    return np.array([function(row) for row in rows]).reshape(-1, *shape)


def _farthest(volumes: list[np.ndarray], centre: np.ndarray) -> np.ndarray:
    """(S,) of balls (m, 4) for each sample, seen from a point (S, 3)."""
    balls = np.array(volumes).reshape(len(centre), -1, 4)
    return (np.linalg.norm(balls[..., :3] - centre[:, None], axis=2) + balls[..., 3]).max(axis=1)


def _lowest(pose: np.ndarray, balls_O: np.ndarray) -> np.ndarray:
    """(T,) z of the lowest point of balls (m, 4) fixed in a body with poses (T, 4, 4)."""
    z = pose[:, 2, :3] @ balls_O[:, :3].T + pose[:, 2, 3, None]
    return (z - balls_O[:, 3]).min(axis=1)


def _lyapunov(
    recording: Recording,
    scenario: Scenario,
    agents: Mapping[str, AgentModel],
    objects: Mapping[str, ObjectModel],
    centre: Mapping[str, np.ndarray],
) -> np.ndarray:
    V = np.zeros(len(recording.time))
    energy = {name: _agent_energy(model, recording.q[name], recording.qd[name]) for name, model in agents.items()}
    energy |= {name: _energy(model, recording, name) for name, model in objects.items()}
    weights = {name: model.gamma_weights for name, model in agents.items() if model.has_arm}
    goals = _orientation_goals(recording, scenario)
    motion = Motion(recording, scenario, centre, energy, weights, goals, springs(agents, recording.q))
    for record in recording.intervals:
        goals = {name: agents[name].centre(np.array(q)) for name, q in record.travels.items()}
        ends = {name: tuple(agents[name].centre(np.array(q)) for q in reach) for name, reach in record.reaches.items()}
        interval = Interval(record, goals, ends)
        rows = interval.samples(recording)
        if len(rows):
            V[rows] = lyapunov(motion, interval, rows)
    return V


def _orientation_goals(recording: Recording, scenario: Scenario) -> dict[tuple[int, str], np.ndarray]:
    """(step, object) -> quaternion (w, x, y, z) that it should have at the end of the step."""
    after = headings(scenario, recording.steps)[1:]
    return {
        (step.number, obj.name): np.roll(orientation(obj, heading[obj.name]).as_quat(), 1)
        for step, heading in zip(recording.steps, after, strict=True)
        for obj in scenario.objects
    }


def _agent_energy(model: AgentModel, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """(T,) kinetic energy [J]; of a differential drive, that along its heading, as heavy as it is in V."""
    if model.has_arm:
        return np.array([model.kinetic_energy(*row) for row in zip(q, qd, strict=True)])
    return 0.5 * model.mass_in_V * (qd[:, 0] * np.cos(q[:, YAW]) + qd[:, 1] * np.sin(q[:, YAW])) ** 2


def _energy(model: ObjectModel, recording: Recording, name: str) -> np.ndarray:
    """(T,) kinetic energy of an object [J]."""
    R_WO = matrices(recording.pose[name])[:, :3, :3]
    w_W, v = recording.velocity[name][:, :3], recording.velocity[name][:, 3:]
    w_O = np.einsum("tji,tj->ti", R_WO, w_W)
    return 0.5 * (model.mass * np.einsum("ti,ti->t", v, v) + np.einsum("ti,ij,tj->t", w_O, model.I_OOo_O, w_O))
