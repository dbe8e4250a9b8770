"""Proximity functions: their formulas, their gradient, their invariances."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from drake_ltl.navigation import Apart, Inside, Label, Relations

RELATIONS = Relations(
    3,
    apart=(Apart(0, 1, 1.5, Label("agent-agent", ("a1", "a2"))), Apart(2, 0, 0.5)),
    inside=(Inside(1, (1.0, 0.0, -1.0), 9.0, Label("agent-workspace", ("a2",))),),
)


def test_betas_are_the_papers_formulas():
    p = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 1.0], [0.0, 2.0, 0.0]])

    np.testing.assert_allclose(RELATIONS.betas(p), [10.0 - 2.25, 4.0 - 0.25, 81.0 - 8.0], rtol=1e-15)


def test_a_whole_recording_gives_what_single_configurations_give():
    p = np.random.default_rng(0).normal(scale=5.0, size=(4, 7, 3, 3))

    betas, gradient = RELATIONS.betas(p), RELATIONS.log_product_gradient(p)

    assert betas.shape == (4, 7, 3)
    assert gradient.shape == p.shape
    np.testing.assert_allclose(betas[2, 3], RELATIONS.betas(p[2, 3]), rtol=1e-14)
    np.testing.assert_allclose(gradient[2, 3], RELATIONS.log_product_gradient(p[2, 3]), rtol=1e-14)


def test_gradient_of_the_logarithm_of_the_product_agrees_with_central_differences():
    p = np.array([[0.0, 0.0, 0.0], [3.0, 0.5, 1.0], [0.3, 2.0, 0.0]])
    step = 1e-6
    numeric = np.zeros_like(p)
    for index in np.ndindex(*p.shape):
        ahead, behind = p.copy(), p.copy()
        ahead[index] += step
        behind[index] -= step
        numeric[index] = np.log(RELATIONS.betas(ahead) / RELATIONS.betas(behind)).sum() / (2.0 * step)

    # Central differences of step 1e-6 are good to about eps / step = 2e-10 relative to values of order one.
    np.testing.assert_allclose(RELATIONS.log_product_gradient(p), numeric, atol=2e-9)


@given(
    shift=st.tuples(*[st.floats(-100.0, 100.0)] * 3),
    axis=st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    seed=st.integers(0, 1000),
)
def test_pairs_do_not_change_when_the_world_is_moved(shift, axis, seed):
    pairs = Relations(3, apart=RELATIONS.apart)
    p = np.random.default_rng(seed).normal(scale=3.0, size=(3, 3))
    R = Rotation.from_rotvec(axis).as_matrix()
    moved = p @ R.T + shift

    # Rounding of coordinates of 100 m (1e-14 m) times distances of about 10 m.
    np.testing.assert_allclose(pairs.betas(moved), pairs.betas(p), atol=1e-11)


@given(axis=st.tuples(*[st.floats(-3.0, 3.0)] * 3), seed=st.integers(0, 1000))
def test_a_ball_at_the_origin_is_the_same_from_all_sides(axis, seed):
    ball = Relations(2, inside=(Inside(0, (0.0, 0.0, 0.0), 30.0), Inside(1, (0.0, 0.0, 0.0), 28.0)))
    p = np.random.default_rng(seed).normal(scale=10.0, size=(2, 3))
    R = Rotation.from_rotvec(axis).as_matrix()

    # Rounding of squares of about 1e3 m^2.
    np.testing.assert_allclose(ball.betas(p @ R.T), ball.betas(p), atol=1e-11)


@pytest.mark.parametrize(
    ("p_a2", "names"),
    [([5.0, 0.0, 0.0], []), ([1.0, 0.0, 0.0], ["agent-agent"]), ([20.0, 0.0, 0.0], ["agent-workspace"])],
)
def test_violated_names_the_relations(p_a2, names):
    p = np.array([[0.0, 0.0, 0.0], p_a2, [9.0, 9.0, 9.0]])

    assert [label.kind for label in RELATIONS.violated(p)] == names


def test_violated_looks_at_all_of_a_recording_and_at_what_is_no_number():
    good = np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [9.0, 9.0, 9.0]])
    bad = good.copy()
    bad[1] = [1.0, 0.0, 0.0]

    (label,) = RELATIONS.violated(np.stack([good, bad, good]))
    assert str(label) == "a1 and a2 (agent-agent)"
    assert len(RELATIONS.violated(np.full((3, 3), np.nan))) == 3


def test_no_relations_at_all():
    nothing = Relations(2)
    p = np.zeros((5, 2, 3))

    assert nothing.betas(p).shape == (5, 0)
    assert not nothing.log_product_gradient(p).any()
    assert nothing.violated(p) == []
