"""A small recording made by hand: two agents drive, grasp, carry a crate and let it go."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from drake_ltl.execution.recording import NOTHING, Recording, StepRecord
from drake_ltl.scenario.model import Agent, Region, Scenario, TransportObject
from drake_ltl.systems.signals import Mode

SAMPLES = 40
"""Of each of the four steps."""


def action(kind, agents, start, goal, obj=None) -> dict:
    return {"kind": kind, "agents": agents, "object": obj, "from": start, "to": goal}


STEPS = (
    (action("travel", ["a"], "west", "east"), action("travel", ["b"], "west", "east")),
    (action("grasp", ["a"], "east", "east", "crate"), action("grasp", ["b"], "east", "east", "crate")),
    (action("transport", ["a", "b"], "east", "west", "crate"),),
    (action("release", ["a"], "west", "west", "crate"),),
)


@pytest.fixture
def scenario() -> Scenario:
    return Scenario(
        name="by_hand",
        workspace_radius=20.0,
        regions=(Region("west", (-10.0, 0.0, 0.0), 4.0), Region("east", (10.0, 0.0, 0.0), 4.0)),
        agents=tuple(Agent(name, "model.urdf", (-10.0, y), 0.0, 1) for name, y in (("a", -2.0), ("b", 2.0))),
        objects=(
            TransportObject("crate", "model.sdf", (10.0, 0.0), 2),
            TransportObject("idle", "model.sdf", (0.0, 15.0), 2),
        ),
    )


@pytest.fixture
def recording() -> Recording:
    s = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    still = np.zeros_like(s)

    def way(*corners):
        """(4 SAMPLES, 3): straight from corner to corner, one for each step."""
        points = np.array(corners, dtype=float)
        return np.concatenate([a + s * (b - a) for a, b in itertools.pairwise(points)])

    def still_at(point):
        return way(*[point] * 5)

    centre = {
        "a": way((-10, -2, 0.5), (10, -2, 0.5), (10, -1.5, 0.5), (-10, -1.5, 0.5), (-10, -2, 0.5)),
        "b": way((-10, 2, 0.5), (10, 2, 0.5), (10, 1.5, 0.5), (-10, 1.5, 0.5), (-10, 1.5, 0.5)),
    }
    origin = {"crate": way((10, 0, 0.3), (10, 0, 0.3), (10, 0, 0.3), (-10, 0, 0.3), (-10, 0, 0.3))}
    origin["idle"] = still_at((0, 15, 0.3))
    upright = np.tile([1.0, 0, 0, 0], (4 * SAMPLES, 1))
    hold, carry = int(Mode.HOLD), int(Mode.TRANSPORT)
    mode = np.repeat([[1, 1], [2, 2], [carry, carry], [2, hold]], SAMPLES, axis=0)
    grasp = np.repeat([[NOTHING] * 2, [NOTHING] * 2, [0, 0], [NOTHING, 0]], SAMPLES, axis=0)
    time = np.linspace(0.0, 40.0, 4 * SAMPLES)
    moving = np.repeat([1.0, 0.0, 1.0, 0.0], SAMPLES)
    return Recording(
        scenario="",
        versions={},
        agents=("a", "b"),
        objects=("crate", "idle"),
        agent_radius={"a": 1.0, "b": 1.0},
        object_radius={"crate": 0.4, "idle": 0.5},
        team_radius={"crate": 3.0, "idle": 3.0},
        prefix_length=2,
        suffix_length=2,
        steps=tuple(
            StepRecord(number, actions, float(time[number * SAMPLES]), 10.0, True)
            for number, actions in enumerate(STEPS)
        ),
        completed=True,
        reason="",
        intervals=(),
        time=time,
        q={name: points[:, :2] for name, points in centre.items()},
        qd={name: np.zeros((4 * SAMPLES, 2)) for name in centre},
        centre=centre,
        pose={name: np.hstack([upright, points]) for name, points in origin.items()},
        velocity={name: np.zeros((4 * SAMPLES, 6)) for name in origin},
        step=np.repeat(np.arange(4), SAMPLES),
        phase=np.zeros(4 * SAMPLES, dtype=int),
        mode=mode,
        grasp=grasp,
        lyapunov=moving * np.concatenate([np.exp(-5 * s[:, 0]), still[:, 0]] * 2),
        effort=np.full((4 * SAMPLES, 2), 0.5),
        manipulability=np.ones((4 * SAMPLES, 2)),
    )
