"""What the navigation function costs, and whether dense arrivals finish: python benchmarks/navigation.py

Prints a table and writes out/benchmark_navigation.json.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import timeit
from itertools import count
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from drake_ltl.navigation import NavigationFunction, RegionBall, StepRelations, Traveller, step_relations
from drake_ltl.navigation.planar import PlanarField
from drake_ltl.navigation.tuning import descend

GOALS = {3: 40.0, 10: 150.0}
"""Movers -> microseconds that value and gradient may take."""
OUT, MID = RegionBall("out", (-10.0, 0.0, 0.0), 9.0), RegionBall("mid", (12.0, 0.0, 0.0), 4.1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/benchmark_navigation.json"))
    out = parser.parse_args().out
    results = {"gradient": [gradient_cost(n, lambda_) for n, lambda_ in ((3, 0.0), (3, 1.0), (6, 0.0), (10, 0.0))]}
    results["arrivals"] = dense_arrivals(20)
    table = Table("measured", "", "goal", title="navigation functions")
    for row in results["gradient"]:
        what = f"value and gradient, {row['movers']} movers, {row['relations']} relations, lambda {row['lambda']:g}"
        goal = GOALS.get(row["movers"]) if row["lambda"] == 0.0 else None
        table.add_row(what, f"{row['microseconds']:.0f} us", f"<= {goal:.0f} us" if goal else "")
    arrivals = results["arrivals"]
    what = f"6 agents descend to random slots of a region that just holds them, kappa {arrivals['kappa']}"
    table.add_row(what, f"{arrivals['arrived']} of {arrivals['starts']} arrive", "all")
    Console().print(table)
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(json.dumps(results, indent=2) + "\n")


def gradient_cost(n: int, lambda_: float) -> dict:
    """The least of several repetitions: what others do on the machine only adds."""
    step = _spread(n)
    function = NavigationFunction.for_goal(
        step.relations, step.goal, kappa=20.0, lambda_=lambda_, n_movers=step.n_movers
    )
    gamma = float(np.square(step.start - step.goal).sum())
    calls = 500
    seconds = min(timeit.repeat(lambda: function.value_and_gradient(gamma, step.start), number=calls, repeat=40))
    return {
        "movers": n,
        "relations": len(step.relations),
        "lambda": lambda_,
        "microseconds": 1e6 * seconds / calls,
    }


def _spread(n: int) -> StepRelations:
    """n travellers between random places at least 3.2 m apart, with four regions to keep out of."""
    rng = np.random.default_rng(0)

    def places() -> np.ndarray:
        found: list[np.ndarray] = []
        while len(found) < n:
            p = np.array([*rng.uniform(-25.0, 25.0, 2), 0.9])
            if all(np.linalg.norm(p - other) > 3.2 for other in found):
                found.append(p)
        return np.array(found)

    start, goal = places(), places()
    travellers = [Traveller(f"a{i}", 1.25, "here", "there", tuple(start[i]), tuple(goal[i])) for i in range(n)]
    regions = [RegionBall("here", (0.0, 0.0, 0.0), 40.0), RegionBall("there", (0.0, 0.0, 0.0), 40.0)]
    regions += [RegionBall(f"r{k}", (50.0, 20.0 * k - 30.0, 0.0), 3.5) for k in range(4)]
    return step_relations(travellers=travellers, regions=regions, workspace_radius=80.0)


def dense_arrivals(starts: int) -> dict:
    """Six agents from random places into random slots, by the kappa that a scenario has by default."""
    kappa, arrived = 26.25, 0
    for seed in range(starts):
        field = PlanarField.of(_gathering(np.random.default_rng(seed)), kappa=kappa)
        arrived += descend(field, field.start).outcome == "goal"
    return {"starts": starts, "arrived": arrived, "kappa": kappa}


def _gathering(rng: np.random.Generator) -> StepRelations:
    slots = 2.62 * np.exp(1j * np.pi / 3.0 * rng.permutation(6))
    for _ in count():
        start = 7.0 * np.sqrt(rng.uniform(size=6)) * np.exp(2j * np.pi * rng.uniform(size=6))
        if np.abs(start[:, None] - start + 9.0 * np.eye(6)).min() > 2.6:
            break
    travellers = [
        Traveller(f"a{i}", 1.25, "out", "mid", (a.real - 10.0, a.imag, 1.0), (b.real + 12.0, b.imag, 1.0))
        for i, (a, b) in enumerate(zip(start, slots, strict=True))
    ]
    return step_relations(travellers=travellers, regions=[OUT, MID], workspace_radius=30.0)


if __name__ == "__main__":
    main()
