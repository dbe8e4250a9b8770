"""Systems evaluated at Context level, and bodies put in their places."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from drake_ltl.diagrams import AddTransportPlant
from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from drake_ltl.planning.mission import Layout
from drake_ltl.systems.program import start_configuration
from drake_ltl.systems.state_places import StatePlaces


@pytest.fixture(scope="session")
def evaluate() -> Callable:
    """evaluate(system, port, {input: value}, time=0): the value of an output port in a fresh Context."""

    def evaluate(system: LeafSystem, port, inputs: dict, time: float = 0.0):
        context = system.CreateDefaultContext()
        context.SetTime(time)
        for name, value in inputs.items():
            system.GetInputPort(name).FixValue(context, np.asarray(value, dtype=float))
        return port.Eval(context)

    return evaluate


@dataclass
class World:
    """Where everything stands and how fast it moves."""

    q: dict[str, np.ndarray]
    qd: dict[str, np.ndarray]
    X_WO: dict[str, RigidTransform]
    V_WO: dict[str, np.ndarray]

    def state(self, name: str) -> np.ndarray:
        """As the plant's state port has it: (q, qd), or quaternion, origin, angular and linear velocity."""
        if name in self.q:
            return np.concatenate([self.q[name], self.qd[name]])
        X = self.X_WO[name]
        return np.concatenate([X.rotation().ToQuaternion().wxyz(), X.translation(), self.V_WO[name]])

    def whole_state(self, places: StatePlaces) -> np.ndarray:
        """As the plant's state port has everything."""
        x = np.zeros(places.size)
        x[places.q], x[places.qd] = np.concatenate([*self.q.values()]), np.concatenate([*self.qd.values()])
        for name in self.X_WO:
            pose, velocity = np.split(self.state(name), [7])
            x[places.pose[name]], x[places.velocity[name]] = pose, velocity
        return x

    @property
    def anchor(self) -> np.ndarray:
        return np.concatenate([*self.q.values(), *(X.translation() for X in self.X_WO.values())])


@pytest.fixture(scope="session")
def places(case_ii, models) -> StatePlaces:
    """In a plant of case ii."""
    parts = AddTransportPlant(DiagramBuilder(), case_ii, models)
    return StatePlaces.of(parts.plant, parts.agents, parts.objects)


@pytest.fixture(scope="session")
def world_at(models) -> Callable[[Layout], World]:
    """world_at(layout): all bodies at rest in their places."""

    def configuration(layout: Layout, agent: str) -> np.ndarray:
        stand = layout.agents[agent]
        if stand.grasp is None:
            return start_configuration(stand, agent, models)
        obj, option = stand.grasp
        (grasp,) = (g for g in models.grasps[agent, obj] if g.name == option)
        return grasp.q + np.array([*layout.objects[obj][:2], *np.zeros(len(grasp.q) - 2)])

    def make(layout: Layout) -> World:
        q = {agent: configuration(layout, agent) for agent in models.agents}
        return World(
            q,
            {agent: np.zeros_like(value) for agent, value in q.items()},
            {name: RigidTransform(np.array(layout.objects[name])) for name in models.objects},
            {name: np.zeros(6) for name in models.objects},
        )

    return make
