"""Redundant agents in the transport controller: (10b) and the torque of their springs."""

from __future__ import annotations

import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd, ExtractValue

from drake_ltl.multibody import AgentModel
from drake_ltl.multibody.object_model import ObjectModel
from drake_ltl.multibody.postures import grasp_configurations
from drake_ltl.scenario.model import Agent, TransportObject
from drake_ltl.systems.posture_springs import PostureSprings, posture_spring
from drake_ltl.systems.transport_controller import TransportController

GRADIENT, V_WO = np.array([0.5, -0.4, 0.3, 9.0, -7.0, 2.0]), np.array([0.1, 0.0, 0.2, 0.5, 0.3, 0.0])
DAMPING = np.array([4.0, 4.0, 4.0, 24.0, 24.0, 24.0])
SHARES = np.array([0.4, 0.6])


@pytest.fixture(scope="module")
def crate() -> ObjectModel:
    return ObjectModel(TransportObject("o1", "package://drake_ltl_models/objects/crate.sdf", (0.0, 0.0), 1.0))


@pytest.fixture(scope="module")
def team() -> dict[str, AgentModel]:
    """A planar arm and a mobile manipulator."""
    names = {"a1": "planar_arm", "a2": "mobile_manipulator"}
    return {
        agent: AgentModel(Agent(agent, f"package://drake_ltl_models/agents/{name}.urdf", (0.0, 0.0), 2.0 * i, 1.0))
        for i, (agent, name) in enumerate(names.items())
    }


@pytest.fixture(scope="module")
def grasps(team, crate) -> dict[str, np.ndarray]:
    return {name: grasp_configurations(model, crate.X_OG, crate.height)[0].q for name, model in team.items()}


@pytest.fixture(scope="module")
def controller(team, crate) -> TransportController:
    return TransportController(crate, team, DAMPING)


def torque(controller, crate, x: dict[str, np.ndarray], anchor: np.ndarray, shares=SHARES) -> dict[str, np.ndarray]:
    context = controller.CreateDefaultContext()
    pose = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, crate.height]
    controller.get_object_state_input_port().FixValue(context, np.concatenate([pose, V_WO]))
    controller.get_gradient_input_port().FixValue(context, GRADIENT)
    controller.get_shares_input_port().FixValue(context, shares)
    controller.get_anchor_input_port("a2").FixValue(context, anchor)
    for name, state in x.items():
        controller.get_agent_state_input_port(name).FixValue(context, state)
    return {name: controller.get_torque_output_port(name).Eval(context) for name in x}


def at_rest(grasps) -> dict[str, np.ndarray]:
    return {name: np.concatenate([q, np.zeros(len(q))]) for name, q in grasps.items()}


def test_only_redundant_agents_have_an_anchor(controller):
    names = {controller.get_input_port(i).get_name() for i in range(controller.num_input_ports())}
    assert {name for name in names if name.startswith("anchor")} == {"anchor_a2"}


def test_the_spring_adds_to_the_law(controller, crate, team, grasps):
    x = at_rest(grasps)
    x["a2"][9:] = np.linspace(-0.3, 0.3, 9)
    anchor = grasps["a2"] + np.linspace(0.1, -0.1, 9)
    q, qd = x["a2"][:9], x["a2"][9:]
    tau_0 = posture_spring(team["a2"], anchor).torque(q, qd, team["a2"].grasp_jacobian(q))
    assert np.abs(tau_0).max() > 1.0
    calm = at_rest(grasps)
    law = torque(controller, crate, calm, grasps["a2"])
    both = torque(controller, crate, x, anchor)
    np.testing.assert_allclose(both["a2"], law["a2"] + tau_0, atol=1e-9)
    np.testing.assert_array_equal(both["a1"], law["a1"])


def test_who_does_not_carry_has_no_spring(controller, crate, team, grasps):
    x = at_rest(grasps)
    idle = torque(controller, crate, x, grasps["a2"] + 0.2, shares=np.array([1.0, 0.0]))["a2"]
    np.testing.assert_allclose(idle, team["a2"].gravity(grasps["a2"]), atol=1e-9)


def test_autodiff_has_the_same_values(controller, crate, grasps):
    x = at_rest(grasps)
    x["a2"][9:] = 0.2
    anchor = grasps["a2"] + 0.05
    twin = controller.ToAutoDiffXd()
    context = twin.CreateDefaultContext()
    pose = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, crate.height]

    def scalars(values):
        return np.array([AutoDiffXd(float(value)) for value in values])

    twin.get_object_state_input_port().FixValue(context, scalars([*pose, *V_WO]))
    twin.get_gradient_input_port().FixValue(context, scalars(GRADIENT))
    twin.get_shares_input_port().FixValue(context, scalars(SHARES))
    twin.get_anchor_input_port("a2").FixValue(context, scalars(anchor))
    for name, state in x.items():
        twin.get_agent_state_input_port(name).FixValue(context, scalars(state))
    tau = ExtractValue(twin.get_torque_output_port("a2").Eval(context)).ravel()
    np.testing.assert_allclose(tau, torque(controller, crate, x, anchor)["a2"], rtol=1e-9, atol=1e-9)


def test_springs_are_made_once_for_an_interval(team, grasps):
    springs = PostureSprings(team)
    first = springs.of("a2", grasps["a2"])
    assert springs.of("a2", grasps["a2"].copy()) is first
    assert springs.of("a2", grasps["a2"] + 0.1) is not first
