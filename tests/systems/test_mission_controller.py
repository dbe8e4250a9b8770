"""All control laws in one system, against the separate systems: the same torques and the same V."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from drake_ltl.diagrams import MakeMissionDiagram
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.common.value import Value

from drake_ltl.errors import ExecutionError
from drake_ltl.systems.hold_controller import TRACKING_FREQUENCY
from drake_ltl.systems.legs import Leg
from drake_ltl.systems.progress import AgentSignals, Progress
from drake_ltl.systems.signals import Mode, Phase, pack_reach

STEPS = range(9)
"""Of case ii: every kind of action is among them."""


@pytest.fixture(scope="module")
def diagrams(mission, case_ii, models):
    """All laws in one system, and separate ones."""
    return [
        MakeMissionDiagram(mission, case_ii, models, num_steps=9, separate_controllers=separate)
        for separate in (False, True)
    ]


def progress_of(program, models, world, number, phase=Phase.NAVIGATE, leg=None) -> Progress:
    """Everybody does what step `number` asks; approaches and retreats are on their way."""
    step = program.steps[number]
    objects = list(models.objects)
    mode = {task.agent: Mode.TRANSITION for task in step.travels}
    mode |= {name: Mode.TRANSPORT + objects.index(task.object) for task in step.transports for name in task.team}
    mode |= {task.weld.agent: Mode.REACH for task in (*step.grasps, *step.releases)}
    agents = tuple(
        AgentSignals(mode.get(name, Mode.HOLD), q + 0.01, pack_reach(0.0, 2.0, q, q + 0.05))
        for name, q in world.q.items()
    )
    active, way = (leg.active, (leg.via,)) if leg else (-1, ())
    return Progress(number, phase, 0.0, 0, world.anchor, agents, 0, active, way)


def evaluate(diagram, progress, world, time=0.7):
    """Torques of all agents, and V."""
    root = diagram.CreateStartContext()
    root.SetTime(time)
    parts = diagram.transport_plant
    context = parts.plant.GetMyMutableContextFromRoot(root)
    for name, instance in (parts.agents | parts.objects).items():
        parts.plant.SetPositionsAndVelocities(context, instance, world.state(name))
    diagram.supervisor.SetProgress(diagram.supervisor.GetMyMutableContextFromRoot(root), progress)
    monitor = diagram.monitors["lyapunov"]
    controls = monitor.get_signal_input_port().Eval(monitor.GetMyContextFromRoot(root))
    return controls[:-1], controls[-1]


def stirred(world, seed):
    """The same world a little elsewhere, and in motion."""
    rng = np.random.default_rng(seed)
    return replace(
        world,
        q={name: q + rng.normal(scale=0.02, size=len(q)) for name, q in world.q.items()},
        qd={name: rng.normal(size=len(qd)) for name, qd in world.qd.items()},
        V_WO={name: rng.normal(size=6) for name in world.V_WO},
    )


def assert_same(diagrams, progress, world):
    (torque, V), (expected, expected_V) = (evaluate(diagram, progress, world) for diagram in diagrams)
    np.testing.assert_allclose(torque, expected, rtol=1e-9, atol=1e-9)  # rounding: sums in another order
    assert pytest.approx(expected_V, rel=1e-12, abs=1e-12) == V
    return torque, V


@pytest.mark.parametrize("number", STEPS)
def test_the_laws_are_those_of_the_separate_systems(diagrams, program, models, mission, world_at, number):
    world = world_at(mission.steps[number].before)
    _, V = assert_same(diagrams, progress_of(program, models, world, number), stirred(world, number))
    assert bool(V > 0.0) is bool(program.steps[number].travels or program.steps[number].transports)


def test_so_they_are_while_a_lone_mover_goes_by_way_of_a_point(diagrams, program, models, mission, world_at):
    world = world_at(mission.steps[0].before)
    progress = progress_of(program, models, world, 0, leg=Leg(1, (5.0, 5.0)))
    agents = [replace(signals, mode=Mode.HOLD) if i == 1 else signals for i, signals in enumerate(progress.agents)]
    assert_same(diagrams, replace(progress, agents=tuple(agents)), stirred(world, 0))


def test_so_they_are_when_nothing_moves_under_phi(diagrams, program, models, mission, world_at):
    world = world_at(mission.steps[0].before)
    progress = progress_of(program, models, world, 0, phase=Phase.REACH)
    holding = tuple(replace(signals, mode=Mode.HOLD) for signals in progress.agents)
    _, V = assert_same(diagrams, replace(progress, agents=holding), stirred(world, 1))
    assert V == 0.0


@pytest.mark.parametrize("off", [0.0, 0.02], ids=["held", "moved"])
def test_in_safe_mode_who_holds_a_load_bears_what_moves_it_as_the_gripper(
    diagrams, program, models, mission, world_at, off
):
    """What is added to its torques does, on any motion of its joints, the work that the welded load takes: against
    gravity, and for the acceleration that brings the joints back from `off` at once."""
    task = next(task for task in program.steps[2].transports)
    world, name = world_at(mission.steps[2].before), task.team[0]
    index, model, obj = list(models.agents).index(name), models.agents[name], models.objects[task.object]
    weld = next(i for i, w in enumerate(program.welds) if (w.agent, w.object) == (name, task.object))
    state = progress_of(program, models, world, 2, phase=Phase.SAFE)
    agents = [
        replace(told, mode=Mode.HOLD, hold=q + off) for q, told in zip(world.q.values(), state.agents, strict=True)
    ]
    agents[index] = replace(agents[index], grasp=weld)
    free, bearing = (
        evaluate(diagrams[0], replace(state, agents=(*agents[:index], one, *agents[index + 1 :])), world)[0]
        for one in (agents[index], replace(agents[index], bears=1.0))
    )
    rows = slice(start := sum(models.agents[n].n for n in list(models.agents)[:index]), start + model.n)
    added = (bearing - free)[rows]
    assert np.delete(bearing - free, np.r_[rows]) == pytest.approx(0.0, abs=1e-12)
    # the load's origin and turn move with the gripper's frame
    J, p_EoOo = model.grasp_jacobian(world.q[name]), world.X_WO[task.object].translation()
    p_EoOo = p_EoOo - model.grasp_pose(world.q[name]).translation()
    J_O = np.array([np.append(w, v + np.cross(w, p_EoOo)) for w, v in zip(J[:3].T, J[3:].T, strict=True)]).T
    A_O = J_O @ np.full(model.n, TRACKING_FREQUENCY**2 * off)
    inertia = obj.R_lying.matrix() @ obj.I_OOo_O @ obj.R_lying.matrix().T
    force = np.append(inertia @ A_O[:3], obj.mass * (A_O[3:] + np.array([0.0, 0.0, 9.81])))
    np.testing.assert_allclose(added, J_O.T @ force, rtol=1e-9, atol=1e-9)


@settings(max_examples=5)
@given(seed=st.integers(0, 2**32 - 1))
def test_evaluations_leave_no_trace(diagrams, program, models, mission, world_at, seed):
    """Another state and another step in between change nothing."""
    world, other = (world_at(mission.steps[number].before) for number in (0, 2))
    first = evaluate(diagrams[0], progress_of(program, models, world, 0), stirred(world, seed))
    evaluate(diagrams[0], progress_of(program, models, other, 2), stirred(other, seed + 1))
    again = evaluate(diagrams[0], progress_of(program, models, world, 0), stirred(world, seed))
    np.testing.assert_array_equal(again[0], first[0])
    assert again[1] == first[1]


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_state_that_is_not_finite_is_refused(diagrams, program, models, mission, world_at, bad):
    world = world_at(mission.steps[0].before)
    controller = diagrams[0].diagram.GetSubsystemByName("mission_controller")
    plant, parts = diagrams[0].transport_plant.plant, diagrams[0].transport_plant
    x, numbers = np.zeros(plant.num_multibody_states()), np.arange(plant.num_velocities(), dtype=float)
    row = int(plant.GetVelocitiesFromArray(parts.agents["a3"], numbers)[0])
    x[plant.num_positions() + row] = bad
    context = controller.CreateDefaultContext()
    context.SetTime(0.7)
    controller.get_state_input_port().FixValue(context, x)
    progress = Value[object](progress_of(program, models, world, 0))
    controller.get_progress_input_port().FixValue(context, progress)
    with pytest.raises(ExecutionError, match=r"state of a3 is not finite at t = 0\.700 s"):
        controller.get_torque_output_port().Eval(context)
