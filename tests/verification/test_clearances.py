"""Distances between bodies that move straight from sample to sample, against a fine grid."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from drake_ltl.verification.clearances import least_distance

FRACTIONS = np.linspace(0.0, 1.0, 2001)

ways = hnp.arrays(
    float, st.tuples(st.integers(1, 5), st.just(3)), elements=st.floats(-10, 10, allow_subnormal=False, width=32)
)


@given(ways)
def test_least_distance(way):
    least = least_distance(way)
    assert least.shape == (len(way),)
    assert np.isclose(least[-1], np.linalg.norm(way[-1]))
    for k in range(len(way) - 1):
        grid = way[k] + FRACTIONS[:, None] * (way[k + 1] - way[k])
        on_grid = np.linalg.norm(grid, axis=1).min()
        # the grid misses the closest point by at most half its spacing
        half = np.linalg.norm(way[k + 1] - way[k]) * 0.5 / 2000
        assert on_grid - half - 1e-9 <= least[k] <= on_grid + 1e-9
