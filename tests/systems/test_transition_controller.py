"""The transition controller is eq. (10a)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from drake_ltl.systems.transition_controller import TransitionController

DAMPING = np.array([18.0, 17.0, 3.0, 2.0])
SLOW = st.floats(-0.5, 0.5)


@pytest.fixture(scope="module")
def controller(models) -> TransitionController:
    return TransitionController(models.agents["a2"], DAMPING, speed_limit=2.0)


@pytest.fixture(scope="module")
def plant(arm_plant, models):
    return arm_plant(models.agents["a2"].agent.heading)


@given(q=arrays(float, 4, elements=st.floats(-1.5, 1.5)), qd=arrays(float, 4, elements=SLOW), data=st.data())
def test_torque_is_10a(controller, plant, evaluate, q, qd, data):
    gradient = data.draw(arrays(float, 4, elements=st.floats(-50.0, 50.0)))
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    expected = -plant.CalcGravityGeneralizedForces(context) - gradient - DAMPING * qd
    tau = evaluate(controller, controller.get_torque_output_port(), {"state": [*q, *qd], "gradient": gradient})
    np.testing.assert_allclose(tau, expected, atol=1e-12)  # the same sums in the same order, up to the plants


@pytest.mark.parametrize(("speed", "growth"), [(1.9, 1.0), (2.0, 1.0), (4.0, 4.0), (100.0, 8.0)])
def test_damping_grows_beyond_the_speed_limit(controller, evaluate, speed, growth):
    """Of the base in any direction; with the square of the speed, up to a bound that the time step demands."""
    qd = np.array([0.6 * speed, -0.8 * speed, 0.3, -0.2])
    still = {"state": np.zeros(8), "gradient": np.zeros(4)}
    port = controller.get_torque_output_port()
    tau = evaluate(controller, port, {**still, "state": [0.0, 0.0, 0.0, 0.0, *qd]})
    np.testing.assert_allclose(tau - evaluate(controller, port, still), -growth * DAMPING * qd, rtol=1e-12)


@pytest.mark.parametrize(
    "damping", [np.ones(3), np.ones(5), np.array([1.0, 1.0, 0.0, 1.0]), -np.ones(4), np.full(4, np.nan)]
)
def test_damping_that_is_none_is_refused(models, damping):
    with pytest.raises(ValueError, match="4 positive numbers"):
        TransitionController(models.agents["a1"], damping)


def test_ports_are_named(controller):
    assert controller.GetInputPort("state") is controller.get_state_input_port()
    assert controller.GetInputPort("gradient") is controller.get_gradient_input_port()
    assert controller.GetOutputPort("torque") is controller.get_torque_output_port()
    assert controller.get_name() == "transition_a2"


def test_damping_brings_the_arm_to_rest(models, arm_plant):
    """Without a gradient the law balances gravity and only brakes: the kinetic energy dies away."""
    builder = DiagramBuilder()
    plant = arm_plant(models.agents["a2"].agent.heading, builder, time_step=0.005)
    controller = builder.AddSystem(TransitionController(models.agents["a2"], DAMPING))
    source = builder.AddSystem(ConstantVectorSource(np.zeros(4)))
    builder.Connect(source.get_output_port(), controller.get_gradient_input_port())
    builder.Connect(plant.get_state_output_port(), controller.get_state_input_port())
    builder.Connect(controller.get_torque_output_port(), plant.get_actuation_input_port())
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetPositionsAndVelocities(context, [0.0, 0.0, 0.4, 0.3, 1.0, -1.0, 0.5, 0.5])
    before = plant.CalcKineticEnergy(context)
    simulator.AdvanceTo(2.0)
    assert plant.CalcKineticEnergy(context) < 1e-3 * before  # q1's: exp(-2 K t / B), K = 3, B < 1.4 kg m^2
    assert plant.GetPositions(context)[2] < 1.0  # it has not fallen over
