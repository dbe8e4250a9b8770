"""Each monitor at Context level: quiet where all is well, and with the right words where something is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from drake_ltl.diagrams import monitors
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw

from drake_ltl.errors import SearchLimitError
from drake_ltl.monitoring.prefixes import Standing
from drake_ltl.systems.monitors.control_monitors import LyapunovMonitor, TorqueMonitor
from drake_ltl.systems.signals import Phase

STEPS = range(9)
"""Of case ii: every kind of action is among them."""


@pytest.fixture(scope="module")
def carried(program) -> int:
    """Number of the first step in which somebody carries."""
    return next(number for number, step in enumerate(program.steps) if step.transports)


@pytest.mark.parametrize("number", STEPS)
def test_where_all_is_well_nothing_is_seen(stage, begin, number):
    world, progress = begin(number)
    stage.put(world)
    stage.tell(progress)
    assert {name: stage.look(name) for name in stage.diagram.monitors} == {name: [] for name in stage.diagram.monitors}


def test_clearance(stage, begin):
    world, progress = begin(0)
    world.q["a1"] = world.q["a1"].copy()
    world.q["a1"][:2] += world.X_WO["o2"].translation()[:2] - world.q["a1"][:2]  # into the crate
    stage.put(world)
    stage.tell(progress)
    stage.root.SetTime(1.25)
    (seen,) = stage.found("clearance")
    assert seen.who == ("a1", "o2")
    assert seen.value < -0.5
    assert str(seen).startswith("step 1, 1.250 s: a1 and o2 overlap: -")
    assert stage.found("clearance") == ()  # told once


def test_geometry(stage, begin, models):
    """Two robots in one place, and one in a crate that it holds."""
    world, progress = begin(0)
    world.q["a2"] = world.q["a1"] + 0.05
    stage.put(world)
    stage.tell(progress)
    assert [line.partition(": -")[0] for line in stage.look("geometry")] == ["step 1, 0.000 s: a1 hits a2"]


def test_geometry_is_quiet_about_grippers_at_handles(stage, begin, carried):
    world, progress = begin(carried)
    (task,) = stage.diagram.program.steps[carried].transports[:1]
    world.X_WO[task.object] = world.X_WO[task.object] @ RigidTransform([0.0, 0.0, 0.005])  # handles into fingers
    stage.put(world)
    stage.tell(progress)
    assert stage.look("geometry") == []
    agent = task.team[0]
    world.q[agent] = world.q[agent] + np.array([*(0.6 * _towards(world, agent, task.object)), 0.0, 0.0])
    stage.put(world)
    (seen,) = stage.found("geometry")
    assert set(seen.who) == {agent, task.object}
    assert seen.value < 0.0


def _towards(world, agent: str, obj: str) -> np.ndarray:
    way = world.X_WO[obj].translation()[:2] - world.q[agent][:2]
    return way / np.linalg.norm(way)


def test_forbidden_region(stage, begin, program, case_ii):
    number = next(
        number
        for number, step in enumerate(program.steps)
        if step.travels and step.travels[0].start != step.travels[0].goal
    )
    task = program.steps[number].travels[0]
    other = next(region for region in case_ii.regions if region.name not in (task.start, task.goal))
    world, progress = begin(number)
    world.q[task.agent] = np.array([*other.centre[:2], 0.0, 0.0])
    stage.put(world)
    stage.tell(progress)
    (line,) = stage.look("forbidden_region")
    assert f"{task.agent} touches {other.name} on the way to {task.goal}: -" in line
    assert line.startswith(f"step {number + 1}, ")


def test_workspace(stage, begin, case_ii):
    world, progress = begin(0)
    world.q["a3"] = np.array([case_ii.workspace_radius - 1.0, 0.0, 0.0, 0.0])
    stage.put(world)
    stage.tell(progress)
    (line,) = stage.look("workspace")
    assert "a3 leaves the workspace: -" in line


def test_region_of_who_stays(stage, begin, program):
    world, progress = begin(0)
    moving = {task.agent for task in program.steps[0].travels}
    idle = next(name for name in world.q if name not in moving)
    world.q[idle] = world.q[idle] + np.array([2.5, 0.0, 0.0, 0.0])
    stage.put(world)
    stage.tell(progress)
    (line,) = stage.look("region")
    assert f"{idle} is not in " in line


def test_region_of_who_should_have_arrived(stage, begin, program):
    """A step ends with a traveller where it was."""
    task = program.steps[0].travels[0]
    world, progress = begin(0)
    stage.put(world)
    stage.tell(progress)
    assert stage.look("arrival") == []
    after, progress = begin(1)
    after.q[task.agent] = world.q[task.agent]
    stage.put(after)
    stage.tell(replace(progress, anchor=after.anchor))
    lines = stage.look("arrival")
    assert any(f"step 2, 0.000 s: {task.agent} has not come to {task.goal}: -" in line for line in lines)


def test_weld(stage, begin, carried):
    """The object slips out of the hands of its team, or turns in them."""
    world, progress = begin(carried)
    task = stage.diagram.program.steps[carried].transports[0]
    X_WO = world.X_WO[task.object]
    stage.tell(progress)
    for slip, unit in ((RigidTransform([0.002, 0.0, 0.0]), None), (RigidTransform([0.004, 0.0, 0.0]), "m")):
        world.X_WO[task.object] = X_WO @ slip
        stage.put(world)
        found = stage.found("weld")
        assert {seen.who for seen in found} == ({(a, task.object) for a in task.team} if unit else set())
        assert all(seen.unit == unit and seen.value == pytest.approx(0.004, abs=1e-6) for seen in found)
        assert all("gapes" in seen.what for seen in found)
    world.X_WO[task.object] = RigidTransform(RollPitchYaw(0.0, 0.0, 0.02), X_WO.translation())
    stage.put(world)
    turned = [seen for seen in stage.found("weld") if seen.unit == "rad"]
    assert {seen.who for seen in turned} == {(agent, task.object) for agent in task.team}
    assert all(seen.value == pytest.approx(0.02) for seen in turned)  # its heading was 0


class Alone:
    """A monitor of torques and V with signals of one's own."""

    def __init__(self, monitor, progress):
        self.monitor, self.progress = monitor, progress
        self.context = monitor.CreateDefaultContext()
        self.controls = np.zeros(monitor.get_signal_input_port().size())

    def look(self, **changes):
        self.monitor.get_signal_input_port().FixValue(self.context, self.controls)
        progress = Value[object](replace(self.progress, **changes))
        self.monitor.get_progress_input_port().FixValue(self.context, progress)
        return self.monitor.Look(self.context)


@pytest.fixture
def lyapunov(program, begin) -> Alone:
    return Alone(LyapunovMonitor("lyapunov", 0.1, program, 12), begin(0)[1])


def test_lyapunov(lyapunov):
    for V in (10.0, 9.0, 9.000001, 8.0):  # a ten millionth is rounding
        lyapunov.controls[-1] = V
        assert lyapunov.look() == ()
    lyapunov.controls[-1] = 20.0
    assert lyapunov.look(interval=1) == ()  # another function
    lyapunov.controls[-1] = 20.1
    (seen,) = lyapunov.look(interval=1)
    assert seen.value == pytest.approx(0.1 / 20.0)
    assert str(seen) == "step 1, 0.000 s: V rises, relative to its start: 0.005 (limit 1e-06)"


def test_lyapunov_from_nothing(lyapunov):
    """Any rise from 0 is too large; the number that says so can be written down."""
    lyapunov.look()
    lyapunov.controls[-1] = 1e-12
    (seen,) = lyapunov.look()
    assert seen.value == 1e9


def test_torque(program, models, begin):
    """Short bursts are nothing; the third look in a row is."""
    joints = [(name, joint) for name, model in models.agents.items() for joint in model.joint_names]
    limits = np.concatenate([model.effort_limits for model in models.agents.values()])
    torque = Alone(TorqueMonitor("torque", 0.1, program, joints, limits, size=len(limits) + 1), begin(0)[1])
    limit = models.agents["a2"].effort_limits[3]
    row = models.agents["a1"].n + 3
    for asked in (2.0, 2.0, 0.5, -2.0, -2.0):
        torque.controls[row] = asked * limit
        assert torque.look() == ()
    (seen,) = torque.look()
    assert seen.who == ("a2",)
    assert seen.value == pytest.approx(2.0)
    assert f"joint {models.agents['a2'].joint_names[3]} of a2 is asked for more torque" in seen.what


def test_word(stage, begin, case_ii):
    """Of a1's `G !pi3` and o1's `GF pi1 & G(pi1 -> F pi4)`: a1 comes to pi3."""
    world, progress = begin(0)
    stage.put(world)
    stage.tell(progress)
    assert stage.look("word") == []
    monitor = stage.diagram.monitors["word"]
    context = monitor.GetMyContextFromRoot(stage.root)
    assert monitor.standings(context)["a1: G !pi3"] is Standing.UNDECIDED
    assert monitor.standings(context)["1"] is Standing.GOOD  # the global formula
    world.q["a1"] = np.array([*case_ii.region("pi3").centre[:2], 0.0, 0.0])
    stage.put(world)
    assert stage.look("word") == []  # a step goes on: what it passes is no letter
    stage.tell(replace(progress, count=1, anchor=world.anchor))
    assert stage.look("word") == ["step 2, 0.000 s: nothing can satisfy a1's formula any more: G !pi3"]
    assert monitor.standings(context)["a1: G !pi3"] is Standing.BAD
    stage.tell(replace(progress, count=2))
    assert stage.look("word") == []


def test_the_last_letter_is_read_when_all_is_done(stage, begin, case_ii):
    """The supervisor's anchor is then of the begin of the step before."""
    world, progress = begin(0)
    world.q["a1"] = np.array([*case_ii.region("pi3").centre[:2], 0.0, 0.0])
    stage.put(world)
    stage.tell(replace(progress, count=1, phase=Phase.DONE))
    assert len(stage.look("word")) == 1


def test_nothing_depends_on_monitors(stage):
    """They have no outputs, no state and no parameters: they cannot act."""
    for monitor in stage.diagram.monitors.values():
        context = monitor.CreateDefaultContext()
        assert monitor.num_output_ports() == 0
        assert context.is_stateless()
        assert context.num_total_states() == 0
        assert context.num_numeric_parameter_groups() == context.num_abstract_parameters() == 0


def test_formulas_that_are_too_large_are_named(case_ii, monkeypatch):
    """They are not watched, and nobody has to guess which."""

    def prefixes(formula):
        if "->" in formula:
            raise SearchLimitError("its automaton is not made within 5 s")
        return made(formula)

    made = monitors.prefixes
    monkeypatch.setattr(monitors, "prefixes", prefixes)
    watched, unwatched = monitors._watched(case_ii)
    assert unwatched == {"o1: GF pi1 & G(pi1 -> F pi4)": "its automaton is not made within 5 s"}
    assert [item.member for item in watched] == ["a1", "a2", "a3", "o2", ""]
