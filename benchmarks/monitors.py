"""What monitors cost a simulation: `python benchmarks/monitors.py [SCENARIO]`.

A mission is run with and without them, second by second in turns, so that both meet the same load of the machine, and
several times over. What counts of each simulated second is the least CPU time that it took.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import timeit
from pathlib import Path
from time import process_time

import numpy as np
from drake_ltl.diagrams import MakeMissionDiagram, MissionDiagram
from pydrake.systems.analysis import Simulator

from drake_ltl.execution.grasping import ApplyGrasps
from drake_ltl.mission import measure, num_steps, plan_and_place
from drake_ltl.scenario import load

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


def main() -> None:
    parser = argparse.ArgumentParser(description="Measures what monitors cost; prints a table.")
    parser.add_argument("scenario", type=Path, nargs="?", default=EXAMPLES / "case_ii.yaml")
    parser.add_argument("--seconds", type=int, default=40, help="simulated")
    parser.add_argument("--runs", type=int, default=5)
    args = parser.parse_args()
    scenario = load(args.scenario)
    models = measure(scenario)
    mission = plan_and_place(scenario, models)
    steps = num_steps(mission, 1)
    both = [MakeMissionDiagram(mission, scenario, models, num_steps=steps, monitors=with_) for with_ in (True, False)]
    seconds = np.min([in_turns(both, args.seconds) for _ in range(args.runs)], axis=0).sum(axis=1) / args.seconds
    ratios = seconds[0] / seconds[1]
    print(f"{scenario.name}: {1e3 * seconds[0]:.2f} ms for each simulated second with monitors,")
    print(f"{1e3 * seconds[1]:.2f} ms without, ratio {ratios:.3f} (least of {args.runs}, {args.seconds} s simulated)")
    for name, (cost, period) in looks(both[0]).items():
        print(f"{name:18} {1e6 * cost:6.0f} us a look, every {period:.3g} s: {1e3 * cost / period:5.2f} ms per second")


def in_turns(missions: list[MissionDiagram], seconds: int) -> np.ndarray:
    """CPU time (2, seconds) [s] of every simulated second of each."""
    simulators = [Simulator(mission.diagram, mission.CreateStartContext()) for mission in missions]
    for simulator in simulators:
        simulator.Initialize()
    spent = np.zeros((len(missions), seconds))
    for second in range(seconds):
        for row, (mission, simulator) in enumerate(zip(missions, simulators, strict=True)):
            begin = process_time()
            advance(mission, simulator, second + 1)
            spent[row, second] = process_time() - begin
    return spent


def advance(mission: MissionDiagram, simulator: Simulator, time: float) -> None:
    """As the runner does."""
    context = simulator.get_mutable_context()
    time_step = mission.transport_plant.plant.time_step()
    while context.get_time() < time - 0.5 * time_step:
        if mission.supervisor.grasps_pending(mission.supervisor.GetMyContextFromRoot(context)):
            ApplyGrasps(mission, context)
        simulator.AdvanceTo(round(time / time_step) * time_step)


def looks(mission: MissionDiagram) -> dict[str, tuple[float, float]]:
    """monitor -> CPU time of a look in a new state [s], signals of others included, and its period [s]."""
    root = mission.CreateStartContext()
    plant = mission.transport_plant.plant
    state = plant.GetMyMutableContextFromRoot(root)
    Simulator(mission.diagram, root).Initialize()
    x = plant.GetPositionsAndVelocities(state)
    progress = mission.supervisor.get_progress_output_port()

    def new_state() -> None:
        plant.SetPositionsAndVelocities(state, x)
        progress.Eval(mission.supervisor.GetMyContextFromRoot(root))

    idle = least(new_state)
    found = {}
    for name, monitor in mission.monitors.items():
        context = monitor.GetMyContextFromRoot(root)

        def look(monitor=monitor, context=context) -> None:
            new_state()
            monitor.Look(context)

        found[name] = least(look) - idle, monitor.period
    return found


def least(work, number: int = 200) -> float:
    """[s] each."""
    return min(timeit.repeat(work, number=number, repeat=7, timer=process_time)) / number


if __name__ == "__main__":
    main()
