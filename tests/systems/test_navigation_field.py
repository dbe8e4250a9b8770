"""The navigation field: value, gradient and V of the step that is being carried out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from drake_ltl.diagrams.transport_plant import AddTransportPlant
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.systems.framework import DiagramBuilder

from drake_ltl.dynamics import rotation_mismatch
from drake_ltl.errors import ExecutionError
from drake_ltl.systems.field_value import ROTATION_WEIGHT, rotation_error
from drake_ltl.systems.legs import Leg
from drake_ltl.systems.navigation_field import NavigationField
from drake_ltl.systems.signals import Phase, pack_reach, pack_step

TOGETHER = Leg()
TRAVEL, TRAVEL_AND_GRASP, TRANSPORT = 0, 1, 2  # steps of case ii
STEP = 1e-6
"""Of central differences [m, rad]: k Phi is some 1e3 J, so rounding costs 1e-13 * 1e3 / 1e-6 = 1e-4 N."""


@pytest.fixture(scope="module")
def field(program, case_ii, models) -> NavigationField:
    return NavigationField(program, case_ii, models)


@pytest.fixture(scope="module")
def stage(field, mission, world_at):
    """stage(step, **options): a fresh Context with all bodies where the step begins, and the world it shows."""

    def make(step: int, phase=Phase.NAVIGATE, interval=0, leg=TOGETHER, field=field):
        world = world_at(mission.steps[step].before)
        context = field.CreateDefaultContext()
        field.get_step_input_port().FixValue(context, pack_step(step, phase, interval, leg))
        field.get_anchor_input_port().FixValue(context, world.anchor)
        for name, q in world.q.items():
            field.get_reach_input_port(name).FixValue(context, pack_reach(0.0, 1.0, q, q))
        show(field, context, world)
        return context, world

    return make


def show(field, context, world) -> None:
    for name in (*world.q, *world.X_WO):
        field.get_state_input_port(name).FixValue(context, world.state(name))


def lyapunov(field, context) -> float:
    return field.get_lyapunov_output_port().Eval(context)[0]


def gradients(field, context, world) -> dict[str, np.ndarray]:
    return {name: field.get_gradient_output_port(name).Eval(context) for name in (*world.q, *world.X_WO)}


def assert_gradient(field, context, world, name, axis, slope, moved) -> None:
    """`moved(h)` changes the world by h along the axis. At rest V is k Phi."""
    values = []
    for h in (STEP, -STEP):
        show(field, context, moved(h))
        values.append(lyapunov(field, context))
    difference = (values[0] - values[1]) / (2 * STEP)
    assert slope == pytest.approx(difference, rel=1e-5, abs=2e-3), (name, axis)


OFFSETS = st.lists(st.floats(-0.4, 0.4), min_size=12, max_size=12)


@settings(max_examples=8)
@given(offsets=OFFSETS)
def test_gradient_of_travellers(field, stage, offsets):
    context, world = stage(TRAVEL)
    for k, name in enumerate(("a2", "a3")):
        world.q[name] = world.q[name] + offsets[4 * k : 4 * k + 4]
    show(field, context, world)
    found = gradients(field, context, world)
    for name in ("a2", "a3"):
        for j in range(4):

            def moved(h, name=name, j=j):
                return replace(world, q=world.q | {name: world.q[name] + h * np.eye(4)[j]})

            assert_gradient(field, context, world, name, j, found[name][j], moved)


@settings(max_examples=8)
@given(offsets=OFFSETS)
def test_gradient_of_a_carried_object(field, stage, offsets):
    """Along translations and along rotations about the world's axes."""
    context, world = stage(TRANSPORT)
    turn = np.array(offsets[3:6]) + np.array([0.0, 0.0, 1e-3])
    R = RotationMatrix(AngleAxis(np.linalg.norm(turn), turn / np.linalg.norm(turn)))
    X = RigidTransform(R, world.X_WO["o2"].translation() + offsets[:3])
    world.X_WO["o2"] = X
    show(field, context, world)
    found = gradients(field, context, world)["o2"]
    for j in range(3):

        def turned(h, j=j):
            R = RotationMatrix(AngleAxis(h, np.eye(3)[j])) @ X.rotation()
            return replace(world, X_WO=world.X_WO | {"o2": RigidTransform(R, X.translation())})

        def shifted(h, j=j):
            moved = RigidTransform(X.rotation(), X.translation() + h * np.eye(3)[j])
            return replace(world, X_WO=world.X_WO | {"o2": moved})

        assert_gradient(field, context, world, "o2", j, found[j], turned)
        assert_gradient(field, context, world, "o2", j + 3, found[j + 3], shifted)


turns = st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=3)


@given(turn=turns, goal=turns, length=st.floats(0.5, 2.0))
def test_rotation_error_is_3_minus_the_trace(turn, goal, length):
    """... of the rotation from the goal, for any quaternion along the same rotation."""
    R, R_goal = (RotationMatrix(RollPitchYaw(angles)) for angles in (turn, goal))
    value, slope = rotation_error(length * R.ToQuaternion().wxyz(), R_goal.ToQuaternion().wxyz())
    error, expected = rotation_mismatch(R.matrix(), R_goal.matrix())
    assert value == pytest.approx(ROTATION_WEIGHT * error, abs=1e-12)
    np.testing.assert_allclose(slope, ROTATION_WEIGHT * expected, atol=1e-12)


def test_what_does_not_move_has_no_gradient(field, stage):
    for step, movers in ((TRAVEL, {"a2", "a3"}), (TRAVEL_AND_GRASP, {"a1", "a2", "a3"}), (TRANSPORT, {"o2"})):
        context, world = stage(step)
        found = gradients(field, context, world)
        assert {name for name, slope in found.items() if np.any(slope != 0.0)} == movers


@pytest.mark.parametrize("phase", [Phase.REACH, Phase.DONE])
def test_nothing_moves_in_other_phases(field, stage, phase):
    context, world = stage(TRAVEL, phase=phase)
    assert lyapunov(field, context) == 0.0
    assert not any(slope.any() for slope in gradients(field, context, world).values())


def test_at_the_goal_the_gradient_is_zero(field, stage, program):
    context, world = stage(TRAVEL)
    for task in program.steps[TRAVEL].travels:
        world.q[task.agent] = task.q_goal
    show(field, context, world)
    assert lyapunov(field, context) == 0.0
    assert not any(slope.any() for slope in gradients(field, context, world).values())


def test_a_lone_mover_goes_by_way_of_a_point(field, stage, models, program):
    """On a leg the goal is the way point, and the others stand still."""
    via = (5.0, 5.0)
    context, world = stage(TRAVEL, leg=Leg(active=1, via=via))
    (task,) = (task for task in program.steps[TRAVEL].travels if task.agent == "a3")
    q = task.q_goal.copy()
    q[:2] += np.array(via) - models.agents["a3"].centre(q)[:2]
    np.testing.assert_allclose(models.agents["a3"].centre(q)[:2], via)
    world.q["a3"] = q
    show(field, context, world)
    found = gradients(field, context, world)
    np.testing.assert_allclose(found["a3"], 0.0, atol=1e-9)
    world.q["a3"] = q + np.array([0.1, 0.0, 0.0, 0.0])
    show(field, context, world)
    found = gradients(field, context, world)
    assert found["a3"][0] > 1.0
    assert not found["a2"].any()


@pytest.mark.parametrize(("step", "moving"), [(TRAVEL, ("a2", "a3")), (TRANSPORT, ("a2", "a3", "o2"))])
def test_lyapunov_adds_the_kinetic_energy_of_what_moves(field, stage, case_ii, models, step, moving):
    context, world = stage(step)
    at_rest = lyapunov(field, context)
    rng = np.random.default_rng(step)
    for name in moving:
        if name in world.q:
            world.qd[name] = rng.normal(size=4)
        else:
            world.V_WO[name] = rng.normal(size=6)
    show(field, context, world)
    builder = DiagramBuilder()
    parts = AddTransportPlant(builder, case_ii, models)
    plant = parts.plant
    plant_context = plant.CreateDefaultContext()
    for name, instance in (parts.agents | parts.objects).items():
        plant.SetPositionsAndVelocities(plant_context, instance, world.state(name))
    energy = plant.CalcKineticEnergy(plant_context)
    assert energy > 1.0
    assert lyapunov(field, context) - at_rest == pytest.approx(energy, rel=1e-9)


def test_only_movers_count_in_the_kinetic_energy(field, stage):
    context, world = stage(TRAVEL)
    at_rest = lyapunov(field, context)
    world.qd["a1"] = np.ones(4)
    world.V_WO["o1"] = np.ones(6)
    show(field, context, world)
    assert lyapunov(field, context) == at_rest


def test_what_stands_is_where_the_phase_began(field, stage):
    """Nobody but the movers can change V: others count at the anchor, wherever they have drifted."""
    context, world = stage(TRAVEL)
    before = lyapunov(field, context)
    world.q["a1"] = world.q["a1"] + 0.3
    world.X_WO["o1"] = RigidTransform(world.X_WO["o1"].translation() + 0.3)
    show(field, context, world)
    assert lyapunov(field, context) == before


def test_a_collision_is_named(field, stage, program):
    context, world = stage(TRAVEL)
    world.q["a2"] = world.q["a1"] + np.array([0.0, 0.5, 0.0, 0.0])
    show(field, context, world)
    with pytest.raises(ExecutionError, match=r"in collision: .*\ba2 and a1\b"):
        lyapunov(field, context)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_state_that_is_not_finite_is_no_collision(field, stage, bad):
    context, world = stage(TRAVEL)
    world.q["a3"] = np.array([bad, 0.0, 0.0, 0.0])
    show(field, context, world)
    with pytest.raises(ExecutionError, match="not finite"):
        lyapunov(field, context)


def test_contexts_do_not_share_memory(field, stage):
    """A, B, A: another step, and the same step from another begin."""
    first, world = stage(TRAVEL)
    again, _ = stage(TRAVEL)
    other, _ = stage(TRANSPORT)
    moved, _ = stage(TRAVEL)
    anchor = world.anchor
    anchor[0] += 0.2  # a1 stood elsewhere when this phase began
    field.get_anchor_input_port().FixValue(moved, anchor)
    values = [lyapunov(field, context) for context in (first, other, moved, again)]
    assert len(set(values)) == 3
    assert values[0] == values[3]
    assert gradients(field, again, world)["a2"] == pytest.approx(gradients(field, first, world)["a2"], rel=0, abs=0)


def test_contexts_with_other_reaches_do_not_share_memory(program, case_ii, models, mission, stage):
    """A step in which a2 approaches while a1 travels: where a2's approach ends is the context's own matter."""
    step = program.steps[TRAVEL_AND_GRASP]
    (approach,) = (task for task in step.late_grasps if task.weld.agent == "a2")
    travels = tuple(task for task in step.travels if task.agent == "a1")
    steps = list(program.steps)
    steps[TRAVEL_AND_GRASP] = replace(step, travels=travels, grasps=(approach,), late_grasps=())
    field = NavigationField(replace(program, steps=tuple(steps)), case_ii, models)

    def with_reach(length: float):
        context, world = stage(TRAVEL_AND_GRASP, field=field)
        q = world.q["a2"]
        reach = pack_reach(0.0, 1.0, q, q + np.array([0.0, length, 0.0, 0.0]))
        field.get_reach_input_port("a2").FixValue(context, reach)
        return context

    short, long, short_again = with_reach(0.1), with_reach(0.6), with_reach(0.1)
    values = [lyapunov(field, context) for context in (short, long, short_again)]
    assert values[0] != values[1]
    assert values[0] == values[2]


def test_ports_are_named(field, models):
    names = {field.get_input_port(i).get_name() for i in range(field.num_input_ports())}
    members = (*models.agents, *models.objects)
    expected = {"step", "anchor", *(f"reach_{a}" for a in models.agents), *(f"state_{name}" for name in members)}
    assert names == expected
    names = {field.get_output_port(i).get_name() for i in range(field.num_output_ports())}
    assert names == {"lyapunov", *(f"gradient_{name}" for name in members)}
