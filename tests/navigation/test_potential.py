"""The navigation function against the paper's formula, AutoDiff and central differences; its limits."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.autodiffutils import ExtractGradient, InitializeAutoDiff
from pydrake.math import sqrt
from scipy.spatial.transform import Rotation

from drake_ltl.errors import InvalidInputError
from drake_ltl.navigation import (
    Apart,
    Inside,
    Label,
    Logarithmic,
    NavigationFunction,
    PaperPhi,
    PseudoHuber,
    Relations,
)

# Two movers (points 0 and 1), an obstacle (2), a workspace of 10 m.
RELATIONS = Relations(
    3,
    apart=(
        Apart(0, 1, 2.0, Label("agent-agent", ("a1", "a2"))),
        Apart(0, 2, 1.5, Label("agent-object", ("a1", "o1"))),
        Apart(1, 2, 1.5, Label("agent-object", ("a2", "o1"))),
    ),
    inside=tuple(Inside(a, (0.0, 0.0, 0.0), 9.0) for a in (0, 1)),
)
GOAL = np.array([[3.0, 0.0, 1.0], [-3.0, 0.0, 1.0], [0.0, 0.0, 0.3]])
START = np.array([[-4.0, 1.0, 1.0], [5.0, -2.0, 0.5], [0.0, 0.0, 0.3]])
SHAPINGS = [PseudoHuber(0.5), PseudoHuber(3.0, 0.7), Logarithmic(0.5), PaperPhi(2.0)]


def squared_error(p):
    return np.square(p - GOAL)[..., :2, :].sum(axis=(-2, -1))


def navigation(kappa=3.0, lambda_=0.0, shaping=SHAPINGS[0], relations=RELATIONS):
    return NavigationFunction.for_goal(relations, GOAL, kappa=kappa, lambda_=lambda_, shaping=shaping)


def total_gradient(nf, p):
    """Gradient of Phi(gamma(p), p) with respect to the movers (..., 2, 3)."""
    _, by_gamma, by_p = nf.value_and_gradient(squared_error(p), p)
    return (by_gamma[..., None, None] * 2.0 * (p - GOAL) + by_p)[..., :2, :]


def collision_free(seed):
    """A random configuration in which nothing touches."""
    rng = np.random.default_rng(seed)
    for _ in range(1000):
        p = np.concatenate([rng.uniform(-5.0, 5.0, size=(2, 3)), GOAL[2:]])
        if not RELATIONS.violated(p):
            return p
    raise AssertionError("hardly any configuration is free")


def paper_G(p, lambda_):
    """G as the paper writes it (h = 1), for numbers of any type, without logarithms."""
    betas = [sum((p[r.a] - p[r.b]) ** 2) - r.radius**2 for r in RELATIONS.apart]
    G = np.prod([r.radius**2 - sum(p[r.a] ** 2) for r in RELATIONS.inside])
    if lambda_ == 0.0:
        return G * np.prod(betas)
    for level in (1, 2, 3):
        b = [sum(chosen) for chosen in combinations(betas, level)]
        for j, b_j in enumerate(b):
            G = G * (b_j + lambda_ * b_j / (b_j + np.prod(b[:j] + b[j + 1 :])))
    return G


def paper_phi(p, kappa, lambda_):
    gamma = sum(((p - GOAL)[:2] ** 2).ravel())
    return gamma / (gamma**kappa + paper_G(p, lambda_) / paper_G(GOAL, lambda_)) ** (1.0 / kappa)


@pytest.mark.parametrize("lambda_", [0.0, 0.5])
@pytest.mark.parametrize("kappa", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("seed", range(4))
def test_phi_is_the_papers_formula(kappa, lambda_, seed):
    p = collision_free(seed)

    phi = navigation(kappa, lambda_).phi(squared_error(p), p)

    assert phi == pytest.approx(paper_phi(p, kappa, lambda_), rel=1e-12)


@pytest.mark.parametrize("lambda_", [0.0, 0.5])
@pytest.mark.parametrize("kappa", [0.7, 3.0])
@pytest.mark.parametrize("seed", range(3))
def test_gradient_of_phi_agrees_with_autodiff(kappa, lambda_, seed):
    p = collision_free(seed)
    (expected,) = ExtractGradient([[paper_phi(InitializeAutoDiff(p), kappa, lambda_)]])

    gradient = total_gradient(navigation(kappa, lambda_, PaperPhi(kappa)), p)

    # Near phi = 1 the two parts of the oracle's quotient rule, of order one, cancel to their rounding.
    np.testing.assert_allclose(gradient, _by_rows(expected)[:2], rtol=1e-10, atol=1e-14)


@pytest.mark.parametrize("lambda_", [0.0, 0.5])
def test_gradient_of_the_pseudo_huber_agrees_with_autodiff(lambda_):
    p, kappa, delta = collision_free(5), 3.0, 0.4
    x = InitializeAutoDiff(p)
    w = sum(((x - GOAL)[:2] ** 2).ravel()) / (paper_G(x, lambda_) / paper_G(GOAL, lambda_)) ** (1.0 / kappa)
    (expected,) = ExtractGradient([[delta * (sqrt(1.0 + w / delta**2) - 1.0)]])

    gradient = total_gradient(navigation(kappa, lambda_, PseudoHuber(delta)), p)

    np.testing.assert_allclose(gradient, _by_rows(expected)[:2], rtol=1e-10, atol=1e-11)


def _by_rows(gradient):
    """InitializeAutoDiff numbers the entries of a matrix column by column."""
    return gradient.reshape(3, 3).T


@pytest.mark.parametrize("shaping", SHAPINGS, ids=repr)
@pytest.mark.parametrize("lambda_", [0.0, 0.5])
@pytest.mark.parametrize("seed", range(3))
def test_gradient_agrees_with_central_differences(shaping, lambda_, seed):
    nf, p, step = navigation(3.0, lambda_, shaping), collision_free(seed), 1e-6
    numeric = np.zeros((2, 3))
    for index in np.ndindex(2, 3):
        ahead, behind = p.copy(), p.copy()
        ahead[index] += step
        behind[index] -= step
        rise = nf.value(squared_error(ahead), ahead) - nf.value(squared_error(behind), behind)
        numeric[index] = rise / (2.0 * step)

    # eps * value / step, for values of up to 20, and truncation of the order step^2.
    np.testing.assert_allclose(total_gradient(nf, p), numeric, atol=1e-8, rtol=1e-7)


@pytest.mark.parametrize("shaping", SHAPINGS, ids=repr)
@pytest.mark.parametrize("lambda_", [0.0, 0.5])
def test_value_with_gradient_is_the_value(shaping, lambda_):
    nf, p = navigation(3.0, lambda_, shaping), collision_free(0)

    assert nf.value_and_gradient(squared_error(p), p)[0] == pytest.approx(nf.value(squared_error(p), p), rel=1e-14)


@pytest.mark.parametrize("shaping", SHAPINGS, ids=repr)
def test_at_the_goal_value_and_gradient_are_zero_and_the_slope_is_that_of_the_bowl(shaping):
    value, by_gamma, by_p = navigation(shaping=shaping).value_and_gradient(0.0, GOAL)

    assert value == 0.0
    assert not by_p.any()
    # d Phi / d gamma = 1 / (2 delta) for the bowls; w itself for phi, since G = G_goal here.
    assert by_gamma == pytest.approx(0.5 / shaping.delta if hasattr(shaping, "delta") else 1.0, rel=1e-12)


@pytest.mark.parametrize("shaping", SHAPINGS, ids=repr)
def test_near_the_goal_small_errors_are_not_lost_to_cancellation(shaping):
    nf = navigation(shaping=shaping)
    at = [nf.value(gamma, GOAL) for gamma in (1e-20, 1e-18)]

    assert at[1] / at[0] == pytest.approx(100.0, rel=1e-9)


@given(seed=st.integers(0, 10_000), kappa=st.floats(0.5, 200.0), lambda_=st.sampled_from([0.0, 0.5]))
def test_phi_lies_between_zero_and_one_and_is_zero_only_at_the_goal(seed, kappa, lambda_):
    nf, p = navigation(kappa, lambda_), collision_free(seed)

    assert 0.0 < nf.phi(squared_error(p), p) <= 1.0
    assert nf.phi(squared_error(GOAL), GOAL) == 0.0


@pytest.mark.parametrize("kappa", [0.5, 2.0, 10.0])
def test_phi_rises_to_one_at_the_boundary_and_stays_there(kappa):
    nf = navigation(kappa)

    def phi(gap):
        p = START.copy()
        p[0] = GOAL[2] + [0.0, 1.5 + gap, 0.0]
        return nf.phi(squared_error(p), p)

    assert phi(1e-14) > 0.999
    assert phi(1e-14) >= phi(1e-6) >= phi(1e-2)
    assert phi(0.0) == phi(-0.5) == 1.0


@pytest.mark.parametrize("lambda_", [0.0, 0.5])
def test_all_psi_have_parallel_gradients_and_order_configurations_alike(lambda_):
    configurations = np.stack([collision_free(seed) for seed in range(40)])
    functions = [navigation(2.0, lambda_, shaping) for shaping in SHAPINGS]
    gradients = [total_gradient(nf, configurations).reshape(40, -1) for nf in functions]
    units = [gradient / np.linalg.norm(gradient, axis=-1, keepdims=True) for gradient in gradients]
    orders = [np.argsort(nf.value(squared_error(configurations), configurations)) for nf in functions]

    for unit, order in zip(units[1:], orders[1:], strict=True):
        np.testing.assert_allclose(unit, units[0], atol=1e-12)
        np.testing.assert_array_equal(order, orders[0])


@pytest.mark.parametrize("shaping", SHAPINGS, ids=repr)
@pytest.mark.parametrize("lambda_", [0.0, 0.5])
@pytest.mark.parametrize("kappa", [0.5, 10.0, 200.0])
@pytest.mark.parametrize("gap", [1e-12, 1e-3, 1.0])
def test_nothing_overflows(shaping, kappa, lambda_, gap):
    """Bodies 1e6 m away and almost touching; any warning is an error here."""
    far = Relations(3, RELATIONS.apart, tuple(Inside(a, (0.0, 0.0, 0.0), 3e6) for a in (0, 1)))
    goal = np.array([[1e6, 0.0, 0.0], [-1e6, 0.0, 0.0], [0.0, 1e6, 0.0]])
    p = np.array([[0.0, 0.0, 0.0], [2.0 + gap, 0.0, 0.0], [0.0, 1e6, 0.0]])
    nf = NavigationFunction.for_goal(far, goal, kappa=kappa, lambda_=lambda_, shaping=shaping)
    gamma = np.square(p - goal).sum()

    for result in (nf.phi(gamma, p), *nf.value_and_gradient(gamma, p), *nf.value_and_gradient(0.0, goal)):
        assert np.isfinite(result).all()


@pytest.mark.parametrize("shaping", SHAPINGS, ids=repr)
@pytest.mark.parametrize("lambda_", [0.0, 0.5])
@pytest.mark.parametrize("gap", [0.0, -0.5])
def test_a_violated_relation_has_the_largest_value_no_gradient_and_a_name(shaping, lambda_, gap):
    nf = navigation(3.0, lambda_, shaping)
    p = START.copy()
    p[0] = p[1] + [0.0, 2.0 + gap, 0.0]
    value, by_gamma, by_p = nf.value_and_gradient(squared_error(p), p)

    assert value == nf.value(squared_error(p), p) == shaping.supremum
    assert nf.log_G(p) == -np.inf
    assert np.isnan(by_gamma)
    assert np.isnan(by_p).all()
    assert [str(label) for label in nf.violated(p)] == ["a1 and a2 (agent-agent)"]


def test_two_violated_relations_do_not_cancel():
    p = np.array([GOAL[2], GOAL[2] + [0.1, 0.0, 0.0], GOAL[2]])  # three betas < 0: their product is negative
    p_even = np.array([GOAL[2], GOAL[2] + [1.55, 0.0, 0.0], GOAL[2]])  # two betas < 0: positive
    for touching in (p, p_even):
        assert navigation().value(squared_error(touching), touching) == np.inf


def test_a_recording_keeps_its_good_configurations():
    touching = START.copy()
    touching[0] = touching[1]
    p = np.stack([START, touching, GOAL])
    nf = navigation()
    value, by_gamma, by_p = nf.value_and_gradient(squared_error(p), p)

    assert value[1] == np.inf
    assert np.isnan(by_p[1]).all()
    for index in (0, 2):
        alone = nf.value_and_gradient(squared_error(p[index]), p[index])
        for batch, single in zip((value, by_gamma, by_p), alone, strict=True):
            np.testing.assert_allclose(batch[index], single, rtol=1e-13, atol=1e-15)


def test_a_position_that_is_no_number_is_not_hidden():
    p = START.copy()
    p[0, 0] = np.nan

    assert np.isnan(navigation().value_and_gradient(squared_error(p), p)[0])


@given(
    shift=st.tuples(*[st.floats(-50.0, 50.0)] * 3),
    axis=st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    lambda_=st.sampled_from([0.0, 0.5]),
)
def test_without_a_workspace_the_gradient_moves_with_the_world(shift, axis, lambda_):
    pairs = Relations(3, RELATIONS.apart)
    R = Rotation.from_rotvec(axis).as_matrix()
    gamma = squared_error(START)

    def gradient(p, goal):
        nf = NavigationFunction.for_goal(pairs, goal, kappa=3.0, lambda_=lambda_)
        value, _, by_p = nf.value_and_gradient(gamma, p)
        return value, by_p

    value, by_p = gradient(START, GOAL)
    moved_value, moved_by_p = gradient(START @ R.T + shift, GOAL @ R.T + shift)

    # Rounding of coordinates of 50 m against gaps of metres.
    assert moved_value == pytest.approx(value, rel=1e-11)
    np.testing.assert_allclose(moved_by_p, by_p @ R.T, atol=1e-11)


def test_the_unit_of_length_scales_w_alone_when_lambda_is_zero():
    def scaled(unit):
        apart = tuple(Apart(r.a, r.b, unit * r.radius) for r in RELATIONS.apart)
        inside = tuple(Inside(r.a, r.centre, unit * r.radius) for r in RELATIONS.inside)
        nf = NavigationFunction.for_goal(
            Relations(3, apart, inside), unit * GOAL, kappa=3.0, shaping=PseudoHuber(unit * 0.5)
        )
        return nf.value_and_gradient(unit**2 * squared_error(START), unit * START)

    metres, millimetres = scaled(1.0), scaled(1e3)

    assert millimetres[0] == pytest.approx(1e3 * metres[0], rel=1e-12)
    np.testing.assert_allclose(millimetres[2], metres[2], rtol=1e-11, atol=1e-14)


def test_a_goal_that_touches_something_is_refused_with_all_that_it_touches():
    goal = GOAL.copy()
    goal[0], goal[1] = [1.0, 0.0, 0.3], [2.5, 0.0, 0.3]

    with pytest.raises(InvalidInputError) as error:
        NavigationFunction.for_goal(RELATIONS, goal, kappa=3.0)

    assert [mistake.what for mistake in error.value.mistakes] == [
        "violates a1 and a2 (agent-agent)",
        "violates a1 and o1 (agent-object)",
    ]


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"kappa": 0.0}, "controller.kappa: is 0.0"),
        ({"kappa": float("inf")}, "controller.kappa"),
        ({"kappa": 1.0, "lambda_": -0.1}, "controller.lambda: is -0.1"),
        ({"kappa": 1.0, "lambda_": 1.0, "levels": 2}, "2 of 3 levels"),
        ({"kappa": 1.0, "lambda_": 1.0, "h": 0.0}, "controller.h"),
        ({"kappa": 1.0, "log_G_goal": -float("inf")}, "goal: touches"),
    ],
)
def test_what_cannot_be_used_is_refused_at_once(parameters, message):
    with pytest.raises(InvalidInputError, match=message):
        NavigationFunction(RELATIONS, **parameters)


FAR = st.sampled_from([0.0, 1e-300, 1e-160, 1e-9, 1.0, 1e9, 1e153, 1e160, 1.7e308])
SIGNED = st.builds(lambda size, sign: size * sign, FAR, st.sampled_from([-1.0, 1.0]))
LARGE = st.sampled_from([1e-300, 1e-9, 1.0, 1e9, 1e300])


@settings(deadline=None, max_examples=300)
@given(
    coordinates=st.lists(SIGNED, min_size=9, max_size=9),
    gamma=FAR,
    kappa=st.sampled_from([5e-324, 1e-300, 1e-9, 1.0, 1e9, 1e300, 1.7e308]),
    lambda_=st.sampled_from([0.0, 1e-300, 1.0, 1e300]),
    h=LARGE,
    log_G_goal=st.sampled_from([-1e300, 0.0, 1e300]),
    delta=LARGE,
    scale=LARGE,
)
def test_no_finite_input_overflows(coordinates, gamma, kappa, lambda_, h, log_G_goal, delta, scale):
    """Warnings are errors here. Results are numbers, or the supremum and nan where something touches."""
    apart = tuple(Apart(r.a, r.b, scale * r.radius) for r in RELATIONS.apart)
    inside = tuple(Inside(a, (0.0, 0.0, 0.0), 1.7e308) for a in (0, 1))
    p = np.reshape(coordinates, (3, 3))
    for shaping in (PseudoHuber(delta), Logarithmic(delta), PaperPhi(kappa)):
        nf = NavigationFunction(Relations(3, apart, inside), kappa, lambda_, h, log_G_goal, shaping)
        value, by_gamma, by_p = nf.value_and_gradient(gamma, p)

        assert not np.isnan(value)
        assert 0.0 <= nf.phi(gamma, p) <= 1.0
        if nf.violated(p):
            assert value == shaping.supremum
            assert np.isnan(by_gamma)
        else:
            assert np.isfinite(value)
            assert np.isfinite(by_gamma)
            assert np.isfinite(by_p).all()


@pytest.mark.parametrize("lambda_", [0.0, 0.5])
@pytest.mark.parametrize("shaping", SHAPINGS, ids=repr)
def test_the_careful_way_agrees_with_the_quick_one(lambda_, shaping):
    nf = navigation(3.0, lambda_, shaping)
    for seed in range(5):
        p = collision_free(seed)
        gamma = squared_error(p)
        for quick, careful in zip(nf.value_and_gradient(gamma, p), nf._with_care(gamma, p), strict=True):
            np.testing.assert_allclose(careful, quick, rtol=1e-11, atol=1e-14)


def test_lengths_whose_squares_overflow_are_felt_nevertheless():
    """Two points 1e200 m apart: beta = 1e400 m^2 is no floating point number, its logarithm is."""
    nf = NavigationFunction(Relations(2, (Apart(0, 1, 1.0),)), kappa=4.0, shaping=Logarithmic(1.0))
    p = np.array([[1e200, 0.0, 0.0], [0.0, 0.0, 0.0]])

    assert nf.log_G(p) == pytest.approx(400.0 * np.log(10.0))
    value, _, by_p = nf.value_and_gradient(1e300, p)
    assert value == pytest.approx(0.5 * (300.0 - 100.0) * np.log(10.0))
    # d psi / d log w = 1 / 2, d log w / dx = -2 / (kappa x).
    assert by_p[0, 0] == pytest.approx(-0.25e-200)


MOVING = 2


@given(seed=st.integers(0, 10_000), lambda_=st.sampled_from([0.0, 0.5]))
def test_leaving_out_impossible_sets_keeps_phi_in_its_range_and_the_gradient_right(seed, lambda_):
    nf = NavigationFunction.for_goal(RELATIONS, GOAL, kappa=3.0, lambda_=lambda_, n_movers=MOVING)
    p, step = collision_free(seed), 1e-6
    if np.min(RELATIONS.betas(p)) < 0.1:
        return  # steeper than these differences resolve
    by_p = nf.value_and_gradient(4.0, p)[2]
    for index in np.ndindex(MOVING, 3):
        ahead, behind = p.copy(), p.copy()
        ahead[index] += step
        behind[index] -= step
        numeric = (nf.value(4.0, ahead) - nf.value(4.0, behind)) / (2.0 * step)
        assert by_p[index] == pytest.approx(numeric, rel=1e-6, abs=1e-7)
    assert 0.0 < nf.phi(squared_error(p), p) < 1.0
