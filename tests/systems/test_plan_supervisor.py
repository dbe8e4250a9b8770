"""The supervisor as a LeafSystem: discrete state, ports, events."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.systems.analysis import Simulator, SimulatorStatus
from pydrake.systems.framework import InputPortIndex

from drake_ltl.systems.legs import ALL, Leg
from drake_ltl.systems.plan_supervisor import PlanSupervisor
from drake_ltl.systems.progress import AgentSignals, Progress
from drake_ltl.systems.progress_vector import MOST_WAY_POINTS
from drake_ltl.systems.signals import NO_GRASP, Mode, Phase, pack_step, unpack_step
from drake_ltl.systems.supervision import Supervision

PERIOD = 0.02


@pytest.fixture
def supervisor(program, case_ii, models, places) -> PlanSupervisor:
    return PlanSupervisor(places, Supervision(program, case_ii, models, num_steps=2), models, PERIOD)


@pytest.fixture
def world(mission, world_at):
    return world_at(mission.steps[0].before)


def show(supervisor, context, world) -> None:
    supervisor.get_state_input_port().FixValue(context, world.whole_state(supervisor.places))


@pytest.fixture
def simulator(supervisor, world) -> Simulator:
    """The supervisor alone; bodies stand where they are put."""
    simulator = Simulator(supervisor)
    show(supervisor, simulator.get_mutable_context(), world)
    return simulator


def test_ports_are_named(supervisor, models):
    agents, objects = tuple(models.agents), tuple(models.objects)
    assert [supervisor.get_input_port(i).get_name() for i in range(supervisor.num_input_ports())] == ["state"]
    assert supervisor.get_state_input_port() is supervisor.get_input_port(0)
    outputs = {supervisor.get_output_port(i).get_name() for i in range(supervisor.num_output_ports())}
    of_agents = {f"{kind}_{name}" for kind in ("mode", "hold", "reach", "anchor") for name in agents}
    of_all = {"step", "anchor", "status", "record", "progress"}
    assert outputs == of_agents | of_all | {f"shares_{name}" for name in objects}
    for port, name in (
        (supervisor.get_mode_output_port("a2"), "mode_a2"),
        (supervisor.get_hold_output_port("a2"), "hold_a2"),
        (supervisor.get_reach_output_port("a2"), "reach_a2"),
        (supervisor.get_shares_output_port("o1"), "shares_o1"),
        (supervisor.get_step_output_port(), "step"),
        (supervisor.get_anchor_output_port(), "anchor"),
        (supervisor.get_status_output_port(), "status"),
        (supervisor.get_record_output_port(), "record"),
        (supervisor.get_progress_output_port(), "progress"),
    ):
        assert port.get_name() == name


def test_no_output_waits_for_an_input_of_the_same_instant(supervisor):
    assert not supervisor.HasAnyDirectFeedthrough()


def test_initialization_begins_the_mission(supervisor, simulator, world):
    status = simulator.Initialize()
    context = simulator.get_context()
    assert status.reason() == SimulatorStatus.ReturnReason.kReachedBoundaryTime
    progress = supervisor.GetProgress(context)
    assert (progress.count, progress.phase, progress.revision) == (0, Phase.NAVIGATE, 0)
    modes = {name: supervisor.get_mode_output_port(name).Eval(context) for name in world.q}
    assert modes == {
        "a1": InputPortIndex(1 + Mode.HOLD),
        "a2": InputPortIndex(1 + Mode.TRANSITION),
        "a3": InputPortIndex(1 + Mode.TRANSITION),
    }
    assert all(isinstance(mode, InputPortIndex) for mode in modes.values())  # what a PortSwitch asks for
    np.testing.assert_array_equal(supervisor.get_hold_output_port("a1").Eval(context), world.q["a1"])
    np.testing.assert_array_equal(supervisor.get_anchor_output_port().Eval(context), world.anchor)
    assert unpack_step(supervisor.get_step_output_port().Eval(context)) == (0, Phase.NAVIGATE, Leg())
    np.testing.assert_array_equal(supervisor.get_shares_output_port("o1").Eval(context), np.zeros(3))
    np.testing.assert_array_equal(
        supervisor.get_status_output_port().Eval(context),
        [0, 0, Mode.HOLD, Mode.TRANSITION, Mode.TRANSITION, NO_GRASP, NO_GRASP, NO_GRASP],
    )


def test_it_looks_once_a_period(supervisor, simulator, world, program):
    simulator.Initialize()
    context = simulator.get_mutable_context()
    for task in program.steps[0].travels:
        world.q[task.agent] = task.q_goal
    simulator.AdvanceTo(0.5 * PERIOD)
    show(supervisor, context, world)
    simulator.AdvanceTo(0.9 * PERIOD)
    assert supervisor.GetProgress(context).count == 0
    simulator.AdvanceTo(1.1 * PERIOD)
    assert supervisor.GetProgress(context).count == 1
    np.testing.assert_array_equal(supervisor.get_anchor_output_port().Eval(context), world.anchor)
    assert [text.split()[0] for text in supervisor.waiting_for(context)] == ["a1", "a2", "a3"]  # their drives


class Puppet:
    """In place of Supervision: says what it is told."""

    def __init__(self, *says: Progress):
        self.says = list(says)
        self.program = SimpleNamespace(index=lambda count: count)
        self.applied: list[int] = []

    def begin(self, now) -> Progress:
        return self.says.pop(0)

    def advance(self, state, applied, now) -> Progress:
        self.applied.append(applied)
        return self.says.pop(0) if self.says else state

    def shares(self, state, obj) -> np.ndarray:
        return np.array([0.25, 0.0, 0.75]) if obj == "o2" else np.zeros(3)


def some_progress(**changes) -> Progress:
    """Everybody holds at zero, but for the changes."""
    rest = tuple(AgentSignals(Mode.HOLD, np.zeros(4), np.zeros(10)) for _ in range(3))
    return replace(Progress(0, Phase.NAVIGATE, 0.0, 0, np.zeros(18), rest), **changes)


def with_puppet(places, models, world, *says: Progress):
    puppet = Puppet(*says)
    supervisor = PlanSupervisor(places, puppet, models, PERIOD)
    simulator = Simulator(supervisor)
    show(supervisor, simulator.get_mutable_context(), world)
    return puppet, supervisor, simulator


counts = st.integers(0, 10**6)
numbers = st.floats(-1e6, 1e6)


def vectors(n: int):
    return arrays(float, n, elements=numbers)


signals = st.builds(AgentSignals, st.integers(0, 5), vectors(4), vectors(10), st.integers(-1, 30))
progresses = st.builds(
    Progress,
    count=counts,
    phase=st.sampled_from(Phase),
    step_start=numbers,
    revision=counts,
    anchor=vectors(18),
    agents=st.tuples(signals, signals, signals),
    interval=counts,
    active=st.integers(ALL, 9),
    way=st.lists(st.tuples(numbers, numbers), max_size=MOST_WAY_POINTS).map(tuple),
    slow_since=numbers | st.just(np.inf),
)


@pytest.fixture(scope="module")
def packer(models, places):
    """One supervisor for many contexts, and what it is told to say."""
    puppet = Puppet()
    return puppet, PlanSupervisor(places, puppet, models, PERIOD)


@given(progress=progresses)
def test_progress_passes_through_discrete_state(packer, mission, world_at, progress):
    puppet, supervisor = packer
    puppet.says = [progress]
    context = supervisor.CreateDefaultContext()
    show(supervisor, context, world_at(mission.steps[0].before))
    supervisor.ExecuteInitializationEvents(context)
    stored = supervisor.GetProgress(context)
    for name in ("count", "phase", "step_start", "revision", "interval", "active", "way", "slow_since", "leg"):
        assert getattr(stored, name) == getattr(progress, name), name
    np.testing.assert_array_equal(stored.anchor, progress.anchor)
    for found, told in zip(stored.agents, progress.agents, strict=True):
        assert (found.mode, found.grasp) == (told.mode, told.grasp)
        np.testing.assert_array_equal(found.hold, told.hold)
        np.testing.assert_array_equal(found.reach, told.reach)
    for agent, told in zip(world_at(mission.steps[0].before).q, progress.agents, strict=True):
        assert supervisor.get_mode_output_port(agent).Eval(context) == InputPortIndex(1 + told.mode)
        np.testing.assert_array_equal(supervisor.get_reach_output_port(agent).Eval(context), told.reach)
    assert supervisor.commanded_grasps(context) == [told.grasp for told in progress.agents]
    step = pack_step(progress.count, progress.phase, progress.interval, progress.leg)
    np.testing.assert_array_equal(supervisor.get_step_output_port().Eval(context), step)


def test_a_long_way_is_cut(places, models, world):
    way = tuple((float(k), -float(k)) for k in range(MOST_WAY_POINTS + 5))
    _, supervisor, simulator = with_puppet(places, models, world, some_progress(way=way, active=1))
    simulator.Initialize()
    assert supervisor.GetProgress(simulator.get_context()).way == way[:MOST_WAY_POINTS]


def test_shares_are_handed_on(places, models, world):
    _, supervisor, simulator = with_puppet(places, models, world, some_progress())
    simulator.Initialize()
    context = simulator.get_context()
    np.testing.assert_array_equal(supervisor.get_shares_output_port("o2").Eval(context), [0.25, 0.0, 0.75])
    np.testing.assert_array_equal(supervisor.get_shares_output_port("o1").Eval(context), np.zeros(3))


def test_commanded_grasps_end_the_advance_until_they_are_acknowledged(places, models, world):
    commanded = some_progress(revision=1)
    puppet, supervisor, simulator = with_puppet(places, models, world, some_progress(), some_progress(), commanded)
    simulator.Initialize()
    context = simulator.get_mutable_context()
    status = simulator.AdvanceTo(1.0)
    assert status.reason() == SimulatorStatus.ReturnReason.kReachedTerminationCondition
    assert status.system() is supervisor
    assert context.get_time() == 2 * PERIOD  # one look after it was told
    assert supervisor.grasps_pending(context)
    supervisor.acknowledge(context)
    assert not supervisor.grasps_pending(context)
    assert simulator.AdvanceTo(1.0).reason() == SimulatorStatus.ReturnReason.kReachedBoundaryTime
    assert set(puppet.applied[:2]) == {0}
    assert set(puppet.applied[2:]) == {1}


def test_grasps_commanded_at_the_start_end_the_initialization(places, models, world):
    _, supervisor, simulator = with_puppet(places, models, world, some_progress(revision=1))
    status = simulator.Initialize()
    assert status.reason() == SimulatorStatus.ReturnReason.kReachedTerminationCondition
    assert status.system() is supervisor


def test_a_mission_that_is_done_ends_the_advance(places, models, world):
    _, _, simulator = with_puppet(places, models, world, some_progress(), some_progress(phase=Phase.DONE, count=2))
    simulator.Initialize()
    status = simulator.AdvanceTo(1.0)
    assert status.reason() == SimulatorStatus.ReturnReason.kReachedTerminationCondition
    assert "done" in status.message()


def test_contexts_are_independent(supervisor, world, program):
    """Two missions by one system: what happens in one is not seen in the other."""
    contexts = [supervisor.CreateDefaultContext() for _ in range(2)]
    for context in contexts:
        show(supervisor, context, world)
        supervisor.ExecuteInitializationEvents(context)
    for task in program.steps[0].travels:
        world.q[task.agent] = task.q_goal
    show(supervisor, contexts[0], world)
    Simulator(supervisor, contexts[0]).AdvanceTo(0.5 * PERIOD)
    assert supervisor.GetProgress(contexts[0]).count == 1
    assert supervisor.GetProgress(contexts[1]).count == 0
