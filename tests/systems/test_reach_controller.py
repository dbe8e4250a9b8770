"""The reach controller follows a quintic in joint space."""

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

from drake_ltl.systems.reach_controller import ReachController
from drake_ltl.systems.signals import pack_reach

vector4 = arrays(float, 4, elements=st.floats(-1.5, 1.5))


@pytest.fixture(scope="module")
def controller(models) -> ReachController:
    return ReachController(models.agents["a1"], frequency=10.0)


@given(q=vector4, qd=vector4, start=vector4, goal=vector4, share=st.floats(0.0, 1.0))
def test_torque_is_inverse_dynamics_along_the_quintic(controller, arm_plant, evaluate, q, qd, start, goal, share):
    duration, begin = 2.0, 5.0
    s = share
    x = start + (goal - start) * (10 * s**3 - 15 * s**4 + 6 * s**5)
    v = (goal - start) * (30 * s**2 - 60 * s**3 + 30 * s**4) / duration
    a = (goal - start) * (60 * s - 180 * s**2 + 120 * s**3) / duration**2
    plant = arm_plant(0.0)
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    plant.SetVelocities(context, qd)
    gravity = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, gravity)
    expected = plant.CalcInverseDynamics(context, a + 20.0 * (v - qd) + 100.0 * (x - q), gravity)
    inputs = {"state": [*q, *qd], "reach": pack_reach(begin, duration, start, goal)}
    tau = evaluate(controller, controller.get_torque_output_port(), inputs, time=begin + share * duration)
    np.testing.assert_allclose(tau, expected, atol=1e-7)  # hundreds of N; the time loses digits on its way


@pytest.mark.parametrize(("time", "end"), [(2.0, 0), (5.0, 0), (6.0, 1), (50.0, 1)])
def test_it_stands_at_both_ends(controller, evaluate, models, time, end):
    """Before its begin and after its end the reference rests, and a body at rest there feels gravity alone."""
    ends = np.zeros(4), np.array([0.3, 0.2, 1.0, 0.5])
    inputs = {"state": [*ends[end], *np.zeros(4)], "reach": pack_reach(5.0, 1.0, *ends)}
    tau = evaluate(controller, controller.get_torque_output_port(), inputs, time=time)
    np.testing.assert_allclose(tau, models.agents["a1"].gravity(ends[end]), atol=1e-9)


def test_ports_are_named(controller):
    assert controller.GetInputPort("state") is controller.get_state_input_port()
    assert controller.GetInputPort("reach") is controller.get_reach_input_port()
    assert controller.GetOutputPort("torque") is controller.get_torque_output_port()
    assert controller.get_name() == "reach_a1"


def test_it_tracks_an_approach(models, arm_plant):
    """A straight approach as missions have it: the gripper ends within the weld's tolerance, at rest."""
    model = models.agents["a2"]
    goal = models.grasps["a2", "o1"][0].q
    start = goal + np.array([-0.2, 0.25, 0.02, -0.02])
    duration = 2.0
    builder = DiagramBuilder()
    plant = arm_plant(model.agent.heading, builder, time_step=0.005)
    controller = builder.AddSystem(ReachController(model))
    source = builder.AddSystem(ConstantVectorSource(pack_reach(0.0, duration, start, goal)))
    builder.Connect(source.get_output_port(), controller.get_reach_input_port())
    builder.Connect(plant.get_state_output_port(), controller.get_state_input_port())
    builder.Connect(controller.get_torque_output_port(), plant.get_actuation_input_port())
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetPositions(context, start)
    middle = (start + goal) / 2
    simulator.AdvanceTo(duration / 2)
    # half a time step behind a peak speed of 0.25 m/s, and what the loop makes of it
    np.testing.assert_allclose(plant.GetPositions(context), middle, atol=2e-3)
    simulator.AdvanceTo(duration)
    gap = plant.GetFrameByName("grasp").CalcPoseInWorld(context).translation() - model.grasp_pose(goal).translation()
    assert np.linalg.norm(gap) < 1e-3
    simulator.AdvanceTo(duration + 0.5)
    np.testing.assert_allclose(plant.GetPositions(context), goal, atol=1e-4)
    np.testing.assert_allclose(plant.GetVelocities(context), 0.0, atol=1e-3)
