"""How a team shares its load, measured at the wrists: `make bench`, or `python benchmarks/load_sharing.py --help`.

Planar arms are welded to a crate and carry it under the control law (10b), simulated as in missions. Read at every
wrist is the wrench f_i on the crate: at rest in the air, at constant velocity, and while a gradient wavers.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from drake_ltl.diagrams.quiet import without_half_space_warning
from drake_ltl.diagrams.transport_plant import AddTransportPlant, TransportPlant
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, Sine
from rich.console import Console
from rich.table import Table

from drake_ltl.dynamics import (
    JointDynamics,
    body_gravity,
    internal_wrenches,
    joint_dynamics,
    load_shares,
    null_space_wrench,
    object_to_agent_jacobian,
    object_to_agent_jacobian_rate,
    task_dynamics,
    team_wrench,
    wrench_at_gripper,
    wrench_on_object,
)
from drake_ltl.multibody import MeasuredModels, MeasureGeometry
from drake_ltl.multibody.parsing import GRASP_FRAME
from drake_ltl.multibody.postures import solve_grasp
from drake_ltl.scenario.model import Agent, Region, Scenario, SimulationSettings, TransportObject
from drake_ltl.systems.transport_controller import TransportController

AGENT = "package://drake_ltl_models/agents/planar_arm.urdf"
CRATE = "package://drake_ltl_models/objects/crate.sdf"
DAMPING = np.array([4.0, 4.0, 4.0, 24.0, 24.0, 24.0])
"""K_O, rotational and translational [N m s, N s/m]: the default of scenarios."""
HEIGHT = 0.6
"""Of the crate's centre [m]: nothing touches the floor."""


@dataclass(frozen=True)
class Motion:
    """What gradient the team follows: push * sin(rate * t + phase), (6,) [N m; N]."""

    name: str
    push: tuple[float, ...]
    rate: tuple[float, ...]
    phase: float
    settled: float
    """From when on it is measured [s]: welds are at rest, and what is to be constant is so."""
    duration: float
    """[s]"""


STILL = (0.0,) * 6
MOTIONS = (
    Motion("at rest", STILL, STILL, 0.0, 0.5, 1.0),
    Motion("cruising", (0.0, 0.0, 0.0, 20.0, 15.0, 0.0), STILL, math.pi / 2.0, 4.0, 5.0),
    Motion("accelerating", (0.0, 0.0, 0.0, 20.0, 15.0, 6.0), (0.0, 0.0, 0.0, 3.0, 4.0, 5.0), 0.0, 0.5, 4.0),
)
SHARES = {  # name -> c, for two agents and for three
    2: {"equal": (0.5, 0.5), "unequal": (0.2, 0.8), "powers 2, 4": tuple(load_shares([2, 4]))},
    3: {
        "equal": tuple(load_shares([1, 1, 1])),
        "unequal": (0.1, 0.3, 0.6),
        "powers 2, 4, 3": tuple(load_shares([2, 4, 3])),
    },
}


@dataclass(frozen=True)
class Sample:
    """One step of a transport: states at its beginning; accelerations and wrenches over it."""

    joint: tuple[JointDynamics, ...]
    qd: tuple[np.ndarray, ...]
    offsets: tuple[np.ndarray, ...]
    """p_OoEo_W of each agent."""
    R_WO: np.ndarray
    V_WO: np.ndarray
    A_WO: np.ndarray
    F_O: np.ndarray
    """What the team shares, commanded (6,)."""
    f: tuple[np.ndarray, ...]
    """What each agent puts on the object, measured at its wrist (6,)."""

    def own(self, i: int) -> np.ndarray:
        """M_i vdot_i + C_i v_i + h_i (6,) of (1b): what agent i needs to move itself."""
        p, joint = self.offsets[i], self.joint[i]
        v = object_to_agent_jacobian(p) @ self.V_WO
        vdot = object_to_agent_jacobian(p) @ self.A_WO + object_to_agent_jacobian_rate(p, self.V_WO[:3]) @ self.V_WO
        dynamics = task_dynamics(joint)
        return dynamics.M @ vdot + dynamics.C @ v + null_space_wrench(joint, self.qd[i])


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    agents: int
    shares: str
    motion: str
    c: tuple[float, ...]
    of_object: tuple[float, ...]
    """Parts of the force that acts on the object, mean."""
    of_team: tuple[float, ...]
    """... of the force that the team commands, with what each agent needs to move itself added, mean."""
    error_percent: float
    """Of the latter, relative to c: the worst of all agents and samples."""
    law_error: float
    """Worst |f_i - (J_O^-T c_i F_O - M_i vdot_i - C_i v_i)|, force [N]."""
    internal_force: float
    """Worst part of an agent's force that does not move the object [N]."""
    speed: float
    """Greatest of the object [m/s]."""


def scenario_of(n_agents: int, time_step: float = 0.005) -> Scenario:
    """Agents spread about a crate by thirds of a turn."""
    agents = tuple(Agent(f"a{k}", AGENT, (0.0, 0.0), 2.0 * math.pi * k / 3.0, 1.0) for k in range(n_agents))
    return Scenario(
        name="load_sharing",
        workspace_radius=30.0,
        regions=(Region("here", (0.0, 0.0, 0.0), 5.0),),
        agents=agents,
        objects=(TransportObject("crate", CRATE, (0.0, 0.0), 1.0),),
        simulation=SimulationSettings(time_step=time_step),
    )


def carry(shares: Sequence[float], motion: Motion, *, every: float = 0.05, dt: float = 0.005) -> list[Sample]:
    """Simulates a transport; one sample per `every` seconds, once it has settled."""
    scenario = scenario_of(len(shares), dt)
    models = MeasureGeometry(scenario)
    diagram, parts, source = _diagram(scenario, models, np.asarray(shares), motion)
    with without_half_space_warning():
        simulator = Simulator(diagram)
        context = parts.plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    _grasp(parts, models, context)
    samples = []
    stride = round(every / dt)
    for k in range(round(motion.settled / dt), round(motion.duration / dt), stride):
        simulator.AdvanceTo(k * dt)  # a whole number of steps, so that the next is exactly one more
        before = _state(parts, models, context)
        gradient = source.get_output_port(0).Eval(source.GetMyContextFromRoot(simulator.get_context()))
        simulator.AdvanceTo((k + 1) * dt)
        samples.append(_sample(parts, models, context, before, gradient, dt))
    return samples


def _diagram(scenario: Scenario, models: MeasuredModels, shares: np.ndarray, motion: Motion):
    builder = DiagramBuilder()
    parts = AddTransportPlant(builder, scenario, models)
    plant = parts.plant
    controller = builder.AddSystem(TransportController(models.objects["crate"], models.agents, DAMPING))
    source = builder.AddSystem(Sine(np.array(motion.push), np.array(motion.rate), np.full(6, motion.phase), True))
    fixed = builder.AddSystem(ConstantVectorSource(shares))
    builder.Connect(source.get_output_port(0), controller.get_gradient_input_port())
    builder.Connect(fixed.get_output_port(), controller.get_shares_input_port())
    builder.Connect(plant.get_state_output_port(parts.objects["crate"]), controller.get_object_state_input_port())
    for name, instance in parts.agents.items():
        builder.Connect(plant.get_state_output_port(instance), controller.get_agent_state_input_port(name))
        builder.Connect(controller.get_torque_output_port(name), plant.get_actuation_input_port(instance))
    return builder.Build(), parts, source


def _grasp(parts: TransportPlant, models: MeasuredModels, context) -> None:
    plant, X_WO = parts.plant, RigidTransform([0.0, 0.0, HEIGHT])
    plant.SetFreeBodyPose(context, _crate(parts, models), X_WO)
    for name, instance in parts.agents.items():
        grasp = models.grasps[name, "crate"][0]
        plant.SetPositions(context, instance, solve_grasp(models.agents[name], X_WO @ grasp.X_OE))
    for weld, weld_id in zip(parts.welds, parts.weld_ids, strict=True):
        active = weld.option == models.grasps[weld.agent, "crate"][0].name
        plant.SetConstraintActiveStatus(context, weld_id, active)


def _crate(parts: TransportPlant, models: MeasuredModels):
    return parts.plant.GetBodyByName(models.objects["crate"].body_name, parts.objects["crate"])


def _state(parts: TransportPlant, models: MeasuredModels, context):
    plant, crate = parts.plant, _crate(parts, models)
    x = {name: plant.GetPositionsAndVelocities(context, instance) for name, instance in parts.agents.items()}
    return x, crate.EvalPoseInWorld(context), crate.EvalSpatialVelocityInWorld(context).get_coeffs()


def _sample(parts: TransportPlant, models: MeasuredModels, context, before, gradient, dt: float) -> Sample:
    (x, X_WO, V_WO), (_, _, V_later) = before, _state(parts, models, context)
    joint, offsets, qd, f = [], [], [], []
    for name, instance in parts.agents.items():
        model = models.agents[name]
        alone = model.plant.CreateDefaultContext()
        model.plant.SetPositionsAndVelocities(alone, x[name])
        joint.append(joint_dynamics(model.plant, alone, model.plant.GetFrameByName(GRASP_FRAME)))
        offsets.append(model.grasp_pose(x[name][: model.n]).translation() - X_WO.translation())
        qd.append(x[name][model.n :])
        f.append(wrench_on_object(parts.plant, context, parts.plant.GetFrameByName(GRASP_FRAME, instance)))
    return Sample(
        joint=tuple(joint),
        qd=tuple(qd),
        offsets=tuple(offsets),
        R_WO=X_WO.rotation().matrix(),
        V_WO=V_WO,
        A_WO=(V_later - V_WO) / dt,
        F_O=team_wrench(body_gravity(models.objects["crate"].mass), gradient, DAMPING, V_WO),
        f=tuple(f),
    )


def evaluate(samples: Sequence[Sample], c: Sequence[float], *, shares: str, motion: str) -> Row:
    """One line of the table from a transport's samples. Forces alone count: an arm of four joints cannot choose what
    torques it puts on the object; structure and welds do."""
    n = len(c)
    of_object, of_team = np.empty((len(samples), n)), np.empty((len(samples), n))
    law, internal = 0.0, 0.0
    for k, sample in enumerate(samples):
        F = sum(f[3:] for f in sample.f)
        commanded = sample.F_O[3:]
        for i in range(n):
            pushed = (sample.f[i] + sample.own(i))[3:]
            of_object[k, i] = sample.f[i][3:] @ F / (F @ F)
            of_team[k, i] = pushed @ commanded / (commanded @ commanded)
            expected = wrench_at_gripper(c[i] * sample.F_O, sample.offsets[i])[3:]
            law = max(law, float(np.linalg.norm(pushed - expected)))
        inner = internal_wrenches(sample.f, sample.offsets, c)[:, 3:]
        internal = max(internal, float(np.linalg.norm(inner, axis=1).max()))
    return Row(
        agents=n,
        shares=shares,
        motion=motion,
        c=tuple(float(x) for x in c),
        of_object=tuple(of_object.mean(axis=0).tolist()),
        of_team=tuple(of_team.mean(axis=0).tolist()),
        error_percent=100.0 * float(np.abs(of_team / np.asarray(c) - 1.0).max()),
        law_error=law,
        internal_force=internal,
        speed=max(float(np.linalg.norm(sample.V_WO[3:])) for sample in samples),
    )


COLUMNS = (
    "agents",
    "shares",
    "motion",
    "c",
    "of force on object",
    "of force commanded",
    "error [%]",
    "error [N]",
    "internal [N]",
    "speed [m/s]",
)


def cells(row: Row) -> tuple[str, ...]:
    """A row as text."""

    def numbers(values: Sequence[float]) -> str:
        return " ".join(f"{value:.3f}" for value in values)

    measured = (f"{row.error_percent:.2g}", f"{row.law_error:.2g}", f"{row.internal_force:.2g}", f"{row.speed:.2f}")
    return (
        str(row.agents),
        row.shares,
        row.motion,
        numbers(row.c),
        numbers(row.of_object),
        numbers(row.of_team),
        *measured,
    )


def markdown(rows: Sequence[Row]) -> str:
    """The table as a document shows it."""
    lines = [COLUMNS, ("---",) * len(COLUMNS), *(cells(row) for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def write_into(document: Path, rows: Sequence[Row]) -> None:
    """Puts the table between the two marks of a document, in place of what is there."""
    before, start, rest = document.read_text(encoding="utf-8").partition(START)
    _, end, after = rest.partition(END)
    if not (start and end):
        raise SystemExit(f"{document}: no lines {START!r} and {END!r}")
    document.write_text(f"{before}{start}\n\n{markdown(rows)}\n\n{end}{after}", encoding="utf-8")


TABLE_WIDTH = 140
"""Characters; in a pipe or a narrow terminal the numbers would be cut off otherwise."""
START = "<!-- measured by: python benchmarks/load_sharing.py --document docs/dynamics.md -->"
END = "<!-- end -->"


def main() -> None:
    parser = argparse.ArgumentParser(description="Measures load sharing; prints a table and writes JSON.")
    parser.add_argument("--json", type=Path, default=Path("out/benchmark_load_sharing.json"))
    parser.add_argument("--document", type=Path, help="put the table into this one as well, between its marks")
    args = parser.parse_args()
    rows = [
        evaluate(carry(c, motion), c, shares=name, motion=motion.name)
        for table in SHARES.values()
        for name, c in table.items()
        for motion in MOTIONS
    ]
    args.json.parent.mkdir(parents=True, exist_ok=True)
    args.json.write_text(json.dumps([asdict(row) for row in rows], indent=2) + "\n")
    if args.document:
        write_into(args.document, rows)
    table = Table(*COLUMNS, title="Load sharing, measured at the wrists")
    for row in rows:
        table.add_row(*cells(row))
    console = Console()
    console.width = max(console.width, TABLE_WIDTH)
    console.print(table)


if __name__ == "__main__":
    main()
