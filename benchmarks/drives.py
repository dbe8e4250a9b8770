"""Random mixes of differential drives and arms that cross each other's way: what becomes of them.

    python benchmarks/drives.py --seeds 100 --json out.json

Each seed is a workspace of its own, one to three drives, up to two arms (which carry a crate in every fourth), and
everybody has somewhere to go. Runs are judged by their verdicts; the exit status is 1 if any collides.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import yaml

MODELS = "package://drake_ltl_models/"
DRIVE, ARM, CRATE = (
    MODELS + name for name in ("bases/differential_drive.urdf", "agents/planar_arm.urdf", "objects/crate.sdf")
)
MOBILE = MODELS + "agents/mobile_manipulator.urdf"
RADIUS = {DRIVE: 0.28, ARM: 1.25, MOBILE: 1.25, CRATE: 0.5}
"""Of bounding spheres, as far as starts are concerned [m]."""
GAP = 0.15
"""Between spheres at the start [m]."""


def scenario(seed: int) -> dict[str, Any]:
    """A scenario file's content: who is where and goes where."""
    rng = random.Random(seed)
    carries = seed % 4 == 3
    workspace, radius = (12.0, 3.8) if carries else (9.0, 2.6)
    regions = _regions(rng, 3, radius, workspace)
    arms = [ARM, ARM] if carries else [rng.choice([ARM, ARM, MOBILE]) for _ in range(rng.randint(0, 2))]
    kinds = arms + [DRIVE] * rng.randint(1, 3)  # who needs most room first
    starts = {name: [] for name in regions}
    agents, objects = {}, {}
    if carries:
        where, to = rng.sample([*regions], 2)
        objects["o1"] = {
            "model": CRATE,
            "position": _place(rng, regions[where], CRATE, starts[where], 0.3),
            "power_needed": 2,
            "spec": f"F {to}",
        }
        others = [name for name in regions if name != where]
    for number, kind in enumerate(kinds, 1):
        order = rng.sample([*regions], 3)
        if carries and kind == ARM:
            order = [others.pop()]
        found = ((name, _place(rng, regions[name], kind, starts[name])) for name in order)
        begin, position = next(((name, place) for name, place in found if place is not None), (None, None))
        if begin is None:
            continue
        goal = rng.choice([name for name in regions if name != begin])
        agents[f"a{number}"] = {
            "model": kind,
            "position": position,
            "heading": round(rng.uniform(-math.pi, math.pi), 3)
            if kind == DRIVE
            else round(number * 2 * math.pi / 3, 4),
            "spec": f"F {goal}" if kind == DRIVE or not carries else "1",
        }
        if kind == DRIVE:
            agents[f"a{number}"]["headings"] = {goal: round(rng.uniform(-math.pi, math.pi), 3)}
    return {
        "name": f"mix_{seed}",
        "workspace": {"radius": workspace},
        "regions": regions,
        "agents": agents,
        **({"objects": objects} if objects else {}),
        "simulation": {"step_time_limit": 120.0},
    }


def _regions(rng: random.Random, count: int, radius: float, workspace: float) -> dict[str, Any]:
    found: list[tuple[float, float]] = []
    while len(found) < count:
        p = (rng.uniform(-workspace, workspace), rng.uniform(-workspace, workspace))
        if math.hypot(*p) + radius < workspace - 0.3 and all(math.dist(p, q) > 2 * radius + 0.2 for q in found):
            found.append(p)
        elif rng.random() < 0.002:
            found.clear()
    return {
        f"pi{k}": {"centre": [round(x, 2), round(y, 2), 0.0], "radius": radius} for k, (x, y) in enumerate(found, 1)
    }


def _place(
    rng: random.Random, region: dict[str, Any], kind: str, taken: list, most: float = math.inf
) -> list[float] | None:
    """Somewhere in the region, apart from what stands there."""
    x, y, _ = region["centre"]
    room = min(most, region["radius"] - RADIUS[kind] - (0.9 if kind in (ARM, MOBILE) else 0.1))
    for _ in range(200):
        r, angle = room * math.sqrt(rng.random()), rng.uniform(0.0, 2.0 * math.pi)
        p = [round(x + r * math.cos(angle), 3), round(y + r * math.sin(angle), 3)]
        arms = 0.9 if kind in (ARM, MOBILE) else 0.0
        if all(math.dist(p, q) > RADIUS[kind] + radius + GAP + arms for q, radius in taken):
            taken.append((p, RADIUS[kind] + arms))
            return p
    return None


def run(seed: int) -> dict[str, Any]:
    """What the verdict says of it."""
    from drake_ltl import loads, mission
    from drake_ltl.errors import DrakeLtlError
    from drake_ltl.verification import verify

    begin = time.process_time()
    data = scenario(seed)
    found = loads(yaml.safe_dump(data, sort_keys=False), source_name=data["name"])
    kinds = {agent.name: agent.has_arm for agent in found.agents}
    result = {
        "seed": seed,
        "drives": sum(not arm for arm in kinds.values()),
        "arms": sum(kinds.values()),
        "carries": bool(found.objects),
    }
    try:
        models = mission.measure(found)
        placed = mission.plan_and_place(found, models)
        recorded = mission.simulate(placed, found, models, suffix_rounds=1)
    except DrakeLtlError as error:
        return result | {"planned": False, "why": str(error)}
    verdict = verify(recorded.recording)
    clearances = [value for value in verdict.min_clearance.values() if value is not None]
    return result | {
        "planned": True,
        "satisfied": verdict.satisfied,
        "violations": [str(violation) for violation in verdict.violations],
        "clearance": min(clearances, default=math.inf),
        "lyapunov": verdict.max_lyapunov_increase,
        "effort": max((value for name, value in verdict.max_effort.items() if not kinds[name]), default=0.0),
        "stalls": len(verdict.detours),
        "steps": len(recorded.recording.steps),
        "longest": max(step.duration for step in recorded.recording.steps),
        "seconds": verdict.simulated_seconds,
        "cpu": time.process_time() - begin,
    }


def table(rows: Sequence[dict[str, Any]]) -> Iterator[str]:
    """A line for each kind of mix, and one for all."""
    yield "| mix | runs | satisfied | collisions | least clearance | rises of V | stalls | longest step | most torque |"
    yield "|---|---|---|---|---|---|---|---|---|"
    kinds = {
        "drives alone": lambda row: not row["arms"],
        "drives and arms": lambda row: row["arms"] and not row["carries"],
        "drives and arms that carry": lambda row: row["carries"],
        "all": lambda row: True,
    }
    for name, belongs in kinds.items():
        here = [row for row in rows if belongs(row) and row["planned"]]
        if not here:
            continue
        cells = [
            name,
            len(here),
            sum(row["satisfied"] for row in here),
            sum(row["clearance"] <= 0.0 for row in here),
            f"{min(row['clearance'] for row in here):.3f} m",
            f"{max(row['lyapunov'] for row in here):.1g}",
            sum(row["stalls"] for row in here),
            f"{max(row['longest'] for row in here):.0f} s",
            f"{100 * max(row['effort'] for row in here):.0f} %",
        ]
        yield f"| {' | '.join(map(str, cells))} |"


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=0, help="first seed (default: 0)")
    parser.add_argument("--seeds", type=int, default=100, help="number of seeds (default: 100)")
    parser.add_argument("--processes", type=int, default=1, help="(default: 1)")
    parser.add_argument("--json", type=Path, help="write all rows here")
    args = parser.parse_args(arguments)
    rows, seeds = [], range(args.first, args.first + args.seeds)
    for start in range(0, len(seeds), 10 * args.processes):  # diagrams in Python are never freed
        with ProcessPoolExecutor(args.processes) as pool:
            rows += pool.map(run, seeds[start : start + 10 * args.processes])
        if args.json:
            args.json.write_text(json.dumps(rows, indent=1))
    for row in rows:
        if not row["planned"] or not row["satisfied"]:
            print(row, file=sys.stderr)
    print("\n".join(table(rows)))
    return 1 if any(row["planned"] and row["clearance"] <= 0.0 for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
