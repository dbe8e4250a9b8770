"""Small missions drawn at random: two to four robots, one or two crates, three or four regions, formulas of every kind.

    python benchmarks/random_missions.py 7      # prints the scenario of seed 7

What is drawn may have no plan, or none that can be carried out: whoever wants a mission draws until there is one.
Formulas are drawn as trees, as `second_look` evaluates them, and written out for the scenario.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from random import Random
from typing import Any

import yaml
from second_look import Formula

AGENT = {"model": "package://drake_ltl_models/agents/planar_arm.urdf", "radius": 1.25}
OBJECT = {"model": "package://drake_ltl_models/objects/crate.sdf", "radius": 0.5, "team_radius": 2.67}
HEADINGS = (0.0, 2.0944, 4.1888, 1.5708)
"""Any two arms' planes are turned against each other, so that two of them lock a crate's tilt [rad]."""
LEAST_GAP = 2 * OBJECT["team_radius"] + 0.3
"""Between regions: teams come past each [m]."""
SIZES = ((2, 1), (2, 1), (3, 1), (3, 1), (4, 1), (2, 2))
"""Robots and crates: what is planned within a second."""
FIELD = 14.0
"""Centres of regions lie in a square of twice this side [m]."""
TRIES = 400
"""To find room for a region or a body."""


@dataclass(frozen=True)
class Drawn:
    """A scenario's text, and all its formulas as trees over ("is", member, region)."""

    text: str
    formulas: tuple[Formula, ...]


class CrowdedError(Exception):
    """What was drawn does not fit into what was drawn before."""


def draw(seed: object) -> Drawn:
    """The mission of a seed. Raises CrowdedError where there is no room."""
    chance = Random(f"mission {seed}")
    names = ["north", "east", "south", "west"][: chance.randint(3, 4)]
    regions = _regions(chance, names)
    num_agents, num_objects = chance.choice(SIZES)
    agents = [f"a{k + 1}" for k in range(num_agents)]
    objects = [f"o{k + 1}" for k in range(num_objects)]
    homes = {member: chance.choice(names) for member in (*agents, *objects)}
    places = _places(chance, regions, homes)
    powers = {agent: chance.randint(1, 3) for agent in agents}
    own = {agent: _agent_duty(chance, agent, names, homes[agent]) for agent in agents}
    own |= {obj: _object_duty(chance, obj, names, homes[obj]) for obj in objects}
    common = _common_duty(chance, agents, objects, names)
    scenario: dict[str, Any] = {
        "name": "random_mission",
        "workspace": {"radius": round(_reach(regions) + LEAST_GAP, 1)},
        "regions": {name: {"centre": [x, y, 0.0], "radius": r} for name, (x, y, r) in regions.items()},
        "agents": {
            agent: AGENT
            | {"position": places[agent], "heading": HEADINGS[k], "power": powers[agent]}
            | {"spec": written(own[agent], alone=True)}
            for k, agent in enumerate(agents)
        },
        "objects": {
            obj: OBJECT
            | {"position": places[obj], "power_needed": _power(chance, powers)}
            | {"spec": written(own[obj], alone=True)}
            for obj in objects
        },
        "spec": written(common),
        "simulation": {"time_step": chance.choice([0.005, 0.01])},
    }
    return Drawn(yaml.safe_dump(scenario, sort_keys=False), (*own.values(), common))


def _regions(chance: Random, names: list[str]) -> dict[str, tuple[float, float, float]]:
    """Balls on the floor (x, y, radius) [m], so far apart that teams come past."""
    found: dict[str, tuple[float, float, float]] = {}
    for name in names:
        for _ in range(TRIES):
            radius = round(chance.uniform(3.3, 5.0), 1)
            x, y = (round(chance.uniform(-FIELD, FIELD), 1) for _ in range(2))
            if all(math.dist((x, y), (p, q)) >= radius + r + LEAST_GAP for p, q, r in found.values()):
                found[name] = x, y, radius
                break
        else:
            raise CrowdedError("no room for a region")
    return found


def _reach(regions: dict[str, tuple[float, float, float]]) -> float:
    return max(math.hypot(x, y) + r for x, y, r in regions.values())


def _places(chance: Random, regions: dict[str, tuple[float, float, float]], homes: dict[str, str]) -> dict[str, list]:
    """Positions [m]: crates near the centre, where they have room to be grasped; robots anywhere, apart from all."""
    found: dict[str, list[float]] = {}
    for member in sorted(homes, reverse=True):  # objects first
        x, y, radius = regions[homes[member]]
        reach = 0.7 if member.startswith("o") else radius - AGENT["radius"] - 0.1
        for _ in range(TRIES):
            angle, distance = chance.uniform(0.0, 2.0 * math.pi), reach * math.sqrt(chance.random())
            place = [round(x + distance * math.cos(angle), 3), round(y + distance * math.sin(angle), 3)]
            if all(math.dist(place, other) >= 2.0 for other in found.values()):  # the planner asks for more
                found[member] = place
                break
        else:
            raise CrowdedError("no room for a body")
    return found


def _power(chance: Random, powers: dict[str, int]) -> int:
    """What some one or two of the agents have."""
    return sum(powers[agent] for agent in chance.sample(sorted(powers), chance.choice([1, 2, 2])))


def _agent_duty(chance: Random, agent: str, names: list[str], home: str) -> Formula:
    first, second = (("is", agent, name) for name in chance.sample(names, 2))
    away = ("is", agent, chance.choice([name for name in names if name != home]))
    return chance.choice(
        [
            ("true",),
            ("true",),
            ("F", first),
            ("G", ("!", away)),
            ("&", ("F", first), ("F", second)),
            ("G", ("F", first)),
            ("U", ("!", away), first),
            ("F", ("G", first)),
            ("&", ("F", first), ("G", ("!", ("&", away, ("X", away))))),
        ]
    )


def _object_duty(chance: Random, obj: str, names: list[str], home: str) -> Formula:
    first, second = (("is", obj, name) for name in chance.sample([name for name in names if name != home], 2))
    return chance.choice(
        [
            ("true",),  # others have to come past it
            ("true",),
            ("true",),
            ("G", ("is", obj, home)),
            ("F", first),
            ("F", first),
            ("F", ("&", first, ("X", first))),
            ("&", ("F", first), ("G", ("!", second))),
            ("F", ("|", first, second)),
            ("F", ("G", first)),
        ]
    )


def _common_duty(chance: Random, agents: list[str], objects: list[str], names: list[str]) -> Formula:
    one, two = chance.sample(agents, 2)
    here, there = chance.sample(names, 2)
    obj = chance.choice(objects)
    return chance.choice(
        [
            ("true",),
            ("true",),
            ("F", ("&", ("is", one, here), ("is", two, there))),
            ("G", ("!", ("&", ("is", one, here), ("is", two, here)))),
            ("F", ("&", ("is", one, here), ("!", ("is", obj, here)))),
        ]
    )


def written(formula: Formula, alone: bool = False) -> str:
    """As scenarios have it; `alone`: a member's own formula names regions only."""
    head, *parts = formula
    if head == "true":
        return "1"
    if head == "is":
        return parts[1] if alone else ".".join(parts)
    texts = [written(part, alone) for part in parts]
    return f"{head}({texts[0]})" if len(texts) == 1 else f"({texts[0]}) {head} ({texts[1]})"


if __name__ == "__main__":
    print(draw(int(sys.argv[1])).text)
