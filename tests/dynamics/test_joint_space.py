"""B, N, g_q and Jdot of (1a): against AutoDiff's derivatives of the models, and Lemma 1 for B."""

from __future__ import annotations

import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd, ExtractGradient, ExtractValue, InitializeAutoDiff
from pydrake.multibody.tree import JacobianWrtVariable

from drake_ltl.dynamics import coriolis_matrix, frame_jacobian, frame_jacobian_rate, gravity_torque, inertia_matrix

JOINTS = (4, 5, 6, 7)
ROUNDING = 1e-10  # entries up to a few hundred, times 1e-16, in sums of some thousand terms


@pytest.fixture(params=JOINTS, ids=lambda n: f"{n} joints")
def arm(request, solo):
    return solo(request.param)


def states(n: int, count: int = 4):
    rng = np.random.default_rng(n)
    return [(rng.uniform(-1.5, 1.5, n), rng.uniform(-2.0, 2.0, n)) for _ in range(count)]


def at(arm, q, qd):
    context = arm.plant.CreateDefaultContext()
    arm.plant.SetPositionsAndVelocities(context, np.concatenate([q, qd]))
    return context


def differentiated(arm, q, qd=None):
    """An AutoDiff plant of the arm at q, with derivatives by q, or by time along qd."""
    plant = arm.plant.ToAutoDiffXd()
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, InitializeAutoDiff(q) if qd is None else along(q, qd))
    return plant, context


def along(q, qd):
    return np.array([AutoDiffXd(value, np.array([rate])) for value, rate in zip(q, qd, strict=True)])


def test_coriolis_matrix_has_christoffel_s_symbols(arm):
    for q, qd in states(arm.plant.num_positions()):
        n = len(q)
        plant, context = differentiated(arm, q)
        dB = ExtractGradient(plant.CalcMassMatrix(context).reshape(-1, 1)).reshape(n, n, n)  # dB_kj / dq_i at [k, j, i]
        symbols = 0.5 * (dB + dB.transpose(0, 2, 1) - dB.transpose(2, 1, 0))  # [k, j, i]
        np.testing.assert_allclose(coriolis_matrix(arm.plant, at(arm, q, qd)), symbols @ qd, atol=ROUNDING)


def test_coriolis_matrix_yields_drake_s_bias(arm):
    for q, qd in states(arm.plant.num_positions()):
        context = at(arm, q, qd)
        np.testing.assert_allclose(
            coriolis_matrix(arm.plant, context) @ qd, arm.plant.CalcBiasTerm(context), atol=ROUNDING
        )


def test_inertia_is_symmetric_and_positive_definite(arm):
    for q, qd in states(arm.plant.num_positions()):
        B = inertia_matrix(arm.plant, at(arm, q, qd))
        np.testing.assert_allclose(B, B.T, atol=ROUNDING)
        assert np.linalg.eigvalsh(B)[0] > 1e-4  # the least inertia of a joint: a wrist's, m r^2 / 2 = 2.5e-4


def test_rate_of_inertia_less_twice_coriolis_is_skew(arm):
    """Lemma 1 for B; with N of another factorisation, qd^T (Bdot - 2 N) qd = 0 would be all."""
    for q, qd in states(arm.plant.num_positions()):
        plant, context = differentiated(arm, q, qd)
        B = plant.CalcMassMatrix(context)
        Bdot = ExtractGradient(B.reshape(-1, 1)).reshape(B.shape)
        S = Bdot - 2.0 * coriolis_matrix(arm.plant, at(arm, q, qd))
        assert np.abs(S).max() > 1e-3  # there is something to be skew
        np.testing.assert_allclose(S, -S.T, atol=ROUNDING)


def test_jacobian_rate_is_that_of_autodiff(arm):
    for q, qd in states(arm.plant.num_positions()):
        plant, context = differentiated(arm, q, qd)
        frame, world = plant.get_frame(arm.frame.index()), plant.world_frame()
        J = plant.CalcJacobianSpatialVelocity(context, JacobianWrtVariable.kV, frame, np.zeros(3), world, world)
        expected = ExtractGradient(J.reshape(-1, 1)).reshape(J.shape)
        mine = at(arm, q, qd)
        np.testing.assert_allclose(frame_jacobian(arm.plant, mine, arm.frame), ExtractValue(J), atol=ROUNDING)
        np.testing.assert_allclose(frame_jacobian_rate(arm.plant, mine, arm.frame), expected, atol=ROUNDING)


def test_gravity_is_the_slope_of_potential_energy(arm):
    for q, _ in states(arm.plant.num_positions()):
        plant, context = differentiated(arm, q)
        slope = plant.CalcPotentialEnergy(context).derivatives()
        np.testing.assert_allclose(gravity_torque(arm.plant, at(arm, q, 0 * q)), slope, atol=ROUNDING)


def test_the_context_keeps_its_state(arm):
    q, qd = states(arm.plant.num_positions())[0]
    context = at(arm, q, qd)
    coriolis_matrix(arm.plant, context)
    frame_jacobian_rate(arm.plant, context, arm.frame)
    np.testing.assert_array_equal(arm.plant.GetPositionsAndVelocities(context), [*q, *qd])


def test_plants_of_autodiff_will_do(solo):
    """Values are those of doubles; derivatives by time along qd those of central differences."""
    arm = solo(6)
    q, qd = states(6)[0]
    plant, context = differentiated(arm, q, qd)
    plant.SetVelocities(context, along(qd, np.zeros(6)))
    frame = plant.get_frame(arm.frame.index())
    h = 1e-5
    for function, ends in (
        (lambda p, c, f: coriolis_matrix(p, c), "N"),
        (frame_jacobian_rate, "Jdot"),
    ):
        result = function(plant, context, frame)
        here, ahead, behind = (function(arm.plant, at(arm, q + s * qd, qd), arm.frame) for s in (0.0, h, -h))
        np.testing.assert_allclose(ExtractValue(result), here, atol=ROUNDING, err_msg=ends)
        slope = ExtractGradient(result.reshape(-1, 1)).reshape(here.shape)
        np.testing.assert_allclose(slope, (ahead - behind) / (2 * h), atol=1e-7, err_msg=ends)  # h^2 and 1e-16 / h
