"""What is measured late, and with noise."""

from __future__ import annotations

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from drake_ltl.systems.sensors import Sensors
from drake_ltl.systems.state_places import StatePlaces

ONE_JOINT = StatePlaces(2, ("a1",), (1,), np.array([0]), np.array([1]), {}, {})
DT = 0.01


def measured(until: float = 0.1, **settings) -> tuple[np.ndarray, np.ndarray]:
    """Times and what is measured of q = t, qd = 1 + t."""
    builder = DiagramBuilder()
    ramp = PiecewisePolynomial.FirstOrderHold([0.0, 10.0], [[0.0, 10.0], [1.0, 11.0]])
    source = builder.AddSystem(TrajectorySource(ramp))
    sensors = builder.AddSystem(Sensors(ONE_JOINT, 1, DT, **settings))
    builder.Connect(source.get_output_port(), sensors.get_state_input_port())
    log = LogVectorOutput(sensors.get_state_output_port(), builder, DT)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(until)
    log = log.FindLog(simulator.get_context())
    return log.sample_times(), log.data()


def test_without_settings_it_is_what_is_there():
    time, x = measured()
    np.testing.assert_allclose(x, [time, 1.0 + time], atol=1e-12)


def test_it_is_as_old_as_the_delay():
    time, x = measured(delay=0.03)
    np.testing.assert_allclose(x[0], np.maximum(time - 0.03, 0.0), atol=1e-12)  # nothing moved before the begin


def test_noise_has_its_deviation_and_depends_on_time_and_seed_alone():
    time, x = measured(20.0, position_noise=0.1, velocity_noise=0.01, seed=3)
    noise = x - [np.minimum(time, 10.0), 1.0 + np.minimum(time, 10.0)]
    # of 2000 samples the deviation is within 10 per cent but once in 10^9
    np.testing.assert_allclose(noise.std(axis=1), [0.1, 0.01], rtol=0.1)
    _, again = measured(1.0, position_noise=0.1, velocity_noise=0.01, seed=3)
    np.testing.assert_array_equal(again, x[:, : again.shape[1]])
    _, other = measured(1.0, position_noise=0.1, velocity_noise=0.01, seed=4)
    assert not np.allclose(other, again)


def test_stamps_say_how_old_a_sample_is():
    """The delay is a whole number of samples."""
    for delay, age in ((0.0, 0.0), (0.03, 0.03), (0.034, 0.03)):
        sensors = Sensors(ONE_JOINT, 1, DT, delay=delay)
        assert sensors.get_age_output_port().Eval(sensors.CreateDefaultContext()) == pytest.approx(age)
