"""Drives that can fail."""

from __future__ import annotations

import numpy as np
import pytest

from drake_ltl.systems.drives import Drives

LIMITS = {"a1": np.array([10.0, 20.0]), "a2": np.array([5.0])}


@pytest.mark.parametrize(
    ("share", "delivered"),
    [(1.0, [8.0, -20.0, 5.0]), (0.5, [5.0, -10.0, 5.0]), (0.0, [0.0, 0.0, 5.0])],
)
def test_torques_are_cut_off_at_what_is_left_of_the_limits(share, delivered):
    drives = Drives(LIMITS)
    context = drives.CreateDefaultContext()
    drives.get_torque_input_port().FixValue(context, [8.0, -30.0, 7.0])
    drives.SetShare(context, "a1", share)
    np.testing.assert_array_equal(drives.get_delivered_output_port().Eval(context), delivered)


def test_joints_without_drives_have_no_torque_however_little_is_left():
    """Of a wheeled base, all but the wheels."""
    drives = Drives({"a1": np.array([np.inf, 2.0])})
    context = drives.CreateDefaultContext()
    drives.get_torque_input_port().FixValue(context, [0.0, 1.0])
    drives.SetShare(context, "a1", 0.0)
    np.testing.assert_array_equal(drives.get_delivered_output_port().Eval(context), [0.0, 0.0])
