"""What a robot that nobody can hold comes to, against motion in small steps."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from drake_ltl.execution.adrift import _leaving, _meeting

places = arrays(float, 2, elements=st.floats(-10.0, 10.0))
velocities = arrays(float, 2, elements=st.floats(-3.0, 3.0)).filter(lambda v: np.linalg.norm(v) > 0.1)
INSTANTS = np.linspace(0.0, 400.0, 40_001)[:, None]
STEP = 0.01 + 1e-9


@given(places, velocities, st.floats(0.5, 3.0))
def test_two_meet_when_the_first_small_step_brings_them_together(way, velocity, reach):
    assume(np.linalg.norm(way) > reach)
    distances = np.linalg.norm(way - INSTANTS * velocity, axis=1)
    assume(abs(distances.min() - reach) > 0.1)  # grazing falls between two steps
    near = distances <= reach
    expected = float(INSTANTS[np.argmax(near), 0]) if near.any() else math.inf
    found = _meeting(way, velocity, reach)
    assert found == expected or abs(found - expected) <= STEP


@given(places, velocities, st.floats(0.5, 15.0))
def test_the_border_is_reached_when_the_first_small_step_is_beyond(here, velocity, radius):
    assume(abs(np.linalg.norm(here) - radius) > 1e-6)  # rounding decides there
    beyond = np.linalg.norm(here + INSTANTS * velocity, axis=1) > radius
    expected = float(INSTANTS[np.argmax(beyond), 0]) if beyond.any() else math.inf
    assert abs(_leaving(here, velocity, radius) - expected) <= STEP
