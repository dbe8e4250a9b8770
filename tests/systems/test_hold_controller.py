"""The hold controller keeps a configuration by computed torque."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from drake_ltl.systems.hold_controller import HoldController

vector4 = arrays(float, 4, elements=st.floats(-1.5, 1.5))


@pytest.fixture(scope="module")
def controller(models) -> HoldController:
    return HoldController(models.agents["a3"], frequency=7.0)


@pytest.fixture(scope="module")
def plant(arm_plant, models):
    return arm_plant(models.agents["a3"].agent.heading)


@given(q=vector4, qd=vector4, hold=vector4)
def test_torque_is_inverse_dynamics_of_a_critical_error(controller, plant, evaluate, q, qd, hold):
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    plant.SetVelocities(context, qd)
    gravity = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, gravity)
    expected = plant.CalcInverseDynamics(context, 49.0 * (hold - q) - 14.0 * qd, gravity)
    tau = evaluate(controller, controller.get_torque_output_port(), {"state": [*q, *qd], "hold": hold})
    np.testing.assert_allclose(tau, expected, atol=1e-9)  # a hundred N, rounded, by another algorithm


def test_ports_are_named(controller):
    assert controller.GetInputPort("state") is controller.get_state_input_port()
    assert controller.GetInputPort("hold") is controller.get_hold_input_port()
    assert controller.GetOutputPort("torque") is controller.get_torque_output_port()
    assert controller.get_name() == "hold_a3"


def test_it_returns_to_where_it_should_stand(models, arm_plant):
    hold, w = np.array([0.1, -0.2, 1.3, 0.2]), 10.0
    builder = DiagramBuilder()
    plant = arm_plant(models.agents["a3"].agent.heading, builder, time_step=0.005)
    controller = builder.AddSystem(HoldController(models.agents["a3"], frequency=w))
    source = builder.AddSystem(ConstantVectorSource(hold))
    builder.Connect(source.get_output_port(), controller.get_hold_input_port())
    builder.Connect(plant.get_state_output_port(), controller.get_state_input_port())
    builder.Connect(controller.get_torque_output_port(), plant.get_actuation_input_port())
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    offset = np.array([0.05, -0.05, 0.1, -0.1])
    plant.SetPositions(context, hold + offset)
    simulator.AdvanceTo(0.5)
    theory = (1.0 + 0.5 * w) * np.exp(-0.5 * w) * offset
    np.testing.assert_allclose(plant.GetPositions(context) - hold, theory, atol=0.002)  # dt w = 5 % of the offset's 4 %
    simulator.AdvanceTo(2.0)
    np.testing.assert_allclose(plant.GetPositions(context), hold, atol=1e-6)
