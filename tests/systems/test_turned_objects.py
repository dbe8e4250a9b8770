"""A mission that turns its crate: tasks in joint coordinates, and what the supervisor makes of them."""

from __future__ import annotations

import numpy as np
import pytest
from drake_ltl.diagrams import MakeMissionDiagram
from pydrake.math import RigidTransform, RollPitchYaw

from drake_ltl.mission import measure, plan_and_place
from drake_ltl.scenario import loads
from drake_ltl.systems.arrival import Arrival
from drake_ltl.systems.legs import Leg, moving_tasks
from drake_ltl.systems.preflight import check_fields, snapshot
from drake_ltl.systems.program import mission_program
from drake_ltl.systems.progress import Measurement
from drake_ltl.systems.supervision import Supervision

START, THERE = -1.0, 2.0
TURN = """\
name: turn
workspace: {radius: 20.0}
team_radius: 2.4
regions:
  near: {centre: [-7.5, 0.0, 0.0], radius: 5.0}
  far: {centre: [7.0, 0.5, 0.0], radius: 5.0}
agents:
  a1:
    model: package://drake_ltl_models/agents/mobile_manipulator.urdf
    position: [-8.5, 2.5]
    radius: 0.9
    spec: "GF near"
objects:
  crate:
    model: package://drake_ltl_models/objects/crate.sdf
    position: [-7.0, -1.0]
    heading: -1.0
    headings: {far: 2.0, near: -1.0}
    spec: "GF near & GF far"
spec: "G(crate.far -> F(crate.far & a1.near))"
"""


@pytest.fixture(scope="module")
def turn():
    """(scenario, models, mission, program): a1 brings the crate there, drives back alone, and fetches it."""
    scenario = loads(TURN)
    models = measure(scenario)
    mission = plan_and_place(scenario, models)
    return scenario, models, mission, mission_program(mission, models, scenario)


def crate_at(models, layout) -> RigidTransform:
    return models.objects["crate"].pose(np.array(layout.objects["crate"]), layout.headings["crate"])


def test_grasps_meet_the_crate_as_it_stands(turn):
    _, models, mission, program = turn
    headings = set()
    for step, placed in zip(program.steps, mission.steps, strict=True):
        for task in (*step.grasps, *step.late_grasps):
            X_WO = crate_at(models, placed.before)
            X_OE = models.grasp("a1", "crate", task.weld.option).X_OE
            q = task.q_OE + np.array([*X_WO.translation()[:2], *np.zeros(7)])
            np.testing.assert_allclose(
                models.agents["a1"].grasp_pose(q).GetAsMatrix4(), (X_WO @ X_OE).GetAsMatrix4(), atol=1e-4
            )
            back = np.subtract(placed.standoffs["a1"].p_WC, models.agents["a1"].centre(q))  # straight from the handle
            ahead = (X_WO @ X_OE).rotation().matrix()[:, 2]
            np.testing.assert_allclose(back / np.linalg.norm(back), -ahead, atol=1e-4)
            headings.add(placed.before.headings["crate"])
    assert headings == {START, THERE}


def test_releases_back_off_from_the_crate_as_it_stands(turn):
    _, models, mission, program = turn
    headings = set()
    for step, placed in zip(program.steps, mission.steps, strict=True):
        for task in step.releases:
            held, free = placed.before.agents["a1"], placed.after.agents["a1"]
            np.testing.assert_allclose(np.subtract(free.p_WC, held.p_WC)[:2], task.retreat, atol=1e-6)
            q = snapshot(placed.before, models).q["a1"]
            ahead = models.agents["a1"].grasp_pose(q).rotation().matrix()[:2, 2]
            np.testing.assert_allclose(task.retreat / np.linalg.norm(task.retreat), -ahead, atol=1e-4)
            headings.add(placed.before.headings["crate"])
    assert THERE in headings


def test_transports_have_the_heading_for_their_goal(turn):
    _, models, mission, program = turn
    goals = {}
    for step, placed in zip(program.steps, mission.steps, strict=True):
        for task in step.transports:
            expected = crate_at(models, placed.after).rotation().ToQuaternion().wxyz()
            assert abs(expected @ task.orientation_goal) == pytest.approx(1.0, abs=1e-12)
            (via,) = moving_tasks(step, Leg(0, (0.0, 0.0)), models).transports  # on its way around something, too
            np.testing.assert_array_equal(via.orientation_goal, task.orientation_goal)
            goals[task.goal] = placed.after.headings["crate"]
    assert goals == {"far": THERE, "near": START}


def test_every_step_has_its_navigation_function(turn):
    scenario, models, _, program = turn
    check_fields(program, scenario, models)


def test_the_crate_begins_as_it_is_told_to(turn):
    scenario, models, mission, _ = turn
    diagram = MakeMissionDiagram(mission, scenario, models, num_steps=1)
    plant = diagram.transport_plant.plant
    context = plant.GetMyContextFromRoot(diagram.CreateStartContext())
    X_WO = plant.GetFreeBodyPose(context, plant.GetBodyByName("crate"))
    np.testing.assert_allclose(RollPitchYaw(X_WO.rotation()).vector(), [0.0, 0.0, START], atol=1e-12)
    np.testing.assert_allclose(X_WO.translation(), [-7.0, -1.0, models.objects["crate"].height], atol=1e-12)


def at_rest(q: np.ndarray, X_WO: RigidTransform) -> Measurement:
    return Measurement(0.0, {"a1": q}, {"a1": np.zeros(9)}, {"crate": X_WO}, {"crate": np.zeros(6)})


def test_a_transport_ends_with_its_heading(turn):
    scenario, models, mission, program = turn
    index = next(k for k, step in enumerate(program.steps) if step.transports)
    (task,) = program.steps[index].transports
    arrival, most = Arrival.of(models, scenario), scenario.tolerances.angle
    X_WO = crate_at(models, mission.steps[index].after)

    def left(turn: float, tilt: float = 0.0) -> str:
        X = RigidTransform(RollPitchYaw(0.0, 0.0, turn).ToRotationMatrix(), np.zeros(3)) @ X_WO
        X = RigidTransform(X.rotation() @ RollPitchYaw(tilt, 0.0, 0.0).ToRotationMatrix(), X_WO.translation())
        return arrival.left(task, at_rest(np.zeros(9), X))

    assert left(0.9 * most) == left(-0.9 * most) == left(2 * np.pi) == left(0.0, tilt=0.1) == ""
    assert "and 1.9 degrees from its place in far" in left(1.1 * most)
    assert left(-1.1 * most)


@pytest.mark.parametrize(("off", "turns"), [(0.02, 0), (-0.02, 1), (0.0, -2)])
def test_who_grasps_follows_the_crate_as_it_is_turned(turn, off, turns):
    """... a little off its heading, with the yaw that takes no whole turns to get to."""
    scenario, models, mission, program = turn
    supervision = Supervision(program, scenario, models, num_steps=len(program.steps))
    index, task = next((k, task) for k, step in enumerate(program.steps) for task in (*step.grasps, *step.late_grasps))
    X_WO = crate_at(models, mission.steps[index].before)
    X_WO = RigidTransform(RollPitchYaw(0.0, 0.0, off).ToRotationMatrix() @ X_WO.rotation(), X_WO.translation())
    q = task.q_OE + np.array([0.0, 0.0, 2.0 * np.pi * turns, *np.zeros(6)])
    progress = supervision.begin(at_rest(q, X_WO))
    approach = supervision._approach(progress, task, at_rest(q, X_WO)).agents[0].reach
    goal = approach[-9:]
    X_OE = models.grasp("a1", "crate", task.weld.option).X_OE
    np.testing.assert_allclose(
        models.agents["a1"].grasp_pose(goal).GetAsMatrix4(), (X_WO @ X_OE).GetAsMatrix4(), atol=1e-4
    )
    assert abs(goal[2] - q[2]) < 0.03


def test_tasks_are_as_before_where_nothing_is_turned(program, mission):
    """Case ii: every crate upright at heading 0."""
    for step, placed in zip(program.steps, mission.steps, strict=True):
        assert set(placed.after.headings.values()) == {0.0}
        for task in step.transports:
            np.testing.assert_array_equal(task.orientation_goal, [1.0, 0.0, 0.0, 0.0])
