"""Where the time of a simulated step goes: python benchmarks/step_parts.py

The same pieces of case ii, from the same states with the same welds, by diagrams from which more and more is left out:
the plant under constant torques; torques played back by a controller in Python that does nothing else; with logs; with
the supervisor's looks; with what the laws ask Drake for, which is what would be left if their arithmetic were free;
with the control laws. CPU time, the least of several repetitions that take turns.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from itertools import chain
from pathlib import Path
from unittest.mock import patch

import numpy as np
from drake_ltl.diagrams import MakeMissionDiagram, MissionDiagram, mission_diagram
from pydrake.systems.analysis import InitializeParams, Simulator
from pydrake.systems.framework import Context
from rich.console import Console
from rich.table import Table
from simulation import EXAMPLES, PIECE, ConstantTorques

from drake_ltl.execution.grasping import ApplyGrasps
from drake_ltl.execution.resting import Resting
from drake_ltl.mission import measure, num_steps, plan_and_place
from drake_ltl.scenario import load
from drake_ltl.systems.mission_controller import MissionController
from drake_ltl.systems.plan_supervisor import PlanSupervisor

TIMES = (5.0, 20.0, 45.0, 66.0, 92.0, 112.0, 125.0)
"""Begins of the pieces [s of the mission]; each is less than half a second."""
WHOLE = "with control laws"
NEVER = 1e6
"""Period of a supervisor that does not look [s]."""


def record_and_play(torques: dict[float, np.ndarray]) -> tuple[Callable, Callable, Callable]:
    """In place of MissionController's calculation of torques: one that keeps them by time, one that plays them back,
    and one that asks Drake all that laws do before it plays them back."""
    law = MissionController._calc_torque

    def record(controller, context, output) -> None:
        law(controller, context, output)
        torques[round(context.get_time(), 6)] = output.CopyToVector()

    def play(controller, context, output) -> None:
        output.SetFromVector(torques[round(context.get_time(), 6)])

    def ask_and_play(controller, context, output) -> None:
        x, orders = controller._state.Eval(context), controller._orders.of(controller._progress.Eval(context))
        crew, q, qd = controller._crew, x[controller._q], x[controller._qd]
        crew.set_state(q, qd)
        crew.inverse_dynamics(qd)
        for traveller in orders.travels:
            crew.centre(traveller.agent)
            crew.centre_jacobian(traveller.agent)
        for carrier in chain.from_iterable(carried.carriers for carried in orders.loads):
            crew.grasp_position(carrier.agent)
            crew.grasp_jacobian(carrier.agent)
        play(controller, context, output)

    return record, play, ask_and_play


class NoLog:
    """In place of a log."""

    def __init__(self, *_):
        pass

    def set_name(self, _) -> None:
        pass


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repetitions", type=int, default=12)
    parser.add_argument("--json", type=Path, default=Path("out/benchmark_step_parts.json"))
    args = parser.parse_args()
    scenario = load(EXAMPLES / "case_ii.yaml")
    models = measure(scenario)
    mission = plan_and_place(scenario, models)
    steps = num_steps(mission, 1)

    def make() -> MissionDiagram:
        return MakeMissionDiagram(mission, scenario, models, num_steps=steps, monitors=False)

    diagrams = made(make)
    simulators = {what: Simulator(parts.diagram, parts.CreateStartContext()) for what, parts in diagrams.items()}
    whole = diagrams[WHOLE]
    plant = ConstantTorques(scenario, whole)
    least: dict[str, list[float]] = {}
    for state in states(make(), whole):
        costs: dict[str, list[float]] = {}
        for _ in range(args.repetitions):
            for what, parts in diagrams.items():
                costs.setdefault(what, []).append(run_piece(simulators[what], parts, whole, state))
            plant.watch.cpu, plant.steps = 0.0, 0
            plant.advance(state)
            costs.setdefault("plant under constant torques", []).append(1e6 * plant.watch.cpu / plant.steps)
        for what, found in costs.items():
            least.setdefault(what, []).append(min(found))
    args.json.parent.mkdir(parents=True, exist_ok=True)
    args.json.write_text(json.dumps({"load": os.getloadavg(), "times": TIMES, "us": least}, indent=2) + "\n")
    show(least)


def made(make: Callable[[], MissionDiagram]) -> dict[str, MissionDiagram]:
    """The diagrams, the whole one first: it keeps the torques that others play back."""
    looks, (record, play, ask_and_play) = PlanSupervisor.__init__, record_and_play({})

    def without_looks(supervisor, *args) -> None:
        looks(supervisor, *args[:-1], NEVER)

    no_looks = patch.object(PlanSupervisor, "__init__", without_looks)
    no_logs = patch.object(mission_diagram, "LogVectorOutput", NoLog)
    playing = patch.object(MissionController, "_calc_torque", play)
    asking = patch.object(MissionController, "_calc_torque", ask_and_play)
    kinds = {
        WHOLE: (patch.object(MissionController, "_calc_torque", record),),
        "with what laws ask Drake for": (asking,),
        "with the supervisor's looks": (playing,),
        "with logs": (playing, no_looks),
        "with torques played back": (playing, no_looks, no_logs),
    }
    found = {}
    for what, patches in kinds.items():
        with ExitStack() as stack:
            for one in patches:
                stack.enter_context(one)
            found[what] = make()
    return found


def states(driven: MissionDiagram, like: MissionDiagram) -> Iterator[Context]:
    """Contexts of `like` in the mission's states at TIMES."""
    simulator, dt = Simulator(driven.diagram, driven.CreateStartContext()), driven.transport_plant.plant.time_step()
    context, resting = simulator.get_mutable_context(), Resting(driven)
    own = driven.supervisor.GetMyContextFromRoot(context)
    simulator.Initialize()
    for begin in TIMES:
        while context.get_time() < begin:
            simulator.AdvanceTo(round(min(begin, context.get_time() + 1.0) / dt) * dt)
            if driven.supervisor.grasps_pending(own):
                ApplyGrasps(driven, context)
            resting.look(context)
        copy = like.CreateStartContext()
        put(like, copy, driven, context)
        yield copy


def put(parts: MissionDiagram, root: Context, like: MissionDiagram, source: Context) -> None:
    """Into the same state of plant and supervisor, with the same welds and the same objects at rest."""
    mine, theirs = parts.transport_plant, like.transport_plant
    context, other = mine.plant.GetMyMutableContextFromRoot(root), theirs.plant.GetMyContextFromRoot(source)
    root.SetTime(source.get_time())
    mine.plant.SetPositionsAndVelocities(context, theirs.plant.GetPositionsAndVelocities(other))
    for ours, their in zip(mine.weld_ids, theirs.weld_ids, strict=True):
        mine.plant.SetConstraintActiveStatus(context, ours, theirs.plant.GetConstraintActiveStatus(other, their))
    support = like.support.get_output_port().Eval(like.support.GetMyContextFromRoot(source))
    own_support = parts.support.GetMyMutableContextFromRoot(root)
    parts.support.get_mutable_source_value(own_support).SetFromVector(support)
    for name, instance in mine.objects.items():
        mine.SetFloorContact(root, name, touches=not mine.plant.GetVelocitiesFromArray(instance, support).any())
    supervisor = parts.supervisor.GetMyMutableContextFromRoot(root)
    progress = like.supervisor.GetProgress(like.supervisor.GetMyContextFromRoot(source))
    parts.supervisor.SetProgress(supervisor, progress)
    parts.supervisor.acknowledge(supervisor)


def run_piece(simulator: Simulator, parts: MissionDiagram, like: MissionDiagram, state: Context) -> float:
    """CPU time of a step [us] from a state of `like`."""
    root = simulator.get_mutable_context()
    put(parts, root, like, state)
    for log in parts.logs.values():
        if not isinstance(log, NoLog):
            log.FindMutableLog(root).Clear()
    go_on = InitializeParams()
    go_on.suppress_initialization_events = True
    simulator.Initialize(go_on)
    end = state.get_time() + (PIECE - 0.5) * parts.transport_plant.plant.time_step()
    begin = time.process_time()
    simulator.AdvanceTo(end)
    return 1e6 * (time.process_time() - begin) / PIECE


def show(least: dict[str, list[float]]) -> None:
    """The table, on the terminal."""
    heading = f"A step of case ii (load average {os.getloadavg()[0]:.1f}; CPU time in us)"
    table = Table("", *(f"{begin:g} s" for begin in TIMES), "mean", title=heading)
    for what in reversed([*least]):
        table.add_row(what, *(f"{us:.0f}" for us in least[what]), f"{np.mean(least[what]):.0f}")
    Console(width=120).print(table)


if __name__ == "__main__":
    main()
