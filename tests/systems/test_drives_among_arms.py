"""A differential drive in a mission: its law against the formulas, its stages, and both forms of the controllers."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from drake_ltl.diagrams import MakeMissionDiagram
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_ltl.mission import measure, plan_and_place
from drake_ltl.multibody.drive_agent import BRAKING, BRISK, LATERAL, YAW
from drake_ltl.navigation.dipole import heading_vector
from drake_ltl.navigation.unicycle import direction_of_force, drive_force, steering_torque, wheel_torques
from drake_ltl.scenario import loads
from drake_ltl.systems.detours import STALL_TIME
from drake_ltl.systems.drive_law import DriveLaw, next_stage, sense
from drake_ltl.systems.preflight import snapshot
from drake_ltl.systems.program import mission_program
from drake_ltl.systems.progress import Measurement, Progress
from drake_ltl.systems.signals import Mode, Phase, Stage
from drake_ltl.systems.supervision import Supervision

TEXT = """
workspace: {radius: 9.0}
regions:
  pi1: {centre: [-3.5, 0, 0], radius: 2.5}
  pi2: {centre: [3.5, 0, 0], radius: 2.5}
agents:
  a1:
    model: package://drake_ltl_models/agents/planar_arm.urdf
    position: [-3.6, 0.4]
    spec: "F pi2"
  a2:
    model: package://drake_ltl_models/bases/differential_drive.urdf
    position: [3.0, 0.0]
    heading: 1.0
    headings: {pi1: -2.0}
    spec: "F pi1"
"""


@pytest.fixture(scope="module")
def parts():
    """Scenario, models and mission of one arm and one drive that change places."""
    scenario = loads(TEXT)
    models = measure(scenario)
    return plan_and_place(scenario, models), scenario, models


@pytest.fixture(scope="module")
def drive(parts):
    return parts[2].agents["a2"]


@pytest.fixture(scope="module")
def law(drive):
    return DriveLaw(drive, 10.0, 2.0)


NUMBER = st.floats(-3.0, 3.0)
STATES = st.tuples(st.lists(NUMBER, min_size=8, max_size=8), st.lists(NUMBER, min_size=8, max_size=8)).map(
    lambda lists: tuple(map(np.array, lists))
)


def rates(q, qd):
    return heading_vector(q[YAW]) @ qd[:2], qd[YAW]


@settings(max_examples=30)
@given(state=STATES, f=st.lists(st.floats(-60.0, 60.0), min_size=2, max_size=2), stage=st.sampled_from(Stage))
def test_its_law_is_that_of_the_formulas(drive, law, state, f, stage):
    """(U2) to (U4) with the force divided by the scale, as `navigation.unicycle` has them for arrays."""
    (q, qd), goal = state, np.array([0.5, -0.5, 0.7, 0, 0, 0, 0, 0])
    (v, omega), pull = rates(q, qd), np.array(f) / drive.scale
    u = heading_vector(0.7) if stage == Stage.PARKED else direction_of_force(pull, stage, drive.gains.softness)
    growth = min(max(abs(v) / BRISK, 1.0) ** 2, 8.0)
    against = max(0.0, -float(heading_vector(q[YAW]) @ pull) * np.sign(v))
    damping = growth * drive.drive_damping(q, goal, parked=stage == Stage.PARKED) + BRAKING * against
    F = drive_force(q[YAW], v, pull, damping)
    slower = min(1.0, LATERAL / max(2.5 * abs(v), 1e-9))  # of 2.5 rad/s, the largest rate
    tau = steering_torque(q[YAW], omega, slower * u, drive.gains)
    numbers = drive.drive.wheel_radius, drive.drive.half_track, drive.effort
    torques = law.travel(q, qd, np.concatenate([-np.array(f), np.zeros(6)]), stage, goal)
    np.testing.assert_allclose(torques[[*drive.wheels]], wheel_torques(F, tau, *numbers), rtol=1e-9, atol=1e-9)
    assert not np.delete(torques, drive.wheels).any()
    assert np.abs(torques).max() <= drive.effort + 1e-12 <= drive.drive.effort  # but for rounding


@settings(max_examples=30)
@given(state=STATES)
def test_who_holds_is_brought_back_along_and_to_its_heading(drive, law, state):
    """In small: the force of a critically damped spring along the heading, and such a torque."""
    q, qd = state
    hold, qd = q + 1e-5 * q[::-1], 1e-5 * qd
    v, omega = rates(q, qd)
    left, right = law.hold(q, qd, hold)[[*drive.wheels]]
    r, b = drive.drive.wheel_radius, drive.drive.half_track
    F = drive.drive.mass * (100.0 * heading_vector(q[YAW]) @ (hold - q)[:2] - 20.0 * v)
    tau = drive.drive.inertia * (100.0 * np.sin(hold[YAW] - q[YAW]) - 20.0 * omega)
    np.testing.assert_allclose([(left + right) / r, (right - left) * b / r], [F, tau], atol=1e-9)


def test_it_drives_forwards_or_backwards_whichever_is_nearer_to_both_headings():
    q, goal = np.zeros(8), np.array([2.0, 0, 0, 0, 0, 0, 0, 0])
    assert sense(q, goal) == Stage.FORWARDS
    assert sense(q, -goal) == Stage.BACKWARDS


def test_it_parks_near_its_goal_and_sets_out_again_far_from_it(drive):
    goal, still = np.zeros(8), np.zeros(8)

    def at(x, heading=1.0):
        return np.array([x, 0, heading, 0, 0, 0, 0, 0])

    assert next_stage(drive, Stage.FORWARDS, at(0.5), still, goal) == Stage.FORWARDS
    assert next_stage(drive, Stage.FORWARDS, at(0.015), still, goal) == Stage.PARKED  # along the heading half counts
    assert next_stage(drive, Stage.PARKED, at(0.06), still, goal) == Stage.PARKED  # pushed, but not far
    assert next_stage(drive, Stage.PARKED, at(0.06, 0.0), still, goal) == Stage.BACKWARDS  # at rest, and not near
    assert next_stage(drive, Stage.PARKED, at(0.3), still, goal) == Stage.BACKWARDS


def test_its_goal_has_the_heading_of_the_region(parts):
    mission, scenario, models = parts
    (task,) = [t for t in mission_program(mission, models, scenario).steps[0].travels if t.agent == "a2"]
    assert task.q_goal[YAW] == -2.0
    model = models.agents["a2"]
    assert model.arriving(np.zeros(8), "pi2")[YAW] == 1.0  # of which `headings` says nothing
    turned = np.array([0, 0, -2.0 + 4.0 * np.pi + 0.01, 0, 0, 0, 30.0, 30.0])
    assert model.joint_error(turned, model.arriving(turned, "pi1")) == pytest.approx(0.01)


def test_v_does_not_begin_anew_while_wheels_turn(parts):
    """Slow for as long as a stall takes, a drive still creeps: its goal is not given up until it rests."""
    mission, scenario, models = parts
    supervision = Supervision(mission_program(mission, models, scenario), scenario, models, num_steps=1)
    here = snapshot(mission.steps[0].before, models)
    rest = {name: np.zeros_like(q) for name, q in here.q.items()}
    creeping = rest | {"a2": np.array([0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.1])}
    state = supervision.begin(Measurement(0.0, here.q, rest, {}, {}))
    for time in (0.02, STALL_TIME + 0.1, 2.0 * STALL_TIME):
        state = supervision.advance(state, 0, Measurement(time, here.q, creeping, {}, {}))
        assert state.interval == 0
    assert state.slow_since == 0.02
    assert supervision.advance(state, 0, Measurement(time + 0.02, here.q, rest, {}, {})).interval == 1


@pytest.fixture(scope="module")
def diagrams(parts):
    """All laws in one system, and separate ones."""
    return [MakeMissionDiagram(*parts, num_steps=1, separate_controllers=separate) for separate in (False, True)]


def evaluate(made, change, seed):
    """Torques and V somewhere near the start, in motion."""
    root, rng = made.CreateStartContext(), np.random.default_rng(seed)
    plant = made.transport_plant.plant
    context = plant.GetMyMutableContextFromRoot(root)
    x = plant.GetPositionsAndVelocities(context)
    plant.SetPositionsAndVelocities(context, x + rng.normal(scale=0.3, size=len(x)))
    own = made.supervisor.GetMyMutableContextFromRoot(root)
    now = made.supervisor.measured(own)
    supervision = made.supervisor._supervision
    made.supervisor.SetProgress(own, change(supervision.begin(replace(now, q=dict(now.q)))))
    monitor = made.monitors["lyapunov"]
    return monitor.get_signal_input_port().Eval(monitor.GetMyContextFromRoot(root))


@settings(max_examples=5)
@given(seed=st.integers(0, 2**32 - 1), stage=st.sampled_from(Stage))
def test_the_laws_are_those_of_the_separate_systems(diagrams, seed, stage):
    def travelling(progress: Progress) -> Progress:
        assert [told.mode for told in progress.agents] == [Mode.TRANSITION, Mode.TRANSITION]
        return progress.with_agent(1, stage=stage)

    def held(progress: Progress) -> Progress:
        agents = [replace(told, mode=Mode.HOLD, hold=told.hold + 0.01) for told in progress.agents]
        return replace(progress, phase=Phase.REACH, agents=tuple(agents))

    for change in (travelling, held):
        one, separate = (evaluate(made, change, seed) for made in diagrams)
        np.testing.assert_allclose(one, separate, rtol=1e-9, atol=1e-9)  # rounding: sums in another order
        assert bool(one[-1] > 0.0) is (change is travelling)


def test_drives_have_no_reach_controller_to_replace(parts):
    from drake_ltl.errors import InvalidInputError

    with pytest.raises(InvalidInputError, match=r"reach_a1, hold_a2, transition_a2$"):
        MakeMissionDiagram(*parts, num_steps=1, own_controllers={"reach_a2": SimpleNamespace()})
