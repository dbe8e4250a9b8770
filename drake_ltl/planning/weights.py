"""Cost first, number of steps second, number of actions third, in one number that adds up exactly."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

ACTION_LIMIT = 1 << 9
STEP_LIMIT = 1 << 9
"""Lassos with fewer actions and steps than this are compared exactly as (cost, steps, actions)."""

COST_UNIT = ACTION_LIMIT * STEP_LIMIT
"""Weight of one quantum of cost."""

_SUM = 16
"""Sums up to this many times the largest cost are exact integers of double precision in any case."""


def lexicographic(
    costs: NDArray[np.float64], actions: NDArray[np.int64], largest: float | None = None
) -> NDArray[np.float64]:
    """Weights whose sums order paths by cost, then by number of steps, then by number of actions.

    A weight is `round(cost / quantum) * COST_UNIT + ACTION_LIMIT + actions`, an integer: sums of integers below
    2^53 are exact in double precision, whatever their order. So no cycle of zero cost is free, and equal costs
    are equal. The quantum is a power of ten, the finest that 2^53 allows: for costs up to 20000, five decimals are
    represented exactly, and what is finer is off by at most half a quantum a step.

    Args:
        costs: finite and at least zero, (E,).
        actions: how many agents act, (E,), each below ACTION_LIMIT.
        largest: determines the quantum, so that weights of different costs can be added; None takes the largest.
    """
    weights = in_units(costs, float(costs.max(initial=0.0)) if largest is None else largest)
    weights += ACTION_LIMIT
    weights += actions
    return weights


def in_units(costs: NDArray[np.float64], largest: float) -> NDArray[np.float64]:
    """`round(cost / quantum) * COST_UNIT`, the part of a weight that is due to the cost.

    Args:
        costs: of any shape.
        largest: no transition costs more; determines the quantum.
    """
    return _scaled(costs, _digits(largest)) * COST_UNIT if largest > 0.0 else np.zeros_like(costs)


def evened(costs: NDArray[np.float64], largest: float) -> NDArray[np.float64]:
    """Costs rounded so that the weight of a sum is the sum of the weights, and not only almost.

    Otherwise what is done in one step would not weigh the same as in two, and ties would be decided by rounding.

    Args:
        costs: of any shape.
        largest: no sum in question is greater; sums may still be weighted by factors up to ten.
    """
    if largest <= 0.0:
        return costs
    digits = _digits(largest) - 1
    return _scaled(costs, digits) / 10.0**digits if digits >= 0 else _scaled(costs, digits) * 10.0**-digits


def _digits(largest: float) -> int:
    """Decimals of a quantum, for costs up to `largest`."""
    return math.floor(math.log10(2.0**53 / COST_UNIT / _SUM / largest))


def _scaled(costs: NDArray[np.float64], digits: int) -> NDArray[np.float64]:
    scaled = costs * 10.0**digits if digits >= 0 else costs / 10.0**-digits
    return np.rint(scaled, out=scaled)
