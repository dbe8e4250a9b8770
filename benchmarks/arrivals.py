"""Dense arrivals: agents from random places gather in a region that just holds them."""

from __future__ import annotations

import argparse

import numpy as np

from drake_ltl.mission import measure, plan_and_place, simulate
from drake_ltl.scenario import loads
from drake_ltl.verification import Verdict, verify

RADII = {4: 3.5, 5: 3.85, 6: 4.1}
"""Of a region that holds so many agents, and hardly more [m]."""
AGENT = 'model: "package://drake_ltl_models/agents/planar_arm.urdf", radius: 1.25'


def gathering(n: int, seed: int) -> str:
    """A scenario file: n agents 4.2 m and more apart, and a region 20 m off in a random direction."""
    rng = np.random.default_rng(seed)
    starts = _starts(rng, n)
    angle = rng.uniform(0.0, 2.0 * np.pi)
    agents = [f"  a{i}: {{{AGENT}, position: [{x:.3f}, {y:.3f}]}}" for i, (x, y) in enumerate(starts)]
    return "\n".join(
        [
            f"name: gathering_{n}_{seed}",
            "workspace: {radius: 35}",
            "regions:",
            "  out: {centre: [0, 0, 0], radius: 10.5}",
            f"  mid: {{centre: [{20 * np.cos(angle):.3f}, {20 * np.sin(angle):.3f}, 0], radius: {RADII[n]}}}",
            "agents:",
            *agents,
            "objects: {}",
            f'spec: "F({" & ".join(f"a{i}.mid" for i in range(n))})"',
        ]
    )


def _starts(rng: np.random.Generator, n: int) -> np.ndarray:
    while True:
        starts = rng.uniform(-7.0, 7.0, (n, 2))
        apart = np.linalg.norm(starts[:, None] - starts, axis=-1)[np.triu_indices(n, 1)]
        if apart.min() > 4.2 and np.linalg.norm(starts, axis=1).max() < 7.0:
            return starts


def run(n: int, seed: int) -> Verdict:
    """Of one arrival."""
    scenario = loads(gathering(n, seed))
    models = measure(scenario)
    return verify(simulate(plan_and_place(scenario, models), scenario, models).recording, scenario)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=3, help="of each number of agents")
    parser.add_argument("--agents", type=int, nargs="*", default=sorted(RADII), choices=sorted(RADII))
    arguments = parser.parse_args()
    for n in arguments.agents:
        verdicts = []
        for seed in range(arguments.runs):
            verdicts.append(verdict := run(n, seed))
            stalls = f"{len(verdict.exchanges)} exchanges, {len(verdict.detours)} detours"
            clearance = verdict.min_clearance["agent_agent"]
            word = "satisfied" if verdict.satisfied else f"VIOLATED: {verdict.violations[0]}"
            time = verdict.simulated_seconds
            print(f"{n} agents, seed {seed}: {time:.1f} s, {clearance:.3f} m apart, {stalls}, {word}", flush=True)
        times = [verdict.simulated_seconds for verdict in verdicts]
        done = sum(verdict.satisfied for verdict in verdicts)
        print(f"{n} agents: {done} of {len(verdicts)} satisfied, {np.median(times):.1f} s, at most {max(times):.1f} s")


if __name__ == "__main__":
    main()
