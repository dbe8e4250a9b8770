"""The paper's Euler angles against Drake's, and against the rotation-matrix form that the controllers use."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.autodiffutils import ExtractGradient, InitializeAutoDiff
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw, RotationMatrix
from scipy.spatial.transform import Rotation

from drake_ltl.dynamics import (
    angular_velocity_map,
    euler_from_rotation,
    euler_mismatch,
    euler_rate_map,
    heading_difference,
    is_representation_singular,
    quaternion_difference,
    representation_jacobian,
    rotation_from_euler,
    rotation_mismatch,
)
from drake_ltl.systems.field_value import ROTATION_WEIGHT, rotation_error

turn = st.floats(-3.1, 3.1)
tilt = st.floats(-1.5, 1.5)  # 0.07 rad off the singularity: the map grows to 14
angles = st.tuples(turn, tilt, turn).map(np.array)
any_angles = st.tuples(turn, turn, turn).map(np.array)
SINGULAR = [np.array([0.4, sign * np.pi / 2, -1.1]) for sign in (1.0, -1.0)]

UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


def quaternion(R: np.ndarray) -> np.ndarray:
    return RotationMatrix(R).ToQuaternion().wxyz()


@given(any_angles)
def test_rotation_is_that_of_extrinsic_angles(eta):
    np.testing.assert_allclose(rotation_from_euler(eta), RollPitchYaw(eta).ToRotationMatrix().matrix(), atol=1e-14)
    np.testing.assert_allclose(rotation_from_euler(eta), Rotation.from_euler("xyz", eta).as_matrix(), atol=1e-14)


@given(angles)
def test_angles_come_back(eta):
    np.testing.assert_allclose(euler_from_rotation(rotation_from_euler(eta)), eta, atol=1e-12)


@given(any_angles)
def test_angles_describe_their_rotation(eta):
    """Beyond |pitch| = pi/2 there are others that describe the same."""
    R = rotation_from_euler(eta)
    np.testing.assert_allclose(rotation_from_euler(euler_from_rotation(R)), R, atol=1e-6)  # SINGULAR_COSINE is 1e-6


@pytest.mark.parametrize("eta", SINGULAR)
def test_at_the_singularity_roll_goes_to_yaw(eta):
    R = rotation_from_euler(eta)
    found = euler_from_rotation(R)
    assert found[0] == 0.0
    assert abs(found[1]) == pytest.approx(np.pi / 2)
    np.testing.assert_allclose(rotation_from_euler(found), R, atol=1e-12)


@given(angles)
def test_rates_are_drake_s(eta):
    rpy = RollPitchYaw(eta)
    rates = np.array([0.3, -0.7, 0.5])
    w = angular_velocity_map(eta) @ rates
    np.testing.assert_allclose(w, rpy.CalcAngularVelocityInParentFromRpyDt(rates), atol=1e-12)
    np.testing.assert_allclose(euler_rate_map(eta) @ w, rates, atol=1e-10)
    assert np.linalg.det(angular_velocity_map(eta)) == pytest.approx(np.cos(eta[1]), abs=1e-12)


@given(angles)
def test_the_representation_jacobian_conserves_power(eta):
    """(2a) and (10b): grad . d(eta; p)/dt = (J^T grad) . v."""
    v, gradient = np.arange(1.0, 7.0), np.array([0.5, -1.0, 2.0, 1.0, 3.0, -2.0])
    jacobian = representation_jacobian(eta)
    np.testing.assert_array_equal((jacobian @ v)[3:], v[3:])
    assert gradient @ (jacobian @ v) == pytest.approx((jacobian.T @ gradient) @ v, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("eta", SINGULAR)
def test_the_singularity_is_detected(eta):
    assert is_representation_singular(eta)
    for function in (euler_rate_map, representation_jacobian, lambda e: euler_mismatch(e, np.zeros(3))):
        with pytest.raises(ValueError, match=r"representation singularity: pitch is -?1\.57"):
            function(eta)


@given(angles)
def test_elsewhere_there_is_none(eta):
    assert not is_representation_singular(eta)


@given(angles, any_angles)
def test_gradients_of_both_forms_map_to_each_other(eta, eta_goal):
    """E^-T takes the gradient by Euler angles of the rotation mismatch to its slope along omega: one law, two forms."""
    R_goal = rotation_from_euler(eta_goal)
    value, _ = rotation_mismatch(rotation_from_euler(InitializeAutoDiff(eta).ravel()), R_goal)
    by_eta = ExtractGradient(np.array([[value]])).ravel()
    _, slope = rotation_mismatch(rotation_from_euler(eta), R_goal)
    np.testing.assert_allclose(euler_rate_map(eta).T @ by_eta, slope, atol=1e-11)  # the map is at most 14


@given(angles, angles)
def test_slope_of_the_euler_form_is_its_derivative(eta, eta_goal):
    value, _ = euler_mismatch(eta, eta_goal)
    difference = np.abs(np.abs(eta - eta_goal) - np.pi)
    if difference.min() > 1e-3:  # half a turn away there are two short ways round
        _, slope = euler_mismatch(eta, eta_goal)
        w, h = np.array([0.6, -0.3, 0.7]), 1e-6
        moved = [
            euler_from_rotation(Rotation.from_rotvec(s * w).as_matrix() @ rotation_from_euler(eta)) for s in (h, -h)
        ]
        ahead, behind = (euler_mismatch(m, eta_goal)[0] for m in moved)
        assert slope @ w == pytest.approx((ahead - behind) / (2.0 * h), abs=1e-5 * (1.0 + value))


@given(angles)
def test_both_forms_have_the_same_equilibrium(eta):
    """The slopes vanish at the goal; elsewhere neither does, but for half turns of the rotation form."""
    R = rotation_from_euler(eta)
    for value, slope in (euler_mismatch(eta, eta), rotation_mismatch(R, R)):
        assert value == pytest.approx(0.0, abs=1e-14)
        np.testing.assert_allclose(slope, 0.0, atol=1e-14)
    value, slope = rotation_mismatch(R, np.eye(3))
    assert slope @ slope == pytest.approx(value * (4.0 - value), abs=1e-9)  # 2 sin angle, angle from 2 (1 - cos angle)
    euler, euler_slope = euler_mismatch(eta, np.zeros(3))
    assert np.linalg.norm(euler_slope) >= np.sqrt(euler)  # E has norm sqrt 2 at most, and the slope is 2 E^-T eta


def test_both_forms_agree_to_first_order_about_upright():
    rng = np.random.default_rng(0)
    for _ in range(20):
        eta = rng.uniform(-1e-3, 1e-3, 3)
        (euler, slope), (rotation, slope_R) = (
            euler_mismatch(eta, np.zeros(3)),
            rotation_mismatch(rotation_from_euler(eta), np.eye(3)),
        )
        assert rotation == pytest.approx(euler, abs=4e-9)  # third order
        np.testing.assert_allclose(slope_R, slope, atol=4e-6)  # second order


@given(any_angles, any_angles, st.floats(0.5, 2.0))
def test_the_controllers_form_is_the_rotation_form(eta, eta_goal, length):
    """... of quaternions of any length."""
    R, R_goal = rotation_from_euler(eta), rotation_from_euler(eta_goal)
    value, slope = rotation_mismatch(R, R_goal)
    theirs, theirs_slope = rotation_error(length * quaternion(R), quaternion(R_goal) / length)
    assert theirs == pytest.approx(ROTATION_WEIGHT * value, abs=1e-12)
    np.testing.assert_allclose(theirs_slope, ROTATION_WEIGHT * slope, atol=1e-12)


@given(any_angles, any_angles)
def test_differences_of_quaternions_are_those_of_rotations(eta, eta_other):
    R, other = rotation_from_euler(eta), rotation_from_euler(eta_other)
    found = Rotation.from_quat(np.roll(quaternion_difference(quaternion(R), quaternion(other)), -1)).as_matrix()
    np.testing.assert_allclose(found, R @ other.T, atol=1e-12)


@given(turn, st.floats(0.0, 1.0), turn)
def test_headings_differ_whatever_the_tilt(yaw, tilt, axis):
    """A turn about the vertical after a tilt about any level axis is found as it is."""
    tilted = Rotation.from_rotvec(tilt * np.array([np.cos(axis), np.sin(axis), 0.0])).as_matrix()
    R = rotation_from_euler(np.array([0.0, 0.0, yaw])) @ tilted
    for sign in (1.0, -1.0):  # both stand for the same rotation
        assert heading_difference(sign * quaternion(R), quaternion(np.eye(3))) == pytest.approx(yaw, abs=1e-9)


@pytest.mark.parametrize("eta", SINGULAR)
def test_the_controllers_form_works_at_the_singularity(eta):
    """Finite, the derivative of its value, and downhill from there to upright."""
    R = rotation_from_euler(eta)
    _, slope = rotation_error(quaternion(R), UPRIGHT)
    w, h = np.array([0.6, -0.3, 0.7]), 1e-6
    ahead, behind = (
        rotation_error(quaternion(Rotation.from_rotvec(s * w).as_matrix() @ R), UPRIGHT)[0] for s in (h, -h)
    )
    assert slope @ w == pytest.approx((ahead - behind) / (2.0 * h), abs=1e-8)

    for _ in range(200):
        value, slope = rotation_error(quaternion(R), UPRIGHT)
        R = Rotation.from_rotvec(-0.1 * slope).as_matrix() @ R
        assert rotation_error(quaternion(R), UPRIGHT)[0] <= value
    assert rotation_error(quaternion(R), UPRIGHT)[0] < 1e-12


def test_the_representation_jacobian_carries_derivatives():
    eta, h = np.array([0.3, -0.9, 1.2]), 1e-6
    for function in (representation_jacobian, euler_rate_map, angular_velocity_map):
        slopes = ExtractGradient(function(InitializeAutoDiff(eta).ravel()).reshape(-1, 1))
        for k, e in enumerate(np.eye(3)):
            differences = (function(eta + h * e) - function(eta - h * e)) / (2.0 * h)
            np.testing.assert_allclose(slopes[:, k], differences.ravel(), atol=1e-8)  # rounding over h


def test_the_short_way_round_is_taken():
    value, slope = euler_mismatch(np.array([0.0, 0.0, 3.0]), np.array([0.0, 0.0, -3.0]))
    short = 6.0 - 2.0 * np.pi
    assert value == pytest.approx(short**2)
    np.testing.assert_allclose(slope, [0.0, 0.0, 2.0 * short], atol=1e-12)


def test_quaternions_are_drake_s():
    """The helper above means the same as the state of a free body."""
    R = rotation_from_euler(np.array([0.3, -0.2, 0.9]))
    np.testing.assert_allclose(RotationMatrix(Quaternion(quaternion(R))).matrix(), R, atol=1e-14)
