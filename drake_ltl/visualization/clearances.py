"""Clearances over time: how far the spheres of a recording are from touching [m]."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.systems.signals import Mode


@dataclass(frozen=True)
class Clearances:
    """(T,) each: the smallest clearance at every sample; infinite where there is no such pair."""

    agent_agent: np.ndarray
    agent_object: np.ndarray
    team_other: np.ndarray


def clearances(recording: Recording) -> Clearances:
    """Smallest distances between spheres, less their radii.

    An object that is carried is, with its team, one sphere of radius r_{T,j} about the object's origin; its members
    are then not counted one by one. An agent and the object that it grasps (is about to grasp, or has just let go
    in this step) must not be apart and are left out.
    """
    carried = {name: carriers(recording, name) for name in recording.objects}
    carries = {name: recording.mode[:, i] >= Mode.TRANSPORT for i, name in enumerate(recording.agents)}
    return Clearances(
        _agent_agent(recording, carries),
        _agent_object(recording, carries, carried),
        _team_other(recording, carries, carried),
    )


def carriers(recording: Recording, obj: str) -> np.ndarray:
    """(T, N) which agents carry the object."""
    return recording.mode == Mode.TRANSPORT + recording.objects.index(obj)


def attached(recording: Recording, agent: str, obj: str) -> np.ndarray:
    """(T,) whether the agent holds the object, or grasps or releases it in this step."""
    acting = [
        step.number
        for step in recording.steps
        for action in step.actions
        if action["kind"] in ("grasp", "release") and agent in action["agents"] and action["object"] == obj
    ]
    column, index = recording.agents.index(agent), recording.objects.index(obj)
    return (recording.grasp[:, column] == index) | np.isin(recording.step, acting)


def _agent_agent(recording: Recording, carries: dict[str, np.ndarray]) -> np.ndarray:
    least = _nothing(recording)
    for a, b in itertools.combinations(recording.agents, 2):
        gap = _gap(recording.centre[a], recording.centre[b], recording.agent_radius[a] + recording.agent_radius[b])
        _lower(least, gap, ~carries[a] & ~carries[b])
    return least


def _agent_object(recording: Recording, carries: dict, carried: dict) -> np.ndarray:
    least = _nothing(recording)
    for a, o in itertools.product(recording.agents, recording.objects):
        radii = recording.agent_radius[a] + recording.object_radius[o]
        gap = _gap(recording.centre[a], recording.object_origin[o], radii)
        _lower(least, gap, ~carries[a] & ~carried[o].any(axis=1) & ~attached(recording, a, o))
    return least


def _team_other(recording: Recording, carries: dict, carried: dict) -> np.ndarray:
    """Teams against agents on their own, objects at rest and other teams."""
    least = _nothing(recording)
    for o in recording.objects:
        team, r_T = carried[o].any(axis=1), recording.team_radius[o]
        for a in recording.agents:
            gap = _gap(recording.object_origin[o], recording.centre[a], r_T + recording.agent_radius[a])
            _lower(least, gap, team & ~carries[a])
        for other in recording.objects:
            if other == o:
                continue
            teams = carried[other].any(axis=1)
            radius = np.where(teams, recording.team_radius[other], recording.object_radius[other])
            gap = _gap(recording.object_origin[o], recording.object_origin[other], r_T + radius)
            _lower(least, gap, team)
    return least


def _nothing(recording: Recording) -> np.ndarray:
    return np.full(len(recording.time), np.inf)


def _gap(a: np.ndarray, b: np.ndarray, radii) -> np.ndarray:
    return np.linalg.norm(a - b, axis=1) - radii


def _lower(least: np.ndarray, gap: np.ndarray, where: np.ndarray) -> None:
    least[where] = np.minimum(least[where], gap[where])
