"""Small random problems."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest

from drake_ltl.planning.plan import State
from drake_ltl.scenario.model import Agent, PublishedFits, Region, Scenario, TransportObject

ROOMY = PublishedFits(agent=1.0, grasping=1.0, object=1.0, capacity=100.0)


def _formula(chance: random.Random, names: list[str], depth: int) -> str:
    if depth == 0 or chance.random() < 0.2:
        return chance.choice(["", "!"]) + chance.choice(names)
    if chance.random() < 0.6:
        return f"{chance.choice(['X', 'F', 'G', 'GF', 'FG', 'GF', 'F'])}({_formula(chance, names, depth - 1)})"
    first, second = (_formula(chance, names, depth - 1) for _ in range(2))
    return f"({first}) {chance.choice(['&', '|', 'U', '->'])} ({second})"


def _random_problem(seed: int, n_regions: int = 3) -> tuple[Scenario, State]:
    """At most two agents and two objects; every capacity, power and formula by chance."""
    chance = random.Random(seed)
    n_agents, n_objects = chance.choice([(1, 0), (1, 1), (2, 0), (2, 1), (2, 1), (2, 2)])
    names = [f"r{k}" for k in range(n_regions)]
    depth = 3 if n_objects < 2 else 2
    points = chance.sample([(0, 0), (3, 0), (5, 1), (1, 4), (6, 5)], n_regions)
    agents = tuple(
        Agent(
            f"a{i}",
            "",
            (0.0, 0.0),
            0.0,
            float(chance.randint(1, 2)),
            chance.choice([_formula(chance, names, depth), "1"]),
        )
        for i in range(n_agents)
    )
    objects = tuple(
        TransportObject(f"o{j}", "", (0.0, 0.0), float(chance.randint(1, 3)), _formula(chance, names, depth))
        for j in range(n_objects)
    )
    members = [member.name for member in agents + objects]
    together = [f"{member}.{name}" for member in members for name in names]
    scenario = Scenario(
        name=f"random_{seed}",
        workspace_radius=30.0,
        regions=tuple(Region(name, (float(x), float(y), 0.0), 0.4) for name, (x, y) in zip(names, points, strict=True)),
        agents=agents,
        objects=objects,
        spec=chance.choice(["1", _formula(chance, together, 2)]),
        fits=chance.choice([ROOMY, PublishedFits(1.0, 1.0, 1.0, 3.0), PublishedFits(1.0, 2.0, 0.5, 3.5)]),
    )
    start = State(
        tuple(chance.choice(names) for _ in agents), tuple(chance.choice(names) for _ in objects), (None,) * n_agents
    )
    return scenario, start


@pytest.fixture(scope="session")
def random_problem() -> Callable[..., tuple[Scenario, State]]:
    return _random_problem
