"""The transport controller is eq. (10b): a team shares one wrench on its object."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from drake_ltl.diagrams.transport_plant import AddTransportPlant
from pydrake.autodiffutils import AutoDiffXd, ExtractGradient, ExtractValue
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from drake_ltl.multibody.postures import solve_grasp
from drake_ltl.systems.transport_controller import TransportController

DAMPING = np.array([4.0, 5.0, 6.0, 24.0, 25.0, 26.0])
MASS, GRAVITY = 0.5, 9.81
ZERO = np.zeros(6)
POWER = {"a1": 2.0, "a2": 4.0, "a3": 3.0}
TEAMS = [team for size in (1, 2, 3) for team in itertools.combinations(POWER, size)]
FAR = {"a1": [10.0, 10.0], "a2": [10.0, -10.0], "a3": [-10.0, 10.0]}


def shares_of(team) -> np.ndarray:
    total = sum(POWER[name] for name in team)
    return np.array([POWER[name] / total if name in team else 0.0 for name in POWER])


def grasping(models, agent: str, obj: str, p_WO) -> np.ndarray:
    """q (n,) with which the agent holds the object at p_WO, upright."""
    (grasp,) = (g for g in models.grasps[agent, obj] if g.name == "plus")
    q = solve_grasp(models.agents[agent], RigidTransform(p_WO) @ grasp.X_OE)
    assert q is not None
    return q


@pytest.fixture(scope="module")
def controller(models) -> TransportController:
    return TransportController(models.objects["o1"], models.agents, DAMPING, speed_limit=2.0)


@pytest.fixture
def torques(controller):
    """torques(q, shares, ...): agent -> torque (n,) in a fresh Context."""

    def evaluate(q: dict, shares, p_WO, gradient=ZERO, V_WO=ZERO) -> dict[str, np.ndarray]:
        context = controller.CreateDefaultContext()
        controller.get_object_state_input_port().FixValue(context, np.concatenate([[1.0, 0, 0, 0], p_WO, V_WO]))
        controller.get_gradient_input_port().FixValue(context, gradient)
        controller.get_shares_input_port().FixValue(context, shares)
        for name, value in q.items():
            controller.get_agent_state_input_port(name).FixValue(context, np.concatenate([value, np.zeros(4)]))
        return {name: controller.get_torque_output_port(name).Eval(context) for name in q}

    return evaluate


@pytest.mark.parametrize("team", TEAMS)
def test_the_team_does_the_work_of_its_wrench(models, arm_plant, torques, team):
    """Virtual work: sum (tau_i - g_i) . qd_i = F . V for every motion the team and its load can make together.

    Planar arms allow translations; what one agent alone carries may also pitch in the plane of its arm.
    """
    rng = np.random.default_rng(len(team))
    p_WO, gradient, V_WO = np.array([2.0, -1.0, 0.4]), rng.normal(size=6), 0.5 * rng.normal(size=6)
    q = {
        name: grasping(models, name, "o1", p_WO) if name in team else np.array([*FAR[name], 0.5, 0.5]) for name in POWER
    }
    tau = torques(q, shares_of(team), p_WO, gradient, V_WO)
    F = np.array([0, 0, 0, 0, 0, MASS * GRAVITY]) - gradient - DAMPING * V_WO
    twists = [np.eye(6)[k] for k in (3, 4, 5)]
    if len(team) == 1:
        psi = models.agents[team[0]].agent.heading
        twists.append(np.array([-np.sin(psi), np.cos(psi), 0.0, 0.0, 0.0, 0.0]))
    for V in twists:
        power = 0.0
        for name in team:
            plant = arm_plant(models.agents[name].agent.heading)
            context = plant.CreateDefaultContext()
            plant.SetPositions(context, q[name])
            qd = admissible(plant, context, p_WO, V)
            power += qd @ (tau[name] + plant.CalcGravityGeneralizedForces(context))
        assert power == pytest.approx(F @ V, abs=1e-4)  # grasps meet their frames to 1e-5 m


def admissible(plant, context, p_WO, V) -> np.ndarray:
    """qd (n,) that moves the gripper as if it were part of the object, whose twist is V (6,) at p_WO."""
    frame, world = plant.GetFrameByName("grasp"), plant.world_frame()
    J = plant.CalcJacobianSpatialVelocity(context, JacobianWrtVariable.kV, frame, np.zeros(3), world, world)
    p_OE = frame.CalcPoseInWorld(context).translation() - p_WO
    V_WE = np.concatenate([V[:3], V[3:] + np.cross(V[:3], p_OE)])
    qd = np.linalg.lstsq(J, V_WE, rcond=None)[0]
    np.testing.assert_allclose(J @ qd, V_WE, atol=1e-6)  # headings in the file have five digits
    return qd


def test_outside_the_team_there_is_gravity_alone(models, arm_plant, torques):
    p_WO = np.array([0.0, 0.0, 0.25])
    q = {"a1": grasping(models, "a1", "o1", p_WO), "a2": np.array([9.0, 0, 0.7, -0.2]), "a3": np.array([0, 9.0, 1, 1])}
    tau = torques(q, shares_of(("a1",)), p_WO, np.full(6, 30.0), np.full(6, 0.3))
    for name in ("a2", "a3"):
        plant = arm_plant(models.agents[name].agent.heading)
        context = plant.CreateDefaultContext()
        plant.SetPositions(context, q[name])
        np.testing.assert_allclose(tau[name], -plant.CalcGravityGeneralizedForces(context), atol=1e-12)


@pytest.mark.parametrize(("speed", "growth"), [(2.0, 1.0), (4.0, 4.0), (100.0, 8.0)])
def test_damping_grows_with_the_speed_of_the_object(models, torques, speed, growth):
    """An agent that carries alone: the force along x, read at its base, is gravity's and the damping's share."""
    p_WO = np.array([0.0, 0.0, 0.25])
    q = {"a1": grasping(models, "a1", "o1", p_WO), "a2": np.zeros(4), "a3": np.zeros(4)}
    V = np.array([0, 0, 0, speed, 0, 0])
    tau = torques(q, shares_of(("a1",)), p_WO, V_WO=V)["a1"]
    assert tau[0] == pytest.approx(-growth * DAMPING[3] * speed)
    assert tau[1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("damping", [np.ones(5), np.array([1.0, 1, 1, 1, 1, 0]), -np.ones(6)])
def test_damping_that_is_none_is_refused(models, damping):
    with pytest.raises(ValueError, match="6 positive numbers"):
        TransportController(models.objects["o1"], models.agents, damping)


@pytest.mark.parametrize("shares", [[0.5, 0.0, 0.4], [1.2, -0.2, 0.0], [np.nan, 0.5, 0.5], [0.5, 0.5, 0.5]])
def test_shares_that_are_none_are_refused(torques, shares):
    with pytest.raises(ValueError, match="of sum 1"):
        torques({"a1": np.zeros(4), "a2": np.zeros(4), "a3": np.zeros(4)}, np.array(shares), np.zeros(3))


def test_torques_carry_derivatives(controller):
    """Of a turn of a1's elbow, a shift of the object and a push of the gradient, against central differences."""
    twin = controller.ToAutoDiffXd()
    inputs = {
        "state_o1": np.array([1.0, 0, 0, 0, 0.1, 0.2, 0.4, 0.1, -0.2, 0.3, 0.5, 0.4, -0.3]),
        "gradient": np.array([0.3, 0.2, -0.4, 3.0, -2.0, 1.0]),
        "shares": shares_of(("a1", "a2")),
        "state_a1": np.array([-1.0, 0.1, 0.9, 0.5, 0.0, 0.1, 0.2, 0.3]),
        "state_a2": np.array([1.0, 0.1, 0.8, 0.6, 0.0, 0.1, 0.2, 0.3]),
        "state_a3": np.zeros(8),
    }
    directions = {name: np.cos(np.arange(len(value))) for name, value in inputs.items()}
    directions["shares"] = np.array([0.1, -0.1, 0.0])

    def torque(system, name, values):
        context = system.CreateDefaultContext()
        for port, value in values.items():
            system.GetInputPort(port).FixValue(context, value)
        return system.GetOutputPort(f"torque_{name}").Eval(context)

    def along(h):
        return {name: value + h * directions[name] for name, value in inputs.items()}

    differentiated = {
        name: np.array([AutoDiffXd(v, np.array([d])) for v, d in zip(value, directions[name], strict=True)])
        for name, value in inputs.items()
    }
    h = 1e-5
    for name in POWER:
        tau = torque(twin, name, differentiated)
        np.testing.assert_allclose(ExtractValue(tau).ravel(), torque(controller, name, inputs), atol=1e-12)
        slope = (torque(controller, name, along(h)) - torque(controller, name, along(-h))) / (2.0 * h)
        np.testing.assert_allclose(ExtractGradient(tau).ravel(), slope, atol=1e-7)  # rounding over h


def test_ports_are_named(controller):
    assert controller.GetInputPort("state_o1") is controller.get_object_state_input_port()
    assert controller.GetInputPort("gradient") is controller.get_gradient_input_port()
    assert controller.GetInputPort("shares") is controller.get_shares_input_port()
    for name in POWER:
        assert controller.GetInputPort(f"state_{name}") is controller.get_agent_state_input_port(name)
        assert controller.GetOutputPort(f"torque_{name}") is controller.get_torque_output_port(name)
    assert controller.get_name() == "transport_o1"


class CarryingTeam:
    """Some agents welded to o1, everything else far away; the controller with no potential, in a simulator."""

    def __init__(self, case_ii, models, team, p_WO, gradient=ZERO):
        builder = DiagramBuilder()
        self.parts = AddTransportPlant(builder, case_ii, models)
        self.plant = plant = self.parts.plant
        controller = builder.AddSystem(TransportController(models.objects["o1"], models.agents, DAMPING))
        zero = builder.AddSystem(ConstantVectorSource(gradient))
        builder.Connect(zero.get_output_port(), controller.get_gradient_input_port())
        share = builder.AddSystem(ConstantVectorSource(shares_of(team)))
        builder.Connect(share.get_output_port(), controller.get_shares_input_port())
        state = plant.get_state_output_port(self.parts.objects["o1"])
        builder.Connect(state, controller.get_object_state_input_port())
        for name, instance in self.parts.agents.items():
            builder.Connect(plant.get_state_output_port(instance), controller.get_agent_state_input_port(name))
            builder.Connect(controller.get_torque_output_port(name), plant.get_actuation_input_port(instance))
        self.simulator = Simulator(builder.Build())
        self.context = plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        self.parts.ReleaseAll(self.context)
        for name, instance in self.parts.agents.items():
            q = grasping(models, name, "o1", p_WO) if name in team else np.array([*FAR[name], 0.0, 0.0])
            plant.SetPositions(self.context, instance, q)
        for name, p in {"o1": p_WO, "o2": np.array([-12.0, -12.0, 0.25])}.items():
            plant.SetFreeBodyPose(self.context, self.body(name), RigidTransform(p))
        for weld, weld_id in zip(self.parts.welds, self.parts.weld_ids, strict=True):
            active = weld.agent in team and weld.object == "o1" and weld.option == "plus"
            plant.SetConstraintActiveStatus(self.context, weld_id, active)

    def body(self, name: str):
        (index,) = self.plant.GetBodyIndices(self.parts.objects[name])
        return self.plant.get_body(index)

    @property
    def X_WO(self) -> RigidTransform:
        return self.body("o1").EvalPoseInWorld(self.context)

    def floor_load(self, name: str) -> float:
        """Force of the floor on the object [N]."""
        results = self.plant.get_contact_results_output_port().Eval(self.context)
        pairs = [results.point_pair_contact_info(i) for i in range(results.num_point_pair_contacts())]
        index = self.body(name).index()
        return sum(abs(pair.contact_force()[2]) for pair in pairs if index in (pair.bodyA_index(), pair.bodyB_index()))


@pytest.mark.parametrize("team", [team for team in TEAMS if len(team) > 1])
def test_a_team_holds_its_load_in_the_air(case_ii, models, team):
    p_WO = np.array([1.0, 2.0, 0.35])
    carrying = CarryingTeam(case_ii, models, team, p_WO)
    carrying.simulator.AdvanceTo(1.0)
    # welds are made within 1e-5 m and 1e-4 rad, and give way a little under load
    np.testing.assert_allclose(carrying.X_WO.translation(), p_WO, atol=5e-4)
    np.testing.assert_allclose(RollPitchYaw(carrying.X_WO.rotation()).vector(), 0.0, atol=2e-3)
    assert carrying.floor_load("o1") == 0.0
    assert carrying.floor_load("o2") == pytest.approx(MASS * GRAVITY, rel=1e-3)  # the method sees loads


def test_a_team_takes_the_load_off_the_floor(case_ii, models):
    """The crate stays where it stood, and the floor no longer carries it."""
    p_WO = np.array([0.0, 0.0, 0.25])
    carrying = CarryingTeam(case_ii, models, ("a1", "a3"), p_WO)
    carrying.simulator.AdvanceTo(1.0)
    np.testing.assert_allclose(carrying.X_WO.translation(), p_WO, atol=5e-4)
    assert carrying.floor_load("o1") < 0.05 * MASS * GRAVITY


def test_with_half_its_wrench_the_load_falls(case_ii, models):
    """The test above can fail: a gradient takes away half of what holds the crate."""
    p_WO = np.array([0.0, 0.0, 0.4])
    gradient = np.array([0, 0, 0, 0, 0, 0.5 * MASS * GRAVITY])
    carrying = CarryingTeam(case_ii, models, ("a1", "a3"), p_WO, gradient)
    carrying.simulator.AdvanceTo(1.0)
    assert carrying.X_WO.translation()[2] < 0.39


def test_a_team_follows_the_gradient(case_ii, models):
    """A constant force and damping: the speed tends to force over damping, whatever the masses are."""
    gradient = np.array([0, 0, 0, -12.0, 0, 0])
    carrying = CarryingTeam(case_ii, models, ("a1", "a2"), np.array([0.0, 0.0, 0.3]), gradient)
    carrying.simulator.AdvanceTo(2.0)
    V = carrying.body("o1").EvalSpatialVelocityInWorld(carrying.context)
    np.testing.assert_allclose(V.translational(), [12.0 / DAMPING[3], 0, 0], atol=5e-3)  # exp(-24 / 3.5 * 2) of it left
    np.testing.assert_allclose(V.rotational(), 0.0, atol=5e-3)
