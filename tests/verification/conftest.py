"""A mission of every kind of action, drawn by hand: positions follow a smooth course, no simulator is involved.

Two agents fetch crate o1 from pi2 to pi1 and back, a3 and o2 stand by in pi4. The first step is the prefix, the
other eight are one round of the suffix.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np
import pytest
import yaml

from drake_ltl.execution.recording import NOTHING, IntervalRecord, Recording, StepRecord
from drake_ltl.scenario import Scenario, loads
from drake_ltl.verification import models
from drake_ltl.verification.mechanics import Mechanics

TIME_STEP = 0.02
SAMPLES_PER_STEP = 50
HEIGHT = 0.2
RING = 0.35  # of a crate's grasp ring
APART, GRASPED = 1.3, 1.05  # distances of an agent from the crate it approaches; 1.1 m is where the spheres touch
WEST, NORTH = np.array([-1.0, 0.0]), np.array([0.0, 1.0])
PI1, PI2, PI3, PI4 = np.array([[0.0, 0.0], [10.0, 0.0], [0.0, 10.0], [10.0, 10.0]])

ARM = "package://drake_ltl_models/agents/planar_arm.urdf"
CRATE = "package://drake_ltl_models/objects/crate.sdf"
SCENARIO = {
    "name": "drawn",
    "workspace": {"radius": 20},
    "regions": {
        f"pi{k}": {"centre": [*centre.tolist(), 0], "radius": 3.5} for k, centre in enumerate((PI1, PI2, PI3, PI4), 1)
    },
    "agents": {
        "a1": {"model": ARM, "position": [0, 1], "radius": 0.7, "spec": "GF pi1 & G !pi3"},
        "a2": {"model": ARM, "position": [0, 10], "radius": 0.7, "spec": "GF dock & GF pi3"},
        "a3": {"model": ARM, "position": [10, 11], "radius": 0.7},
    },
    "objects": {
        "o1": {"model": CRATE, "position": [10, 0], "power_needed": 2, "radius": 0.4, "spec": "GF pi1 & GF pi2"},
        "o2": {"model": CRATE, "position": [10, 9], "power_needed": 2, "radius": 0.4},
    },
    "team_radius": 2.4,
    "services": {"a2": {"pi2": ["dock"]}},
    "spec": "G(o1.pi1 -> F a2.pi3) & F a2.dock",
    "simulation": {"time_step": TIME_STEP},
}


def action(kind: str, agents: str, start: str, goal: str, obj: str | None = None) -> dict:
    return {"kind": kind, "agents": agents.split(), "object": obj, "from": start, "to": goal}


# Of each step: its actions, and where a1, a2 and o1 are at its end.
STEPS = (
    (
        [action("travel", "a1", "pi1", "pi2"), action("travel", "a2", "pi3", "pi2")],
        (PI2 + APART * WEST, PI2 + APART * NORTH, PI2),
    ),
    (
        [action("grasp", "a1", "pi2", "pi2", "o1"), action("grasp", "a2", "pi2", "pi2", "o1")],
        (PI2 + GRASPED * WEST, PI2 + GRASPED * NORTH, PI2),
    ),
    ([action("transport", "a1 a2", "pi2", "pi1", "o1")], (PI1 + GRASPED * WEST, PI1 + GRASPED * NORTH, PI1)),
    ([action("release", "a2", "pi1", "pi1", "o1")], (PI1 + GRASPED * WEST, PI1 + APART * NORTH, PI1)),
    (
        [action("travel", "a2", "pi1", "pi3"), action("release", "a1", "pi1", "pi1", "o1")],
        (PI1 + APART * WEST, PI3, PI1),
    ),
    (
        [action("travel", "a2", "pi3", "pi1"), action("grasp", "a1", "pi1", "pi1", "o1")],
        (PI1 + GRASPED * WEST, PI1 + APART * NORTH, PI1),
    ),
    ([action("grasp", "a2", "pi1", "pi1", "o1")], (PI1 + GRASPED * WEST, PI1 + GRASPED * NORTH, PI1)),
    ([action("transport", "a1 a2", "pi1", "pi2", "o1")], (PI2 + GRASPED * WEST, PI2 + GRASPED * NORTH, PI2)),
    (
        [action("release", "a1", "pi2", "pi2", "o1"), action("release", "a2", "pi2", "pi2", "o1")],
        (PI2 + APART * WEST, PI2 + APART * NORTH, PI2),
    ),
)
START = (PI1 + NORTH, PI3, PI2)
AGENTS, OBJECTS = ("a1", "a2", "a3"), ("o1", "o2")


@pytest.fixture
def scenario(scenario_text: str) -> Scenario:
    return loads(scenario_text)


@pytest.fixture
def scenario_text() -> str:
    return yaml.safe_dump(SCENARIO, sort_keys=False)


@pytest.fixture
def draw(scenario_text: str) -> Callable[[int], Recording]:
    """A recording of so many steps; the suffix repeats after nine."""
    return lambda num_steps: _draw(scenario_text, num_steps)


@pytest.fixture
def recording(draw: Callable[[int], Recording]) -> Recording:
    """The prefix and one round."""
    return draw(9)


@pytest.fixture(autouse=True)
def drawn_mechanics(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drawn bodies are what the recording says they are: spheres with a gripper that points at the crate."""
    monkeypatch.setattr(models, "work_out", lambda recording, scenario: _mechanics(recording))


def _mechanics(recording: Recording) -> Mechanics:
    seen = np.arange(len(recording.time))
    return Mechanics(
        centre={name: way.copy() for name, way in recording.centre.items()},
        gripper={
            "a1": _grippers(recording.centre["a1"], -WEST),
            "a2": _grippers(recording.centre["a2"], -NORTH),
            "a3": _grippers(recording.centre["a3"], -NORTH),
        },
        ring=dict.fromkeys(OBJECTS, _gripper(np.array([RING, 0.0, 0.0]), WEST)),
        mass=dict.fromkeys(OBJECTS, 0.5),
        kinetic={name: 0.25 * np.sum(v[:, 3:] ** 2, axis=1) for name, v in recording.velocity.items()},
        lowest={name: pose[:, 6] - HEIGHT for name, pose in recording.pose.items()},
        seen=seen,
        reach={name: np.full(len(seen), 0.7) for name in AGENTS} | {name: np.array([0.4]) for name in OBJECTS},
        team_reach={(obj, agent): np.full(len(seen), 2.4) for obj in OBJECTS for agent in AGENTS},
        lyapunov=recording.lyapunov.copy(),
        goals=tuple(
            {name: np.array([*q[:2], HEIGHT]) for name, q in record.travels.items()}
            | {name: np.array(p) for name, p in record.transports.items()}
            for record in recording.intervals
        ),
        limits={name: (np.full(4, -np.inf), np.full(4, np.inf)) for name in AGENTS},
        distance=lambda agent, other, sample: 0.04,
    )


def _grippers(centre: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """X_WE (T, 4, 4) of grippers that reach the ring of a crate GRASPED ahead of the sphere's centre."""
    offset = np.array([*((GRASPED - RING) * ahead), 0.0])
    return np.array([_gripper(p, ahead) for p in centre + offset])


def _gripper(p: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """A gripper at p (3,) whose z axis points ahead and whose x axis points up."""
    z, x = np.array([*ahead, 0.0]), np.array([0.0, 0.0, 1.0])
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = np.column_stack([x, np.cross(z, x), z]), p
    return X


def _draw(text: str, num_steps: int) -> Recording:
    plan = [STEPS[k if k < 9 else 1 + (k - 1) % 8] for k in range(num_steps)]
    samples = num_steps * SAMPLES_PER_STEP + 1
    step = np.arange(samples) // SAMPLES_PER_STEP
    way, speed = _courses(plan, samples)
    pose, velocity = {}, {}
    for name in OBJECTS:
        pose[name] = np.hstack([np.tile([1.0, 0.0, 0.0, 0.0], (samples, 1)), way[name]])
        velocity[name] = np.hstack([np.zeros((samples, 3)), speed[name]])
    grasp = _grasps(plan, samples)
    return Recording(
        scenario=text,
        versions={},
        agents=AGENTS,
        objects=OBJECTS,
        agent_radius=dict.fromkeys(AGENTS, 0.7),
        object_radius=dict.fromkeys(OBJECTS, 0.4),
        team_radius=dict.fromkeys(OBJECTS, 2.4),
        prefix_length=1,
        suffix_length=8,
        steps=tuple(
            StepRecord(k, tuple(actions), k * SAMPLES_PER_STEP * TIME_STEP, SAMPLES_PER_STEP * TIME_STEP, True)
            for k, (actions, _) in enumerate(plan)
        ),
        completed=True,
        reason="",
        intervals=tuple(_intervals(plan)),
        time=TIME_STEP * np.arange(samples),
        q={name: np.pad(way[name][:, :2], ((0, 0), (0, 2))) for name in AGENTS},
        qd={name: np.pad(speed[name][:, :2], ((0, 0), (0, 2))) for name in AGENTS},
        centre={name: way[name] for name in AGENTS},
        pose=pose,
        velocity=velocity,
        step=step,
        phase=np.where(step == num_steps, 2, 0),
        mode=np.zeros((samples, 3), dtype=int),
        grasp=grasp,
        lyapunov=_lyapunov(plan, samples),
        effort=np.full((samples, len(AGENTS)), 0.5),
        manipulability=np.ones((samples, len(AGENTS))),
    )


def _intervals(plan: list) -> Iterator[IntervalRecord]:
    """One for each step in which something moves, with the places at its end for goals."""
    for k, (actions, (a1, a2, o1)) in enumerate(plan):
        ends = {"a1": (*a1, 0.0, 0.0), "a2": (*a2, 0.0, 0.0)}
        travels = {act["agents"][0]: ends[act["agents"][0]] for act in actions if act["kind"] == "travel"}
        transports = {act["object"]: (*o1, HEIGHT) for act in actions if act["kind"] == "transport"}
        if travels or transports:
            yield IntervalRecord(k, 0, travels, transports, (), {})


def _courses(plan: list, samples: int) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Positions (samples, 3) of everything, at rest between the steps, and the velocities that lead to each."""
    tau = np.arange(SAMPLES_PER_STEP) / SAMPLES_PER_STEP
    course = (10 * tau**3 - 15 * tau**4 + 6 * tau**5)[:, None]
    way = {name: np.full((samples, 3), HEIGHT) for name in (*AGENTS, *OBJECTS)}
    way["a3"][:, :2], way["o2"][:, :2] = PI4 + NORTH, PI4 - NORTH
    for column, name in enumerate(("a1", "a2", "o1")):
        ends = [START[column], *(places[column] for _, places in plan)]
        for k, (start, goal) in enumerate(pairwise(ends)):
            rows = slice(k * SAMPLES_PER_STEP, (k + 1) * SAMPLES_PER_STEP)
            way[name][rows, :2] = start + course * (goal - start)
        way[name][-1, :2] = ends[-1]
    return way, {name: np.diff(p, axis=0, prepend=p[:1]) / TIME_STEP for name, p in way.items()}


def _grasps(plan: list, samples: int) -> np.ndarray:
    """Welds close shortly before the end of a grasp and open at the begin of a release."""
    grasp = np.full((samples, 3), NOTHING)
    for k, (actions, _) in enumerate(plan):
        for act in actions:
            for name in act["agents"]:
                begin = k * SAMPLES_PER_STEP
                if act["kind"] == "grasp":
                    grasp[begin + SAMPLES_PER_STEP - 2 :, AGENTS.index(name)] = OBJECTS.index(act["object"])
                elif act["kind"] == "release":
                    grasp[begin:, AGENTS.index(name)] = NOTHING
    return grasp


def _lyapunov(plan: list, samples: int) -> np.ndarray:
    V = np.zeros(samples)
    for k, (actions, _) in enumerate(plan):
        if any(act["kind"] in ("travel", "transport") for act in actions):
            V[k * SAMPLES_PER_STEP : (k + 1) * SAMPLES_PER_STEP] = np.linspace(80.0, 0.1, SAMPLES_PER_STEP)
    return V
