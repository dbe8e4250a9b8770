"""When movers have arrived, on made-up measurements."""

from __future__ import annotations

import numpy as np
import pytest
from pydrake.math import RigidTransform, RotationMatrix

from drake_ltl.multibody import MeasureGeometry
from drake_ltl.scenario import load, loads
from drake_ltl.systems.arrival import ROOM, Arrival
from drake_ltl.systems.program import TransportTask, TravelTask
from drake_ltl.systems.progress import Measurement


@pytest.fixture(scope="module")
def patrol(examples):
    scenario = load(examples / "patrol.yaml")
    return scenario, MeasureGeometry(scenario)


@pytest.mark.parametrize(
    ("room", "out", "there"),
    [
        (0.05, 0.015, True),  # well inside: the tolerance decides
        (0.002, 0.003, False),  # out of the region, though within the tolerance of the goal
        (0.002, 0.0015, False),  # nearer to the border than half as far as the goal
        (0.002, 0.0005, True),
        (2.0 * ROOM, ROOM + 0.001, False),
    ],
)
def test_who_has_arrived_is_inside_the_region(patrol, room, out, there):
    """The goal is so far inside the office, on its far side, and the robot so far beyond it."""
    scenario, models = patrol
    office, radius = scenario.region("office"), models.geometry.agent_radius["robot"]
    q_goal, arrival = np.zeros(4), Arrival.of(models, scenario)
    height = models.agents["robot"].centre(q_goal) - q_goal[:3] * [1.0, 1.0, 0.0]
    reach = np.sqrt((office.radius - radius - room) ** 2 - (height[2] - office.centre[2]) ** 2)
    q_goal[:2] = office.centre[0] + reach - height[0], office.centre[1] - height[1]
    outward = np.array([reach, 0.0, height[2] - office.centre[2]]) / (office.radius - radius - room)
    q = q_goal + np.array([out / outward[0], 0.0, 0.0, 0.0])
    now = Measurement(0.0, {"robot": q}, {"robot": np.zeros(4)}, {}, {})
    assert (arrival.left(TravelTask("robot", "kitchen", "office", q_goal), now) == "") is there


HANDOVER = """
workspace: {{radius: 20.0}}
regions:
  oven: {{centre: [-10, 0, 0], radius: 4.5}}
  shop: {{centre: [10, 0, 0], radius: 4.5}}
agents:
  a1: {{model: package://drake_ltl_models/agents/mobile_manipulator.urdf, position: [-9, 0]}}
  a2: {{model: package://drake_ltl_models/agents/{second}.urdf, position: [9, 0]}}
objects:
  o1: {{model: package://drake_ltl_models/objects/crate.sdf, position: [-12.5, 0], power_needed: 1}}
"""


@pytest.mark.parametrize(
    ("second", "team", "turn", "there"),
    [
        ("planar_arm", ("a1",), 0.012, False),  # more than a weld may be off, and a2 cannot turn after it
        ("planar_arm", ("a1",), 0.0007, True),
        ("planar_arm", ("a2",), 0.012, True),  # a team that cannot turn does nothing about it
        ("mobile_manipulator", ("a1",), 0.012, True),
    ],
)
def test_loads_are_turned_so_that_who_cannot_turn_can_grasp_them(second, team, turn, there):
    scenario = loads(HANDOVER.format(second=second))
    models = MeasureGeometry(scenario)
    p_goal = np.array([10.0, 0.0, models.geometry.object_height["o1"]])
    task = TransportTask("o1", team, np.array([1.0, 0.0]), "oven", "shop", p_goal, np.array([1.0, 0.0, 0.0, 0.0]))
    q = {name: np.zeros(model.n) for name, model in models.agents.items()}
    pose = RigidTransform(RotationMatrix.MakeZRotation(turn), p_goal)
    now = Measurement(0.0, q, q, {"o1": pose}, {"o1": np.zeros(6)})
    assert Arrival.of(models, scenario).is_done(task, now) is there
