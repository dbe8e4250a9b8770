"""Phi as a controller asks for it, against the function for arrays."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_ltl.navigation import (
    Logarithmic,
    MoverPotential,
    NavigationFunction,
    PaperPhi,
    PseudoHuber,
    RegionBall,
    StaticBody,
    Transport,
    Traveller,
    step_relations,
)

STEP = step_relations(
    travellers=[Traveller("a1", 1.0, "here", "there", (-4.0, 1.0, 1.0), (4.0, 0.0, 1.0))],
    transports=[Transport("o1", ("a2",), 1.5, "there", "here", (5.0, 3.0, 0.3), (-5.0, -1.0, 0.3))],
    static_objects=[StaticBody("o2", 0.5, (0.0, 0.2, 0.3))],
    regions=[RegionBall("here", (-5.0, 0.0, 0.0), 3.0), RegionBall("there", (5.0, 0.0, 0.0), 3.0)],
    workspace_radius=10.0,
)
COORDINATE = st.floats(-11.0, 11.0)
POINT = st.tuples(COORDINATE, COORDINATE, st.floats(0.0, 2.0))


@dataclass(frozen=True)
class Own(PseudoHuber):
    """What a user might write: without a form for single numbers of its own."""

    def value(self, L):
        return 2.0 * super().value(L)

    def log_slope(self, L):
        return np.log(2.0) + super().log_slope(L)


def both(shaping, lambda_, gamma, p):
    function = NavigationFunction.for_goal(
        STEP.relations, STEP.goal, kappa=6.0, lambda_=lambda_, shaping=shaping, n_movers=STEP.n_movers
    )
    value, by_gamma, by_p = function.value_and_gradient(gamma, STEP.at(p))
    expected = (value, by_gamma, by_p[: STEP.n_movers])
    return MoverPotential(STEP, function).value_and_gradient(gamma, p.tolist()), expected


@pytest.mark.parametrize("shaping", [PseudoHuber(0.5), PseudoHuber(0.5, 0.8), Logarithmic(0.5), PaperPhi(6.0), Own()])
@pytest.mark.parametrize("lambda_", [0.0, 0.5])
@given(first=POINT, second=POINT, gamma=st.floats(0.0, 400.0))
def test_it_is_the_same_function(shaping, lambda_, first, second, gamma):
    """... where something touches as well. They differ by the rounding of sums in another order."""
    found, expected = both(shaping, lambda_, gamma, np.array([first, second]))
    for ours, theirs in zip(found, expected, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-11, atol=1e-14)


@pytest.mark.parametrize("gamma", [0.0, 1e-300, 1e300])
@pytest.mark.parametrize("scale", [1e-3, 1e160])
def test_extreme_numbers(gamma, scale):
    found, expected = both(PseudoHuber(0.5), 0.0, gamma, scale * np.array([[-4.0, 1.0, 1.0], [5.0, 3.0, 0.3]]))
    for ours, theirs in zip(found, expected, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-11)


def test_at_the_goal_it_vanishes():
    (value, by_gamma, by_p), _ = both(PseudoHuber(0.5), 0.0, 0.0, STEP.goal[:2])
    assert value == 0.0
    assert by_gamma == pytest.approx(1.0)  # 1 / (2 delta) for G measured against that at the goal
    assert not np.any(by_p)
