"""What simulating a mission costs: `make bench`, or `python benchmarks/simulation.py --help`.

Each mission is run twice at once, in a process of its own: driven by its controllers, with everything that a recording
needs logged at every step, and, once every simulated second, for a quarter of a second from the same state with the
same welds by the same plant under constant torques, without logs, objects that rest borne as in the mission. Both meet
the same load of the machine; what is held against each other is CPU time per step of the plant. Reading the logs when a
run is over, which works V out, is measured by itself, and so are the monitors that watch a mission unless it is told
otherwise.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import platform
import resource
import statistics
import subprocess
import sys
import time
import timeit
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from drake_ltl.diagrams import AddTransportPlant, MakeMissionDiagram, MissionDiagram
from drake_ltl.diagrams.quiet import without_half_space_warning
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource
from rich.console import Console
from rich.table import Table

from drake_ltl.execution.log_reader import read_logs
from drake_ltl.execution.runner import RunMission
from drake_ltl.mission import measure, num_steps, plan_and_place
from drake_ltl.scenario import load, loads
from drake_ltl.scenario.model import Scenario
from drake_ltl.verification import verify

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
PIECE = 50
"""Steps of the plant under constant torques, each time."""
WANTED = {"case_ii": "1.5 x, factor 20", "ten_agents": "factor 1"}


def main() -> None:
    parser = argparse.ArgumentParser(description="Measures simulation; prints a table and writes JSON.")
    parser.add_argument("--runs", type=int, default=3, help="fresh processes for each mission; the median ratio counts")
    parser.add_argument("--json", type=Path, default=Path("out/benchmark_simulation.json"))
    parser.add_argument("--work", nargs="*", default=list(MISSIONS), choices=MISSIONS, help="what to measure")
    parser.add_argument("--measure", nargs=2, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.measure:
        name, variant = args.measure
        print(json.dumps(measure_mission(MISSIONS[name](), **VARIANTS[variant])))
        return
    results: dict[str, Any] = {"machine": {"cores": os.cpu_count(), "python": platform.python_version()}}
    results["load"] = os.getloadavg()
    results["callback_us"] = callback_cost()
    for name in args.work:
        results[name] = median_run([in_fresh_process(name, "together") for _ in range(args.runs)])
    if "case_ii" in args.work:
        results["case_ii, monitored"] = in_fresh_process("case_ii", "monitored")
        results["case_ii, separate controllers"] = in_fresh_process("case_ii", "separate")
    args.json.parent.mkdir(parents=True, exist_ok=True)
    args.json.write_text(json.dumps(results, indent=2) + "\n")
    show(results)


def in_fresh_process(name: str, variant: str) -> dict[str, Any]:
    """One mission; {"failed": why} if the process does not come to an end."""
    command = [sys.executable, __file__, "--measure", name, variant]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=900.0, check=True)
    except subprocess.TimeoutExpired:
        return {"failed": "not finished after 900 s"}
    except subprocess.CalledProcessError as error:
        return {"failed": (error.stderr or f"status {error.returncode}").strip().splitlines()[-1]}
    return json.loads(done.stdout)


def median_run(runs: list[dict[str, Any]]) -> dict[str, Any]:
    """The run whose ratio is the median, and all ratios; the first that failed, if any did."""
    for run in runs:
        if "failed" in run:
            return run
    ratios = [run["ratio"] for run in runs]
    chosen = runs[ratios.index(statistics.median_low(ratios))]
    return chosen | {"ratios": ratios, "realtime_factors": [run["realtime_factor"] for run in runs]}


# What is measured


def ten_agents() -> Scenario:
    """Ten arms that drive side by side from their regions to others, all at once."""
    lines = ["name: ten", "workspace: {radius: 40.0}", "regions:"]
    lines += [f"  {side}{i}: {{centre: [{x}, {6 * i - 27}, 0.0], radius: 2.5}}" for i in range(10) for side, x in SIDES]
    lines += ["agents:"]
    lines += [
        f"  a{i}: {{model: {ARM}, position: [-9.8, {6 * i - 27}], spec: 'F far{i} & G(far{i} -> X far{i})'}}"
        for i in range(10)
    ]
    return loads("\n".join(lines) + "\n")


def case_ii_with_longer_steps() -> Scenario:
    """Case ii at twice the usual time step of the plant."""
    text = (EXAMPLES / "case_ii.yaml").read_text(encoding="utf-8")
    return loads(f"{text}\nsimulation: {{time_step: 0.01}}\n", base=EXAMPLES)


ARM = "package://drake_ltl_models/agents/planar_arm.urdf"
SIDES = (("near", -10.0), ("far", 10.0))
MISSIONS: dict[str, Callable[[], Scenario]] = {
    "case_ii": lambda: load(EXAMPLES / "case_ii.yaml"),
    "case_ii_10_ms": case_ii_with_longer_steps,
    "case_i": lambda: load(EXAMPLES / "case_i.yaml"),
    "example_1": lambda: load(EXAMPLES / "example_1.yaml"),
    "ten_agents": ten_agents,
}


VARIANTS: dict[str, dict[str, bool]] = {
    "together": {"monitors": False},
    "monitored": {"monitors": True},
    "separate": {"monitors": False, "separate_controllers": True},
}


@dataclass
class Stopwatch:
    """Adds up wall time and CPU time [s]."""

    wall: float = 0.0
    cpu: float = 0.0

    @contextmanager
    def running(self) -> Iterator[None]:
        wall, cpu = time.perf_counter(), time.process_time()
        yield
        self.wall, self.cpu = self.wall + time.perf_counter() - wall, self.cpu + time.process_time() - cpu


class ConstantTorques:
    """The plant of a mission alone, with its torques held."""

    def __init__(self, scenario: Scenario, mission: MissionDiagram):
        builder = DiagramBuilder()
        sampled = mission.transport_plant.plant.has_sampled_output_ports()
        self._parts = AddTransportPlant(builder, scenario, mission.models, sampled_outputs=sampled, visible=False)
        self._plant, self._mission = self._parts.plant, mission
        self._torque = builder.AddSystem(ConstantVectorSource(np.zeros(self._plant.num_actuators())))
        builder.Connect(self._torque.get_output_port(), self._plant.get_actuation_input_port())
        self._support = builder.AddSystem(ConstantVectorSource(np.zeros(self._plant.num_velocities())))
        builder.Connect(self._support.get_output_port(), self._plant.get_applied_generalized_force_input_port())
        diagram = builder.Build()
        with without_half_space_warning():
            self._simulator = Simulator(diagram, diagram.CreateDefaultContext())
        self.watch, self.steps = Stopwatch(), 0

    def advance(self, root) -> None:
        """A piece from where the mission is, in its root Context."""
        theirs, plant = self._mission.transport_plant, self._plant
        source = theirs.plant.GetMyContextFromRoot(root)
        context = self._simulator.get_mutable_context()
        context.SetTime(0.0)
        mine = plant.GetMyMutableContextFromRoot(context)
        plant.SetPositionsAndVelocities(mine, theirs.plant.GetPositionsAndVelocities(source))
        for ours, other in zip(self._parts.weld_ids, theirs.weld_ids, strict=True):
            plant.SetConstraintActiveStatus(mine, ours, theirs.plant.GetConstraintActiveStatus(source, other))
        for ours, port in (
            (self._torque, theirs.plant.get_actuation_input_port()),
            (self._support, theirs.plant.get_applied_generalized_force_input_port()),
        ):
            ours.get_mutable_source_value(ours.GetMyMutableContextFromRoot(context)).SetFromVector(port.Eval(source))
        self._rest(context)
        self._simulator.Initialize()
        with self.watch.running():
            self._simulator.AdvanceTo(PIECE * plant.time_step())
        self.steps += PIECE

    def _rest(self, root) -> None:
        """Objects that are borne do not touch the floor."""
        support = self._support.get_output_port().Eval(self._support.GetMyContextFromRoot(root))
        for name, instance in self._parts.objects.items():
            borne = self._plant.GetVelocitiesFromArray(instance, support).any()
            self._parts.SetFloorContact(root, name, touches=not borne)


def measure_mission(scenario: Scenario, **options: bool) -> dict[str, Any]:
    """Of a whole run, with one round of its suffix; `options` are those of MakeMissionDiagram."""
    models = measure(scenario)
    mission = plan_and_place(scenario, models)
    steps = num_steps(mission, 1)
    diagram = MakeMissionDiagram(mission, scenario, models, num_steps=steps, **options)
    simulator = Simulator(diagram.diagram, diagram.CreateStartContext())
    plant, between, reading = ConstantTorques(scenario, diagram), Stopwatch(), Stopwatch()

    def report(_) -> None:
        with between.running():
            plant.advance(simulator.get_context())

    run = RunMission(diagram, num_steps=steps, report=report, simulator=simulator)
    with reading.running():
        read_logs(diagram, simulator.get_context(), steps, run.recording.reason)
    simulated, samples = float(run.recording.time[-1]), len(run.recording.time) - 1
    wall, cpu = run.wall_seconds - between.wall, run.cpu_seconds - between.cpu
    verdict = verify(run.recording)
    return {
        "satisfied": verdict.satisfied,
        "max_lyapunov_increase": verdict.max_lyapunov_increase,
        "simulated_s": simulated,
        "steps": samples,
        "mission_us": 1e6 * cpu / samples,
        "mission_wall_us": 1e6 * wall / samples,
        "plant_us": 1e6 * plant.watch.cpu / plant.steps,
        "plant_wall_us": 1e6 * plant.watch.wall / plant.steps,
        "reading_us": 1e6 * reading.cpu / samples,
        "ratio": cpu / samples / (plant.watch.cpu / plant.steps),
        "realtime_factor": simulated / wall,
        "cpu_realtime_factor": simulated / cpu,
        "megabytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
    }


class _Empty(LeafSystem):
    """The least that a controller in Python does: reads a state, writes torques."""

    def __init__(self, size: int):
        super().__init__()
        self._input = self.DeclareVectorInputPort("state", size)
        self._zeros = np.zeros(size)
        self.output = self.DeclareVectorOutputPort("torque", size, self._calc, {self._input.ticket()})

    def _calc(self, context, output) -> None:
        self._input.Eval(context)
        output.SetFromVector(self._zeros)


def callback_cost(calls: int = 20000) -> float:
    """Of such a callback [us], which no controller in Python can be below."""
    system = _Empty(24)
    context = system.CreateDefaultContext()
    system.get_input_port(0).FixValue(context, np.zeros(24))
    context.DisableCaching()
    return 1e6 * min(timeit.repeat(lambda: system.output.Eval(context), number=calls // 20, repeat=20)) / (calls // 20)


# What is shown


def show(results: dict[str, Any]) -> None:
    """The table, on the terminal."""
    load, cores = results["load"][0], results["machine"]["cores"]
    title = f"Simulation (load average {load:.1f} on {cores} cores; CPU time per step, logs on)"
    table = Table(title=title)
    for heading in ("mission", "simulated", "mission", "plant alone", "ratio", "real-time factor", "wanted"):
        table.add_column(heading)
    for name, run in results.items():
        if not isinstance(run, dict) or name == "machine":
            continue
        if "failed" in run:
            table.add_row(name, "", run["failed"], "", "", "", "")
            continue
        factor = f"{run['realtime_factor']:.1f} (by CPU time {run['cpu_realtime_factor']:.1f})"
        table.add_row(
            f"{name}{'' if run['satisfied'] else ': NOT SATISFIED'}",
            f"{run['simulated_s']:.1f} s",
            f"{run['mission_us']:.0f} us (+ {run['reading_us']:.0f} to read)",
            f"{run['plant_us']:.0f} us",
            f"{run['ratio']:.2f} x",
            factor,
            WANTED.get(name, ""),
        )
    Console().print(table)
    print(f"an empty callback in Python: {results['callback_us']:.1f} us")


if __name__ == "__main__":
    main()
