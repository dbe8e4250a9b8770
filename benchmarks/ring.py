"""Seeded problems of any size: regions on a ring, objects that commute, teams of two or three to carry them."""

from __future__ import annotations

import argparse
import json
import math
import random
import time

from drake_ltl.planning.bounded import Progress, plan_bounded
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.plan import State
from drake_ltl.scenario.model import Agent, PublishedFits, Region, Scenario, TransportObject

RADIUS = 24.0
"""Of the ring of the regions' centres [m]."""
CAPACITY = PublishedFits(agent=1.25, grasping=2.5, object=0.5, capacity=12.0)


def ring(n_agents: int, n_objects: int, n_regions: int, seed: int = 0) -> tuple[Scenario, State]:
    """A scenario and its initial state.

    Agents have power 2, 3 or 4 and start in random regions; about every third has a formula of its own: it must
    visit some region again and again, or never enter one. Each object must be in two regions again and again and
    needs power 5 to 8: two or three agents.
    """
    chance = random.Random(f"{n_agents} {n_objects} {n_regions} {seed}")
    names = [f"r{k}" for k in range(n_regions)]
    # At most three bodies of each kind start in a region, so that all fit.
    agents_at = _spread(chance, names, n_agents)
    objects_at = _spread(chance, names, n_objects)
    agents = tuple(
        Agent(f"a{i}", "", (0.0, 0.0), 0.0, float(chance.randint(2, 4)), _duty(chance, i, names, at))
        for i, at in enumerate(agents_at)
    )
    objects = []
    for j in range(n_objects):
        first, second = chance.sample(names, 2)
        spec = f"GF {first} & GF {second}"
        objects.append(TransportObject(f"o{j}", "", (0.0, 0.0), float(chance.randint(5, 8)), spec))
    scenario = Scenario(
        name=f"ring_{n_agents}_{n_objects}_{n_regions}_{seed}",
        workspace_radius=2.0 * RADIUS,
        regions=tuple(Region(name, _place(k, n_regions), 3.5) for k, name in enumerate(names)),
        agents=agents,
        objects=tuple(objects),
        fits=CAPACITY,
        seed=seed,
    )
    return scenario, State(tuple(agents_at), tuple(objects_at), (None,) * n_agents)


def _spread(chance: random.Random, names: list[str], n: int) -> list[str]:
    places = names * math.ceil(n / len(names))
    return chance.sample(places, n)


def _place(k: int, n_regions: int) -> tuple[float, float, float]:
    """Rounded to decimetres, so that squared distances are exact decimal fractions."""
    angle = 2.0 * math.pi * k / n_regions
    return round(RADIUS * math.cos(angle), 1), round(RADIUS * math.sin(angle), 1), 0.0


def _duty(chance: random.Random, i: int, names: list[str], at: str) -> str:
    if i % 3:
        return "1"
    region = chance.choice([name for name in names if name != at])
    return chance.choice([f"GF {region}", f"G !{region}"])


def measure(n_agents: int, n_objects: int, n_regions: int, seed: int, seconds: float) -> dict[str, object]:
    """Plan one problem within a time; every plan is checked by its certificate."""
    scenario, start = ring(n_agents, n_objects, n_regions, seed)
    history: list[Progress] = []
    used = time.process_time()
    fits = published_fits(CAPACITY)
    plan = plan_bounded(scenario, start, fits, time_limit=seconds, report=history.append)
    return {
        "problem": scenario.name,
        "cost": plan.cost,
        "lower_bound": plan.lower_bound,
        "gap": history[-1].gap,
        "status": plan.status,
        "moves": len(plan.moves),
        "first_plan_seconds": next(p.seconds for p in history if p.cost is not None),
        "seconds": plan.seconds["total"],
        "cpu_seconds": time.process_time() - used,
    }


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sizes", nargs="*", default=["10,4,6", "16,5,8", "30,10,10"], help="agents,objects,regions")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=60.0)
    arguments = parser.parse_args()
    for size in arguments.sizes:
        numbers = (int(number) for number in size.split(","))
        print(json.dumps(measure(*numbers, arguments.seed, arguments.seconds)), flush=True)
