"""The search against trying everything."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_ltl.planning.backjumping import Constraint, Cost, DeadEndError, Search


def _table(scope, array, step, text):
    """A constraint that holds where `array`, indexed by the values of the scope in order, does."""
    ordered = sorted(scope)
    return Constraint(frozenset(scope), lambda values: array[tuple(values[v] for v in ordered)], step, text)


@st.composite
def problems(draw):
    sizes = draw(st.lists(st.integers(1, 4), min_size=1, max_size=5))
    constraints = []
    for k in range(draw(st.integers(0, 8))):
        scope = draw(st.sets(st.integers(0, len(sizes) - 1), max_size=min(3, len(sizes))))
        shape = tuple(sizes[v] for v in sorted(scope))
        seed = draw(st.integers(0, 10_000))
        holds = np.random.default_rng(seed).random(shape) < draw(st.sampled_from([0.3, 0.6, 0.9]))
        constraints.append(_table(scope, np.where(holds, 1.0, -1.0), draw(st.integers(0, 5)), f"c{k}"))
    return sizes, constraints


@settings(max_examples=300, deadline=None)
@given(problems())
def test_a_solution_is_found_iff_there_is_one(problem):
    sizes, constraints = problem
    solutions = [
        values
        for values in itertools.product(*map(range, sizes))
        if all(float(c.slack(list(values))) >= 0.0 for c in constraints)
    ]
    search = Search(sizes, constraints, [])
    if solutions:
        assert tuple(search.solve()) in solutions
    else:
        with pytest.raises(DeadEndError) as caught:
            search.solve()
        assert set(caught.value.reasons) <= set(constraints)
        assert caught.value.reasons


@settings(max_examples=100, deadline=None)
@given(st.lists(st.floats(0.0, 10.0), min_size=2, max_size=6), st.integers(0, 100))
def test_a_lone_variable_gets_its_cheapest_value(prices, seed):
    allowed = np.where(np.random.default_rng(seed).random(len(prices)) < 0.7, 1.0, -1.0)
    allowed[0] = 1.0
    array = np.array(prices)
    cost = Cost(frozenset({0}), lambda values: array[values[0]])
    (value,) = Search([len(prices)], [_table({0}, allowed, 0, "allowed")], [cost]).solve()
    assert allowed[value] > 0.0
    assert prices[value] <= array[allowed > 0.0].min() + 1e-9


def test_spacing_decides_among_values_of_equal_cost():
    slack = np.array([0.1, 0.4, 0.3, 0.9])
    (value,) = Search([4], [_table({0}, slack, 0, "apart")], []).solve()
    assert value == 3


def test_the_reason_is_where_the_search_got_furthest():
    never = np.array([-1.0, -1.0])
    fine = _table({0}, np.array([1.0, -1.0]), 1, "early")
    late = _table({1}, never, 4, "late")
    with pytest.raises(DeadEndError, match="late") as caught:
        Search([2, 2], [late, fine], []).solve()
    assert caught.value.reasons[-1].step == 4
