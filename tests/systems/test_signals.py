"""What is packed into signals comes out again."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from drake_ltl.systems.legs import ALL, Leg
from drake_ltl.systems.signals import (
    STEP_SIGNAL_SIZE,
    Mode,
    Phase,
    pack_reach,
    pack_step,
    reach_ends,
    unpack_step,
)

numbers = st.floats(-1e3, 1e3)
counts = st.integers(0, 10**6)
vias = st.none() | st.tuples(numbers, numbers)
legs = st.one_of(st.just(Leg()), st.builds(Leg, exchange=counts), st.builds(Leg, st.integers(0, 20), vias, counts))


@given(counts, st.sampled_from(Phase), counts, legs)
def test_steps(index, phase, interval, leg):
    signal = pack_step(index, phase, interval, leg)
    assert signal.shape == (STEP_SIGNAL_SIZE,)
    assert unpack_step(signal) == (index, phase, leg)


@given(counts, counts, counts)
def test_intervals_can_be_told_apart(index, first, second):
    """The field keeps what it has built for as long as the signal stays the same."""
    same = np.array_equal(*(pack_step(index, Phase.NAVIGATE, i, Leg(2, (1.0, 2.0))) for i in (first, second)))
    assert same == (first == second)


@given(st.integers(1, 9).flatmap(lambda n: st.tuples(*[arrays(float, n, elements=numbers)] * 2)), numbers, numbers)
def test_reaches(ends, start_time, duration):
    reach = pack_reach(start_time, duration, *ends)
    assert reach.shape == (2 + 2 * len(ends[0]),)
    assert tuple(reach[:2]) == (start_time, duration)
    for end, unpacked in zip(ends, reach_ends(reach), strict=True):
        np.testing.assert_array_equal(unpacked, end)


def test_numbers_that_recordings_carry():
    assert [int(mode) for mode in (Mode.HOLD, Mode.TRANSITION, Mode.REACH, Mode.TRANSPORT)] == [0, 1, 2, 3]
    assert ALL < 0  # no mover's index
