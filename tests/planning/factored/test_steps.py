"""Steps of the factored transition system: those of the listed one, and crowds as brute force counts them."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_ltl.planning.acceptance import Clause
from drake_ltl.planning.automaton import Automaton
from drake_ltl.planning.factored.crowds import MOST_FORMATIONS, Crowd, crowds
from drake_ltl.planning.factored.identities import exchanged, follow
from drake_ltl.planning.factored.moves import all_moves
from drake_ltl.planning.factored.states import MergedStates
from drake_ltl.planning.factored.waves import WaveProduct, spread
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.power import sum_rule
from drake_ltl.planning.transition_system import form
from drake_ltl.planning.weights import lexicographic


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 4), st.integers(1, 4), st.integers(0, 10**6))
def test_least_ways_against_all_ways_to_say_who_goes_where(n_agents, n_options, seed):
    single = np.random.default_rng(seed).integers(0, 9, (2, n_options, n_options)).astype(float)
    single[single > 6] = np.inf
    crowd = Crowd(tuple(range(n_agents)), n_options)
    found = crowd.least_ways(single)
    assert found.shape == (2, crowd.size, crowd.size)
    for case in range(2):
        for i, before in enumerate(crowd.formations.tolist()):
            for k, after in enumerate(crowd.formations.tolist()):
                pairs = (zip(before, choice, strict=True) for choice in permutations(after))
                assert found[case, i, k] == min(sum(single[case, a, b] for a, b in way) for way in pairs)


def test_only_agents_that_nothing_tells_apart_form_crowds(make_scenario):
    agents = {"a1": (3.0, "G !pi1"), "a2": (3.0, "1"), "a3": (2.0, "1"), "a4": (3.0, "1"), "a5": (3.0, "1")}
    scenario = make_scenario(agents, {"o1": (2.0, "1")}, spec="F a5.pi2")
    groups = {crowd.agents for crowd in crowds(scenario, merge=True)}
    assert groups == {(0,), (1, 3), (2,), (4,)}
    assert {crowd.agents for crowd in crowds(scenario, merge=False)} == {(i,) for i in range(5)}


def test_large_crowds_are_taken_apart(make_scenario):
    scenario = make_scenario({f"a{i}": (1.0, "1") for i in range(20)}, {})
    found = crowds(scenario, merge=True)
    assert sorted(i for crowd in found for i in crowd.agents) == list(range(20))
    assert all(crowd.size <= MOST_FORMATIONS for crowd in found)


def small(make_scenario, n_agents, n_objects):
    agents = {f"a{i}": (1.0 + (i == 2), "1") for i in range(n_agents)}
    objects = {f"o{j}": (1.0 + j, "1") for j in range(n_objects)}
    return make_scenario(agents, objects, {f"r{k}": (k * (k + 1.0), 0.0, 0.0) for k in range(3)})


def factored(scenario, merge):
    """The product with an automaton that reads everything, and the greatest cost."""
    fits = published_fits(scenario.fits)
    states = MergedStates(scenario, fits, crowds(scenario, merge))
    largest = 36.0 * (len(scenario.agents) + len(scenario.objects))
    one, clause = np.zeros((1, 1), dtype=np.int64), Clause(frozenset({0}), frozenset())
    moves = all_moves(states, sum_rule(scenario), 1.0, largest)
    product = WaveProduct(moves, np.zeros(states.possible.shape, dtype=np.int64), Automaton(0, one, one + 1, (clause,)))
    return states, product, largest


@pytest.mark.parametrize(("n_agents", "n_objects"), [(0, 1), (1, 0), (2, 1), (3, 1), (2, 2)])
def test_each_step_is_one_of_the_list(make_scenario, n_agents, n_objects):
    """With nobody merged: the same states, transitions and weights, in both directions."""
    scenario = small(make_scenario, n_agents, n_objects)
    states, product, largest = factored(scenario, merge=False)
    system = form(scenario, published_fits(scenario.fits), sum_rule(scenario))
    assert states.n_possible == system.n_states
    number = [states.number(*pair) for pair in zip(system.options.tolist(), system.places.tolist(), strict=True)]
    weights = lexicographic(system.costs, system.actions, largest)
    for step, one_end, other in (
        (product.onwards, system.sources, system.targets),
        (product.backwards, system.targets, system.sources),
    ):
        listed = {}
        for a, b, weight in zip(one_end.tolist(), other.tolist(), weights.tolist(), strict=True):
            listed.setdefault(number[a], set()).add((number[b], weight))
        for node in number:
            found = step(np.array([node]), np.zeros(1), np.full(product.n_nodes, np.inf))
            assert set(zip(*(column.tolist() for column in found), strict=True)) == listed[node]


@pytest.mark.parametrize("width", [600.0, 1e9, np.inf])
def test_merged_distances_are_the_least_of_those_merged(make_scenario, width):
    scenario = small(make_scenario, 3, 2)
    merged, product, _ = factored(scenario, merge=True)
    single, alone, _ = factored(scenario, merge=False)
    assert merged.n_possible == single.n_possible
    assert merged.n_states < single.n_states
    start = [0, 1, 0], [1, 2]
    below = np.full(alone.n_nodes, np.inf)
    offsets = np.full(alone.n_nodes, np.inf)
    offsets[single.number(*start)] = 0.0
    least = {}
    for state, distance in enumerate(spread(alone.onwards, offsets, below, width).tolist()):
        place, formation = divmod(state, single.n_formations)
        if single.possible[place, formation]:
            number = merged.number(single.options[formation].tolist(), single.places[place].tolist())
            least[number] = min(distance, least.get(number, np.inf))
    offsets = np.full(product.n_nodes, np.inf)
    offsets[merged.number(*start)] = 0.0
    found = spread(product.onwards, offsets, np.full(product.n_nodes, np.inf), width)
    assert {state: found[state] for state in least} == least
    assert len(least) == merged.possible.sum()


def test_who_is_who(make_scenario):
    """a0 and a1 are merged. Both are in r0, then one in each region, then both in r1."""
    scenario = make_scenario(
        {"a0": (1.0, "1"), "a1": (1.0, "1")}, {}, {f"r{k}": (float(k), 0.0, 0.0) for k in range(2)}
    )
    states, product, _ = factored(scenario, merge=True)
    numbers = [states.number(row, []) for row in ([0, 0], [0, 1], [1, 1], [0, 1], [0, 0])]
    rows = follow(product.moves, numbers, [0, 0], closed=True)
    assert [sorted(row) for row in rows] == [[0, 0], [0, 1], [1, 1], [0, 1], [0, 0]]
    assert rows[0] == rows[-1] == [0, 0]
    assert follow(product.moves, numbers[1:4:2], [1, 0], closed=True) == [[1, 0], [1, 0]]
    assert exchanged(states, [[0, 1], [1, 1]], [1, 0]) == [[1, 0], [1, 1]]
    # in a single step the two cannot change places at the cost of staying
    assert follow(product.moves, [numbers[1]] * 2, [1, 0]) == [[1, 0], [1, 0]]


def test_agents_that_end_as_each_other_close_no_loop(make_scenario):
    """One takes the other's place in the first step; nobody goes back on the way from r2 by r3."""
    centres = {"r0": (0.0, 0.0, 0.0), "r1": (1.0, 0.0, 0.0), "r2": (2.0, 0.0, 0.0), "r3": (1.0, 3.0, 0.0)}
    scenario = make_scenario({"a0": (1.0, "1"), "a1": (1.0, "1")}, {}, centres)
    states, product, _ = factored(scenario, merge=True)
    numbers = [states.number(row, []) for row in ([0, 1], [1, 2], [1, 3], [0, 1])]
    assert follow(product.moves, numbers, [0, 1]) == [[0, 1], [1, 2], [1, 3], [1, 0]]
    assert follow(product.moves, numbers, [0, 1], closed=True) is None
