"""The systems that drive a differential drive: its field and its controller."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from drake_ltl.errors import ExecutionError
from drake_ltl.multibody.differential_drive_model import DifferentialDriveModel
from drake_ltl.navigation import RegionBall, Traveller, step_relations
from drake_ltl.navigation.dipolar_field import DipolarField
from drake_ltl.navigation.dipole import Dipole, heading_vector, left_of
from drake_ltl.navigation.unicycle import (
    UnicycleGains,
    direction_of_force,
    drive_force,
    lyapunov,
    steering_torque,
    wheel_torques,
)
from drake_ltl.systems.differential_drive_controller import DifferentialDriveController
from drake_ltl.systems.drive_field import DriveField

GAINS = UnicycleGains()
GOALS = {"a1": (3.0, 1.0, 0.5), "a2": (-3.0, 1.5, 2.0)}
VELOCITY = st.floats(-1.0, 1.0)


@pytest.fixture(scope="module")
def models() -> dict[str, DifferentialDriveModel]:
    return {name: DifferentialDriveModel(name) for name in GOALS}


@pytest.fixture(scope="module")
def field(models) -> DipolarField:
    home = RegionBall("home", (0.0, 0.0, 0.0), 8.0)
    travellers = [
        Traveller(name, models[name].radius, "home", "home", (-x, -y, 0.1), (x, y, 0.1))
        for name, (x, y, _) in GOALS.items()
    ]
    step = step_relations(travellers=travellers, regions=[home], workspace_radius=8.0)
    return DipolarField.of(step, [Dipole((x, y), theta) for x, y, theta in GOALS.values()], force=20.0, kappa=12.0)


@pytest.fixture(scope="module")
def drive_field(field, models) -> DriveField:
    return DriveField(field, models)


@pytest.fixture(scope="module")
def controller(models, field) -> DifferentialDriveController:
    return DifferentialDriveController(models["a1"], field.dipoles[0], GAINS)


def state_of(model, pose, v=0.0, omega=0.0) -> np.ndarray:
    """Of a drive that rolls without slip, upright; v at the middle of the axle."""
    h = heading_vector(pose[2])
    wheels = [(v - model.half_track * omega) / model.wheel_radius, (v + model.half_track * omega) / model.wheel_radius]
    return np.array([*model.positions(*pose), 0.0, 0.0, omega, *(v * h), 0.0, *wheels])


@given(v=arrays(float, 2, elements=VELOCITY))
def test_field_is_that_of_the_axles(drive_field, field, models, evaluate, v):
    poses = {"a1": (-2.0, 0.5, 0.3), "a2": (2.0, -0.5, -2.0)}
    inputs = {
        f"state_{name}": state_of(models[name], pose, speed)
        for (name, pose), speed in zip(poses.items(), v, strict=True)
    }
    p = np.array([pose[:2] for pose in poses.values()])
    potential, forces = field.value_and_forces(p)
    for name, expected in zip(poses, forces, strict=True):
        force = evaluate(drive_field, drive_field.get_force_output_port(name), inputs)
        np.testing.assert_allclose(force, expected, rtol=1e-9)  # up to the quaternion's rounding
    V = evaluate(drive_field, drive_field.get_lyapunov_output_port(), inputs)
    masses = np.array([model.mass for model in models.values()])
    assert V[0] == pytest.approx(lyapunov(potential, masses, v), rel=1e-9)


def test_collision_and_divergence_end_the_run(drive_field, models, evaluate):
    port = drive_field.get_lyapunov_output_port()
    at = {f"state_{name}": state_of(models[name], (x, 0.0, 0.0)) for name, x in (("a1", 0.0), ("a2", 0.5))}
    with pytest.raises(ExecutionError, match="in collision: a1 and a2"):
        evaluate(drive_field, port, at)
    with pytest.raises(ExecutionError, match="the state of a1 is not finite"):
        evaluate(drive_field, port, at | {"state_a1": np.full(17, np.nan)})


def test_field_wants_the_movers_models(field, models):
    with pytest.raises(ValueError, match="movers"):
        DriveField(field, dict(reversed(models.items())))


def torque(controller, stage, state, force) -> np.ndarray:
    context = controller.CreateDefaultContext()
    controller.get_state_input_port().FixValue(context, state)
    controller.get_force_input_port().FixValue(context, force)
    context.SetDiscreteState(np.array(stage, dtype=float))
    return controller.get_torque_output_port().Eval(context)


@given(
    theta=st.floats(-3.0, 3.0),
    v=VELOCITY,
    omega=VELOCITY,
    f=arrays(float, 2, elements=st.floats(-20.0, 20.0)),
    sense=st.sampled_from([-1.0, 1.0]),
    parked=st.booleans(),
)
def test_torque_is_the_law(controller, models, theta, v, omega, f, sense, parked):
    model = models["a1"]
    u = heading_vector(GOALS["a1"][2]) if parked else direction_of_force(f, sense, GAINS.softness)
    F = drive_force(theta, v, f, GAINS.drive_damping)
    tau = steering_torque(theta, omega, u, GAINS)
    expected = wheel_torques(F, tau, model.wheel_radius, model.half_track, model.effort)
    actual = torque(controller, (sense, parked), state_of(model, (0.0, 0.0, theta), v, omega), f)
    np.testing.assert_allclose(actual, expected, atol=1e-9)


def stage_after(controller, update, state, stage=(0.0, 0.0)) -> tuple[float, ...]:
    context = controller.CreateDefaultContext()
    controller.get_state_input_port().FixValue(context, state)
    controller.get_force_input_port().FixValue(context, np.zeros(2))
    context.SetDiscreteState(np.array(stage, dtype=float))
    updated = controller.AllocateDiscreteVariables()
    updated.SetFrom(context.get_discrete_state())
    update(context, updated)
    return tuple(updated.value())


def initialise(controller):
    return lambda context, updated: updated.SetFrom(_initialised(controller, context))


def _initialised(controller, context):
    controller.ExecuteInitializationEvents(context)
    return context.get_discrete_state()


def look(controller):
    return lambda context, updated: updated.SetFrom(controller.EvalUniquePeriodicDiscreteUpdate(context))


def test_sense_is_chosen_at_the_start(controller, models):
    """The goal lies ahead of the one and behind the other."""
    for pose, sense in (((0.0, 0.0, 0.0), 1.0), ((6.0, 2.0, 0.3), -1.0)):
        state = state_of(models["a1"], pose)
        assert stage_after(controller, initialise(controller), state) == (sense, 0.0)


@pytest.mark.parametrize(
    ("offset", "turn", "stage", "expected"),
    [
        (0.1, 0.0, (1.0, 0.0), (1.0, 0.0)),  # on its way
        (0.005, 0.3, (-1.0, 0.0), (-1.0, 1.0)),  # parks
        (0.03, 0.3, (1.0, 1.0), (1.0, 1.0)),  # turns there
        (0.03, 0.0, (1.0, 1.0), (1.0, 0.0)),  # has turned, but is not near enough
        (0.1, 0.3, (-1.0, 1.0), (1.0, 0.0)),  # was pushed away: sets out anew, forwards
    ],
)
def test_it_parks_and_sets_out_again(controller, models, offset, turn, stage, expected):
    x, y, theta = GOALS["a1"]
    h = heading_vector(theta)
    p = [x, y] - offset * left_of(h) - 0.002 * h  # a little behind, lest forwards and backwards be alike
    state = state_of(models["a1"], (*p, theta + turn))
    assert stage_after(controller, look(controller), state, stage) == expected


def test_ports_are_named(controller, drive_field):
    assert controller.GetInputPort("state") is controller.get_state_input_port()
    assert controller.GetInputPort("force") is controller.get_force_input_port()
    assert controller.GetOutputPort("torque") is controller.get_torque_output_port()
    assert controller.GetOutputPort("stage") is controller.get_stage_output_port()
    assert controller.get_name() == "drive_a1"
    assert drive_field.GetInputPort("state_a2") is drive_field.get_state_input_port("a2")
    assert drive_field.GetOutputPort("force_a2") is drive_field.get_force_output_port("a2")
    assert drive_field.GetOutputPort("lyapunov") is drive_field.get_lyapunov_output_port()
