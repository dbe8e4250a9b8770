"""Two robots carry a crate, in a diagram built by hand: no plan, no supervisor, a potential of one's own.

    python examples/transport_by_hand.py

AddTransportPlant makes the world (robots, crate, floor, a weld for each way to grasp), TransportController shares the
load by (10b). What it follows is the LeafSystem below: any system with an output `gradient` can stand there.
"""

from __future__ import annotations

import sys

import numpy as np
from drake_ltl.diagrams import AddTransportPlant, TransportPlant
from drake_ltl.diagrams.quiet import without_half_space_warning
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, Context, Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource

import drake_ltl
from drake_ltl.dynamics import quaternion_mismatch
from drake_ltl.multibody import MeasuredModels, MeasureGeometry
from drake_ltl.scenario import Scenario
from drake_ltl.systems.transport_controller import TransportController

ROBOTS = {"porter_1": "plus", "porter_2": "plus"}
"""Who carries, and how each grasps (`MeasuredModels.grasps` lists the ways)."""
GOAL = np.array([-6.0, -2.0, 0.35])
"""Of the crate's origin [m]: 0.1 m above where it stands."""
FORCE, REACH = 20.0, 0.5
"""Far from the goal the crate is pulled with this force [N]; within this distance [m] the pull fades."""


class Pull(LeafSystem):
    """Gradient of FORCE (sqrt(d^2 + REACH^2) - REACH), d the distance to the goal, and of 2 (1 - cos) of the tilt.

    .. pydrake_system::

        name: Pull
        input_ports:
        - state
        output_ports:
        - gradient

    `state` is Drake's state (13,) of a free body, `gradient` (6,) (rotational; translational) [N m, N].
    """

    def __init__(self, p_WO_goal: np.ndarray, q_WO_goal: np.ndarray):
        super().__init__()
        self.set_name("pull")
        self._p, self._q = p_WO_goal, q_WO_goal
        self._state = self.DeclareVectorInputPort("state", 13)
        self.DeclareVectorOutputPort("gradient", 6, self._calc_gradient)

    def _calc_gradient(self, context: Context, output: BasicVector) -> None:
        state = self._state.Eval(context)
        error = state[4:7] - self._p
        pull = FORCE * error / np.sqrt(error @ error + REACH**2)
        output.SetFromVector(np.concatenate([FORCE * quaternion_mismatch(state[:4], self._q)[1], pull]))


def build(scenario: Scenario, models: MeasuredModels) -> tuple[Diagram, TransportPlant]:
    """Plant, pull, shares and the controller of (10b), connected."""
    (cart,) = scenario.objects
    builder = DiagramBuilder()
    world = AddTransportPlant(builder, scenario, models)
    plant, gains = world.plant, scenario.controller
    damping = np.repeat([gains.team_rotation_damping, gains.team_damping], 3)
    controller = builder.AddSystem(TransportController(models.objects[cart.name], models.agents, damping))
    pull = builder.AddSystem(Pull(GOAL, np.array([1.0, 0.0, 0.0, 0.0])))
    shares = builder.AddSystem(ConstantVectorSource([0.5, 0.5]))  # c_tau: half each

    state_of_cart = plant.get_state_output_port(world.objects[cart.name])
    builder.Connect(state_of_cart, pull.GetInputPort("state"))
    builder.Connect(state_of_cart, controller.get_object_state_input_port())
    builder.Connect(pull.GetOutputPort("gradient"), controller.get_gradient_input_port())
    builder.Connect(shares.get_output_port(), controller.get_shares_input_port())
    for robot, instance in world.agents.items():
        builder.Connect(plant.get_state_output_port(instance), controller.get_agent_state_input_port(robot))
        builder.Connect(controller.get_torque_output_port(robot), plant.get_actuation_input_port(instance))
    return builder.Build(), world


def grasp(scenario: Scenario, models: MeasuredModels, world: TransportPlant, context: Context) -> None:
    """Sets both robots down at the cart, grippers at its handles, and makes their welds active."""
    (cart,) = scenario.objects
    x, y = cart.position
    world.ReleaseAll(context)
    body = world.plant.GetBodyByName(models.objects[cart.name].body_name, world.objects[cart.name])
    p_WO = np.array([x, y, models.objects[cart.name].height])
    world.plant.SetFreeBodyPose(context, body, models.objects[cart.name].pose(p_WO, cart.heading))
    for robot, way in ROBOTS.items():
        q = models.grasping(robot, cart.name, way, cart.heading).copy()
        q[:2] += x, y
        world.plant.SetPositions(context, world.agents[robot], q)
        (number,) = (i for i, w in enumerate(world.welds) if (w.agent, w.object, w.option) == (robot, cart.name, way))
        world.plant.SetConstraintActiveStatus(context, world.weld_ids[number], True)


def main() -> int:
    scenario = drake_ltl.load("hospital_cart")
    models = MeasureGeometry(scenario)
    diagram, world = build(scenario, models)
    with without_half_space_warning():
        simulator = Simulator(diagram)
    context = world.plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    grasp(scenario, models, world, context)
    (cart,) = scenario.objects
    for seconds in (0.0, 2.0, 4.0, 8.0):
        simulator.AdvanceTo(seconds)
        p_WO = world.plant.GetPositions(context, world.objects[cart.name])[4:]
        distance = np.linalg.norm(p_WO - GOAL)
        print(f"{seconds:3.0f} s: the cart is at ({p_WO[0]:.2f}, {p_WO[1]:.2f}), {distance:.3f} m from its goal")
    return 0 if distance < 0.01 else 1


if __name__ == "__main__":
    sys.exit(main())
