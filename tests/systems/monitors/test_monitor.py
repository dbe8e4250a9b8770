"""What all monitors have in common, on one that finds fault with the time."""

from __future__ import annotations

import pytest
from drake_ltl.diagrams.monitors import LONGEST_PERIODS, periods
from pydrake.systems.analysis import Simulator, SimulatorStatus
from pydrake.systems.framework import DiagramBuilder

from drake_ltl.monitoring.violation import Violation
from drake_ltl.systems.monitors import Monitor

STOPPED = SimulatorStatus.ReturnReason.kReachedTerminationCondition
DONE = SimulatorStatus.ReturnReason.kReachedBoundaryTime


class Clock(Monitor):
    """Late from 0.5 s on, in steps of 0.25 s."""

    def __init__(self):
        super().__init__("clock", 0.125)

    def _observe(self, context, memory):
        memory.notes = (memory.notes or 0) + 1
        time = context.get_time()
        if time >= 0.5:
            yield Violation("clock", time, int(time // 0.25), ("a1",), "it is late", time, 0.5, "s")


@pytest.fixture
def simulator():
    builder = DiagramBuilder()
    builder.AddSystem(Clock())
    return Simulator(builder.Build())


def clock(simulator):
    (system,) = simulator.get_system().GetSystems()
    return system


def found(simulator, context=None):
    root = simulator.get_context() if context is None else context
    return clock(simulator).violations(clock(simulator).GetMyContextFromRoot(root))


def test_the_first_violation_ends_the_advance(simulator):
    status = simulator.AdvanceTo(2.0)
    assert status.reason() == STOPPED
    assert status.system() is clock(simulator)
    assert "step 3, 0.500 s: it is late: 0.5 s (limit 0.5 s)" in status.FormatMessage()
    assert simulator.get_context().get_time() == 0.5
    assert [(seen.time, seen.step) for seen in found(simulator)] == [(0.5, 2)]


def test_the_same_thing_is_told_once_in_a_step(simulator):
    """Whoever goes on is stopped when it is a new step."""
    simulator.AdvanceTo(2.0)
    assert simulator.AdvanceTo(0.7).reason() == DONE
    assert simulator.AdvanceTo(2.0).reason() == STOPPED
    assert simulator.get_context().get_time() == 0.75
    assert [seen.step for seen in found(simulator)] == [2, 3]


def test_it_looks_at_the_start_and_every_period(simulator):
    simulator.Initialize()
    context = clock(simulator).GetMyContextFromRoot(simulator.get_context())
    assert clock(simulator)._remembered(context).notes == 1
    simulator.AdvanceTo(0.4)
    assert clock(simulator)._remembered(context).notes == 4


def test_what_was_seen_belongs_to_the_context(simulator):
    simulator.AdvanceTo(2.0)
    clone = simulator.get_context().Clone()
    simulator.AdvanceTo(2.0)
    assert [seen.step for seen in found(simulator, clone)] == [2]
    assert [seen.step for seen in found(simulator)] == [2, 3]


def test_a_run_that_begins_anew_has_seen_nothing(simulator):
    simulator.AdvanceTo(2.0)
    simulator.get_mutable_context().SetTime(0.0)
    simulator.Initialize()
    assert found(simulator) == ()


@pytest.mark.parametrize(
    ("value", "limit", "text"), [(None, None, "x"), (2.0, None, "x: 2 m"), (-0.001, 0.0, "x: -1 mm")]
)
def test_words(value, limit, text):
    seen = str(Violation("m", 1.0, 0, (), "x", value, limit, "m"))
    assert seen.startswith(f"step 1, 1.000 s: {text}")


@pytest.mark.parametrize("time_step", [0.001, 0.002, 0.003, 0.005, 0.02, 0.07, 0.3])
def test_looks_fall_on_steps_of_the_plant_to_the_last_bit(time_step):
    for name, period in periods(time_step).items():
        assert period <= max(LONGEST_PERIODS[name], time_step)
        ratio = round(period / time_step)
        assert all(k * period == k * ratio * time_step for k in range(5000))
