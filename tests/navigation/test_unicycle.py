"""Bodies that cannot move sideways: V falls whatever they steer, they come to rest at their goal poses alone."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.autodiffutils import ExtractGradient, InitializeAutoDiff

from drake_ltl.errors import InvalidInputError
from drake_ltl.navigation import RegionBall, StaticBody, Traveller, step_relations
from drake_ltl.navigation.dipolar_field import DipolarField
from drake_ltl.navigation.dipole import Dipole, heading_vector, left_of
from drake_ltl.navigation.unicycle import (
    UnicycleGains,
    direction_of_force,
    drive_force,
    is_at_rest,
    is_parked,
    lyapunov,
    sense_of_travel,
    steering_torque,
    wheel_torques,
)

MASS, INERTIA = 9.5, 0.31
RADIUS, HALF_TRACK, EFFORT = 0.1, 0.2, 3.0
SPHERE, RATIO = 0.27, 0.25
GAINS = UnicycleGains()
ANGLE = st.floats(-3.2, 3.2)


def make_field(starts, goals, obstacles=(), ratio=RATIO) -> DipolarField:
    """Of poses (N, 3); obstacles are rows x, y, radius."""
    home = RegionBall("home", (0.0, 0.0, 0.0), 8.0)
    travellers = [
        Traveller(f"a{i}", SPHERE, "home", "home", (*start[:2], 0.1), (*goal[:2], 0.1))
        for i, (start, goal) in enumerate(zip(starts, goals, strict=True))
    ]
    bodies = [StaticBody(f"o{i}", radius, (x, y, 0.1)) for i, (x, y, radius) in enumerate(obstacles)]
    step = step_relations(travellers=travellers, static_objects=bodies, regions=[home], workspace_radius=8.0)
    return DipolarField.of(step, [Dipole(tuple(g[:2]), g[2], ratio) for g in goals], force=20.0, kappa=12.0)


STARTS = np.array([[-4.0, 0.0, 0.0], [4.0, 0.2, 3.0], [0.0, -4.0, 1.0]])
GOALS = np.array([[4.0, 0.0, 0.4], [-4.0, 0.5, 2.0], [0.3, 4.0, -1.0]])


@pytest.fixture(scope="module")
def field() -> DipolarField:
    return make_field(STARTS, GOALS, [(0.5, -0.7, 0.5)])


def energy(field, p, v):
    return lyapunov(field.value(p), np.full(v.shape[-1], MASS), v)


@given(
    p=arrays(float, (3, 2), elements=st.floats(-4.0, 4.0)),
    theta=arrays(float, 3, elements=ANGLE),
    v=arrays(float, 3, elements=st.floats(-1.5, 1.5)),
    omega=arrays(float, 3, elements=st.floats(-3.0, 3.0)),
)
def test_v_falls_by_what_driving_dissipates_and_no_more(field, p, theta, v, omega):
    """dV/dt = -sum K_v v^2 along (U1), (U2), for every rate of turning: by central differences in time."""
    _, f = field.value_and_forces(p)
    assume(np.isfinite(f).all() and np.abs(f).max() < 200.0)
    vdot = drive_force(theta, v, f, GAINS.drive_damping) / MASS
    step = 1e-5

    def at(t):  # to second order in t, so that only the third counts
        turning = 0.5 * t**2 * (v * omega)[:, None] * left_of(heading_vector(theta))
        way = (v * t + 0.5 * vdot * t**2)[:, None] * heading_vector(theta)
        return energy(field, p + way + turning, v + vdot * t)

    rate = (at(step) - at(-step)) / (2.0 * step)
    expected = -GAINS.drive_damping * np.sum(v**2)
    assert rate == pytest.approx(expected, rel=1e-4, abs=1e-3)  # V of some 100 J has 1e-14 of it / step


@given(
    p=arrays(float, (3, 2), elements=st.floats(-4.0, 4.0)),
    theta=ANGLE,
    v=st.floats(-1.5, 1.5),
    sliding=arrays(float, (2, 2), elements=st.floats(-1.5, 1.5)),
)
def test_movers_that_can_move_sideways_may_take_part(field, p, theta, v, sliding):
    """One that drives among two that slide under f - K pd: dV/dt is the sum of what all of them dissipate."""
    _, f = field.value_and_forces(p)
    assume(np.isfinite(f).all() and np.abs(f).max() < 200.0)
    K, step = GAINS.drive_damping, 1e-6
    h = heading_vector(theta)
    pd = np.array([v * h, *sliding])
    pdd = np.array([drive_force(theta, v, f[0], K) * h, *(f[1:] - K * sliding)]) / MASS

    def at(t):
        return field.value(p + pd * t + 0.5 * pdd * t**2) + 0.5 * MASS * np.sum((pd + pdd * t) ** 2)

    rate = (at(step) - at(-step)) / (2.0 * step)
    assert rate == pytest.approx(-K * np.sum(pd**2), rel=1e-4, abs=1e-3)


@given(theta=ANGLE, force=st.floats(1e-6, 100.0), sense=st.sampled_from([-1.0, 1.0]), side=st.sampled_from([-1.0, 1.0]))
def test_no_rest_but_where_the_force_vanishes(theta, force, sense, side):
    """At rest across the force nothing drives: there, and there alone, the torque must turn the agent away."""
    f = side * force * left_of(heading_vector(theta))
    assert drive_force(theta, 0.0, f, GAINS.drive_damping) == pytest.approx(0.0, abs=1e-13 * force)
    tau = steering_torque(theta, 0.0, direction_of_force(f, sense, GAINS.softness), GAINS)
    assert abs(tau) == pytest.approx(GAINS.turn_stiffness * force / np.hypot(force, GAINS.softness), rel=1e-9)
    assert np.sign(tau) == sense * side


@given(theta=ANGLE, to=ANGLE)
def test_steering_turns_the_short_way(theta, to):
    error = np.angle(np.exp(1j * (to - theta)))
    tau = steering_torque(theta, 0.0, heading_vector(to), GAINS)
    if 1e-6 < abs(error) < np.pi - 1e-6:
        assert np.sign(tau) == np.sign(error)
    if abs(error) > np.pi / 2:
        assert abs(tau) == pytest.approx(GAINS.turn_stiffness, rel=1e-9)  # opposite headings are no place of rest
    assert steering_torque(to, 1.5, heading_vector(to), GAINS) == pytest.approx(-1.5 * GAINS.turn_damping)


@given(F=st.floats(-100.0, 100.0), tau=st.floats(-50.0, 50.0))
def test_wheels_give_the_force_first(F, tau):
    left, right = wheel_torques(F, tau, RADIUS, HALF_TRACK, EFFORT)
    assert max(abs(left), abs(right)) <= EFFORT + 1e-12
    given_F, given_tau = (left + right) / RADIUS, (right - left) * HALF_TRACK / RADIUS
    most = 2.0 * EFFORT / RADIUS
    assert given_F == pytest.approx(np.clip(F, -most, most), abs=1e-9)
    assert given_tau * tau >= 0.0
    assert abs(given_tau) <= abs(tau) + 1e-9
    if abs(F) + abs(tau) / HALF_TRACK <= most:
        assert given_tau == pytest.approx(tau, abs=1e-9)


def test_parking_has_a_hysteresis_that_ends_at_rest():
    near, between, far = (0.5 * GAINS.park) ** 2, (2.0 * GAINS.park) ** 2, (2.0 * GAINS.leave) ** 2
    cases = {(was, rest, gamma) for was in (False, True) for rest in (False, True) for gamma in (near, between, far)}
    parked = {case for case in cases if is_parked(*case, GAINS)}
    always = {case for case in cases if case[2] == near}
    assert parked == always | {(True, False, between)}


def test_at_rest_is_turned_and_still():
    assert is_at_rest(0.005, 0.005, -0.005, 2.0 * np.pi, GAINS)
    for theta, v, omega in ((0.02, 0.0, 0.0), (0.0, 0.02, 0.0), (0.0, 0.0, -0.02)):
        assert not is_at_rest(theta, v, omega, 0.0, GAINS)


@pytest.mark.parametrize(
    ("theta", "theta_goal", "sense"), [(0.0, 0.0, 1), (np.pi, np.pi, -1), (3.0, 1.0, -1), (1.0, 1.5, 1), (2.0, 1.0, 1)]
)
def test_sense_is_the_one_with_less_turning(theta, theta_goal, sense):
    """The goal lies in the direction of x."""
    assert sense_of_travel(theta, np.zeros(2), np.array([3.0, 0.0]), theta_goal) == sense


@pytest.mark.parametrize(
    "change", [{"drive_damping": 0.0}, {"turn_stiffness": -1.0}, {"park": np.nan}, {"leave": 0.005}, {"still": np.inf}]
)
def test_bad_gains_are_refused(change):
    with pytest.raises(InvalidInputError, match=f"gains.{next(iter(change))}"):
        replace(GAINS, **change)


@dataclass
class State:
    """Of B runs with N agents each."""

    p: np.ndarray
    theta: np.ndarray
    v: np.ndarray
    omega: np.ndarray
    parked: np.ndarray

    def assert_arrived(self, goals: np.ndarray) -> None:
        assert self.parked.all()
        assert np.linalg.norm(self.p - goals[:, :2], axis=-1).max() <= GAINS.park / np.sqrt(RATIO)
        assert np.abs(np.angle(np.exp(1j * (self.theta - goals[:, 2])))).max() <= GAINS.still
        assert max(np.abs(self.v).max(), np.abs(self.omega).max()) <= GAINS.still


def run(field, starts, *, seconds, dt=0.01):
    """The state after each step of (U1) to (U4), wheels of limited torque included, from starts (B, N, 3)."""
    goals = np.array([(*dipole.p_goal, dipole.heading) for dipole in field.dipoles])
    p, theta = starts[..., :2].copy(), starts[..., 2].copy()
    v, omega, parked = np.zeros(theta.shape), np.zeros(theta.shape), np.zeros(theta.shape, dtype=bool)
    sense = sense_of_travel(theta, p, goals[:, :2], goals[:, 2])
    for _ in range(round(seconds / dt)):
        _, f = field.value_and_forces(p)
        was, rest = parked, is_at_rest(theta, v, omega, goals[:, 2], GAINS)
        parked = is_parked(was, rest, field.gamma(p), GAINS)
        sense = np.where(was & ~parked, sense_of_travel(theta, p, goals[:, :2], goals[:, 2]), sense)
        way = direction_of_force(f, sense, GAINS.softness)
        u = np.where(parked[..., None], heading_vector(goals[:, 2]), way)
        F, tau = drive_force(theta, v, f, GAINS.drive_damping), steering_torque(theta, omega, u, GAINS)
        left, right = wheel_torques(F, tau, RADIUS, HALF_TRACK, EFFORT)
        v = v + dt * (left + right) / RADIUS / MASS
        omega = omega + dt * (right - left) * HALF_TRACK / RADIUS / INERTIA
        p, theta = p + dt * v[..., None] * heading_vector(theta), theta + dt * omega
        yield State(p, theta, v, omega, parked)


def test_it_arrives_along_its_heading():
    """From behind and askew: how far it still has to turn when it parks."""
    goal = np.array([[0.0, 0.0, 0.0]])
    askew = np.array([[[-3.0, y, 0.0]] for y in (-2.5, -1.5, 1.5, 2.5)])
    dipolar, plain = (
        _turn_left_when_parked(make_field([[-3.0, 0.0, 0.0]], goal, ratio=ratio), askew) for ratio in (RATIO, 1.0)
    )
    assert np.all(dipolar < 0.15)  # less the slower it is: the heading lags behind the field's
    assert np.all(plain > 0.4)  # the paper's gamma: it comes straight, from wherever it was


def _turn_left_when_parked(field, starts):
    turn = np.full(len(starts), np.nan)
    for state in run(field, starts, seconds=12.0):
        now = state.parked[:, 0] & np.isnan(turn)
        turn[now] = np.abs(state.theta[now, 0])
    return turn


def test_linearisation_at_the_goal_is_stable_but_for_what_a_pose_lacks():
    """By AutoDiff, when parked: of x = (s, l, theta, v, omega) all but the error across the heading die away."""
    dipole, stiffness = Dipole((0.0, 0.0), 0.0, RATIO), 20.0 / 0.5  # k / delta

    def rate(x):
        p, theta, v, omega = x[:2], x[2], x[3], x[4]
        f = -0.5 * stiffness * dipole.gradient(p)
        vdot = drive_force(theta, v, f, GAINS.drive_damping) / MASS
        omegadot = steering_torque(theta, omega, heading_vector(0.0), GAINS) / INERTIA
        return np.array([*(v * heading_vector(theta)), omega, vdot, omegadot])

    x = InitializeAutoDiff(np.zeros(5))[:, 0]
    eigenvalues = np.sort(np.linalg.eigvals(ExtractGradient(rate(x)[:, None])).real)
    assert eigenvalues[-1] == pytest.approx(0.0, abs=1e-12)
    assert np.all(eigenvalues[:-1] < -0.5)  # the slowest is near ratio k / (delta K_v) = 0.5 / s, or twice that


def test_one_agent_reaches_its_pose_from_all_around_and_v_never_rises():
    goal, obstacle = np.array([[1.5, 0.5, 2.0]]), (-0.5, 0.0, 0.5)
    field = make_field([[-4.0, 0.0, 0.0]], goal, [obstacle])
    rng = np.random.default_rng(0)
    starts = rng.uniform([-5.0, -5.0, -np.pi], [5.0, 5.0, np.pi], size=(100, 1, 3))
    starts = starts[np.isfinite(field.value(starts[..., :2]))]
    before = energy(field, starts[..., :2], np.zeros(starts.shape[:2]))
    for state in run(field, starts, seconds=25.0):
        now = energy(field, state.p, state.v)
        assert np.all(now <= before + 1e-9)  # rounding
        before = now
    state.assert_arrived(goal)


def test_three_agents_cross_without_meeting():
    """From many starts; every one of them ends at the goal poses."""
    field = make_field(STARTS, GOALS)
    rng = np.random.default_rng(1)
    starts = STARTS + rng.uniform(-1.0, 1.0, size=(15, 3, 3)) * [0.5, 0.5, np.pi]
    before = energy(field, starts[..., :2], np.zeros((15, 3)))
    for state in run(field, starts, seconds=45.0):
        now = energy(field, state.p, state.v)
        assert np.all(now <= before + 1e-6)  # of 260 J: in a step a turning body moves aside by v omega dt^2
        before = now
        gaps = np.linalg.norm(state.p[:, [0, 0, 1]] - state.p[:, [1, 2, 2]], axis=-1) - 2.0 * SPHERE
        assert gaps.min() > 0.0
    state.assert_arrived(GOALS)
