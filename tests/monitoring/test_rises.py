"""How far V rises."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_ltl.monitoring.rises import Fall


@settings(max_examples=30)
@given(st.lists(st.floats(0.0, 10.0), min_size=1, max_size=9))
def test_rises_are_those_above_the_lowest_value_so_far(values):
    fall = Fall((0, 0), values[0], values[0])
    for number, V in enumerate(values):
        fall = fall.to(V)
        above = V - min(values[: number + 1])
        wanted = 0.0 if above == 0.0 else np.inf if values[0] == 0.0 else above / values[0]
        assert fall.rise(V) == pytest.approx(wanted)
