"""Load sharing: its coefficients, its internal wrenches, and what wrists feel in simulated transports."""

from __future__ import annotations

import functools
from types import ModuleType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from drake_ltl.dynamics import (
    admissible_twists,
    body_gravity,
    check_load_shares,
    coupled_dynamics,
    grasp_matrix,
    internal_wrenches,
    load_shares,
    object_dynamics,
    object_to_agent_jacobian,
    object_to_agent_jacobian_rate,
    task_dynamics,
    wrench_at_gripper,
)

MASS, INERTIA = 0.5, np.diag([0.0170833333333, 0.0170833333333, 0.0133333333333])  # of the crate, from its file
vector3 = arrays(float, 3, elements=st.floats(-10.0, 10.0))
vector6 = arrays(float, 6, elements=st.floats(-10.0, 10.0))


@given(st.lists(st.floats(1e-3, 1e3), min_size=1, max_size=8))
def test_load_shares_are_positive_and_sum_to_one(power):
    shares = load_shares(power)
    assert np.all(shares > 0.0)
    assert shares.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(shares * sum(power), power)
    check_load_shares(shares)


def test_load_shares_of_huge_powers_do_not_overflow():
    np.testing.assert_array_equal(load_shares([1e308, 1e308]), [0.5, 0.5])


@pytest.mark.parametrize("power", [[], [1.0, 0.0], [-1.0], [np.nan], [np.inf, 1.0]])
def test_load_shares_refuse_powers_that_are_not_positive(power):
    with pytest.raises(ValueError, match="positive"):
        load_shares(power)


def test_a_share_never_vanishes():
    with pytest.raises(ValueError, match="too far apart"):
        load_shares([1e-200, 1e200])


@pytest.mark.parametrize("shares", [[0.5, 0.5, 0.0], [1.0], [0.0, 0.0], [1 / 3, 1 / 3, 1 / 3]])
def test_shares_of_a_team_or_of_none_pass(shares):
    check_load_shares(np.array(shares))


@pytest.mark.parametrize("shares", [[0.5, 0.4], [1.1, -0.1], [2.0], [np.nan, 1.0], [np.inf, 0.0], [1e-3, 0.0]])
def test_other_shares_are_refused(shares):
    with pytest.raises(ValueError, match="of sum 1"):
        check_load_shares(np.array(shares))


@given(st.lists(st.tuples(vector3, vector6, st.floats(0.1, 10.0)), min_size=1, max_size=4))
def test_internal_wrenches_do_not_move_the_object(team):
    offsets, wrenches, power = zip(*team, strict=True)
    inner = internal_wrenches(wrenches, offsets, load_shares(power))
    np.testing.assert_allclose(grasp_matrix(offsets).T @ inner.ravel(), 0.0, atol=1e-10)  # numbers up to 1e3


@given(st.lists(st.tuples(vector3, st.floats(0.1, 10.0)), min_size=1, max_size=4), vector6)
def test_what_the_law_distributes_is_not_internal(team, F):
    offsets, power = zip(*team, strict=True)
    shares = load_shares(power)
    wrenches = [wrench_at_gripper(c * F, p) for c, p in zip(shares, offsets, strict=True)]
    np.testing.assert_allclose(internal_wrenches(wrenches, offsets, shares), 0.0, atol=1e-10)


def test_a_squeeze_is_internal():
    """Two agents that press against each other along the line between them."""
    offsets = [np.array([-0.3, 0.0, 0.1]), np.array([0.3, 0.0, 0.1])]
    squeeze = [np.array([0, 0, 0, 5.0, 0, 0]), np.array([0, 0, 0, -5.0, 0, 0])]
    np.testing.assert_allclose(internal_wrenches(squeeze, offsets, [0.3, 0.7]), squeeze, atol=1e-15)


@pytest.fixture(scope="module")
def bench(request) -> ModuleType:
    """benchmarks/load_sharing.py: the transports that `make bench` measures."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(request.config.rootpath / "benchmarks")
        import load_sharing

        return load_sharing


@pytest.fixture(scope="module")
def carried(bench):
    """carried(shares, motion): samples of a simulated transport, made once."""
    motions = {motion.name: motion for motion in bench.MOTIONS}
    return functools.cache(lambda shares, name: bench.carry(shares, motions[name], every=0.2))


TEAMS = [(0.5, 0.5), (0.2, 0.8), (2 / 9, 4 / 9, 3 / 9)]


@pytest.mark.parametrize("shares", TEAMS)
def test_at_rest_each_agent_bears_its_share(carried, shares):
    for sample in carried(shares, "at rest"):
        for f, c in zip(sample.f, shares, strict=True):
            # measured to 1e-5 N; grasps and headings are off by some 1e-5 m and rad, which matters as much
            np.testing.assert_allclose(f[3:], c * body_gravity(MASS)[3:], atol=1e-4)


@pytest.mark.parametrize("shares", TEAMS)
def test_at_constant_velocity_each_agent_bears_its_share(bench, carried, shares):
    row = bench.evaluate(carried(shares, "cruising"), shares, shares="", motion="")
    assert row.speed > 1.0
    np.testing.assert_allclose(row.of_object, shares, atol=1e-3)  # exp(-7 s^-1 * 4 s) is nothing; the weld gives way
    assert row.internal_force < 1e-3  # [N], of 4.9


@pytest.mark.parametrize("shares", TEAMS)
def test_accelerating_each_agent_adds_what_it_needs_itself(bench, carried, shares):
    """f = J_O^-T c F_O - (M vdot + C v), (1b): measured on both sides. The plant's step is of first order in dt, and
    accelerations change by some 10 m/s^3 * 5 ms, of a few kg, less what welds keep: 2e-3 N were measured."""
    row = bench.evaluate(carried(shares, "accelerating"), shares, shares="", motion="")
    assert row.law_error < 5e-3
    assert row.error_percent < 0.5
    np.testing.assert_allclose(row.of_team, shares, atol=5e-4)
    assert np.abs(np.subtract(row.of_object, shares)).max() > 0.01  # so the load itself is not shared by c meanwhile
    assert row.internal_force > 1.0  # and the agents squeeze it


@pytest.mark.parametrize("motion", ["at rest", "cruising", "accelerating"])
def test_wrenches_at_the_wrists_move_the_object(carried, motion):
    """An oracle for the measurement: G^T f is what Newton and Euler ask for the crate's motion (2b), (6)."""
    for sample in carried(TEAMS[2], motion):
        crate = object_dynamics(MASS, INERTIA, sample.R_WO, sample.V_WO[:3])
        expected = crate.wrench(sample.A_WO, sample.V_WO)
        measured = grasp_matrix(sample.offsets).T @ np.concatenate(sample.f)
        # The solver stops at 1e-5 of the momenta that the commanded 25 N make; at constant velocity it need not start.
        np.testing.assert_allclose(measured[3:], expected[3:], atol=5e-4)
        np.testing.assert_allclose(measured[:3], expected[:3], atol=1e-3)  # welds give way by 1e-5 m


@pytest.mark.parametrize("shares", TEAMS)
def test_coupled_dynamics_hold_on_transports_by_arms_of_four_joints(carried, shares):
    """(7) along all twists that the team can make; of those it cannot make, structure takes care."""
    moved = 0.0
    for sample in carried(shares, "accelerating"):
        E = admissible_twists([joint.J for joint in sample.joint], sample.offsets, tolerance=1e-3)
        assert E.shape == (6, 3)  # arms of different headings: translations
        team = [task_dynamics(joint) for joint in sample.joint]
        crate = object_dynamics(MASS, INERTIA, sample.R_WO, sample.V_WO[:3])
        coupled = coupled_dynamics(crate, team, sample.offsets, sample.V_WO[:3])
        u = [
            wrench_at_gripper(c * sample.F_O, p) + agent.g
            for c, p, agent in zip(shares, sample.offsets, team, strict=True)
        ]
        residual = coupled.wrench(sample.A_WO, sample.V_WO) - grasp_matrix(sample.offsets).T @ np.concatenate(u)
        np.testing.assert_allclose(E.T @ residual, 0.0, atol=5e-3)  # of first order in dt, as above
        moved = max(moved, np.abs(E.T @ coupled.M @ sample.A_WO).max())
    assert moved > 5.0


@pytest.mark.parametrize("joints", [(6, 6), (7, 6), (7, 7, 6)])
def test_arms_of_six_and_more_joints_share_torques_as_well(transport, joints):
    """(1b) of each member, all six components: u - f = M vdot + C v + g + h, f measured at its last joint."""
    power = (1.0, 3.0, 2.0)[: len(joints)]

    def worst(dt: float) -> float:
        return max(
            np.abs(member_residual(sample, i)).max()
            for sample in transport(joints, power, dt, 0.3, 0.02)
            for i in range(len(joints))
        )

    fine = worst(5e-4)
    assert fine < 0.05  # of wrenches up to 7 N; first order in dt, as the next line shows
    assert fine < 0.4 * worst(2e-3)


def member_residual(sample, i: int) -> np.ndarray:
    p, w = sample.offsets[i], sample.V_WO[:3]
    J_O, J_O_dot = object_to_agent_jacobian(p), object_to_agent_jacobian_rate(p, w)
    left = task_dynamics(sample.joint[i]).wrench(J_O @ sample.A_WO + J_O_dot @ sample.V_WO, J_O @ sample.V_WO)
    return left + sample.idle[i] + sample.f[i] - sample.u[i]
