"""TS against the paper's counts, and against Def. 5 read clause by clause."""

from __future__ import annotations

import zlib
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_ltl.errors import InvalidInputError, SearchLimitError
from drake_ltl.planning.certificate import state_fault, transition_fault
from drake_ltl.planning.costs import sum_of_ways
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.plan import State
from drake_ltl.planning.power import sum_rule
from drake_ltl.planning.transition_system import form


@pytest.mark.parametrize(("case", "states", "transitions"), [("case_i", 560, 7680), ("case_ii", 3112, 160504)])
def test_the_cases_have_the_reproduced_counts(case, states, transitions, request):
    scenario, _ = request.getfixturevalue(case)
    system = form(scenario, published_fits(scenario.fits), sum_rule(scenario))
    assert (system.n_states, system.n_transitions) == (states, transitions)


def test_costs_are_squared_distances_summed_over_agents_and_objects(case_i):
    scenario, _ = case_i
    system = form(scenario, published_fits(scenario.fits), sum_rule(scenario))
    chi = sum_of_ways(scenario)
    for edge in range(0, system.n_transitions, 37):
        before, after = (system.state(int(end[edge])) for end in (system.sources, system.targets))
        assert system.costs[edge] == chi(before, after)
    both = State(("pi1", "pi1"), ("pi1", "pi2"), ("o1", "o1")), State(("pi3", "pi3"), ("pi3", "pi2"), ("o1", "o1"))
    assert chi(*both) == 3 * 500.0  # 20^2 + 10^2, three bodies


def test_states_and_indices_correspond(case_ii):
    scenario, start = case_ii
    system = form(scenario, published_fits(scenario.fits), sum_rule(scenario))
    assert [system.index(system.state(i)) for i in range(system.n_states)] == list(range(system.n_states))
    assert system.state(system.index(start)) == start
    apart = State(("pi1", "pi3", "pi4"), ("pi2", "pi1"), ("o1", None, None))
    assert system.index(apart) == -1
    with pytest.raises(InvalidInputError, match="pi9"):
        system.index(State(("pi9", "pi3", "pi4"), ("pi2", "pi1"), (None, None, None)))


@settings(deadline=None, max_examples=15)
@given(
    n_agents=st.integers(1, 2),
    n_objects=st.integers(0, 2),
    n_regions=st.integers(2, 3),
    salt=st.integers(0, 10**6),
    refusals=st.integers(0, 3),
)
def test_all_of_def_5_and_nothing_else(make_scenario, n_agents, n_objects, n_regions, salt, refusals):
    """Any predicate whatever for P_s and Lambda: the arrays agree with the clauses, pair by pair."""
    regions = [f"r{k}" for k in range(n_regions)]
    scenario = make_scenario(
        {f"a{i}": (1.0, "1") for i in range(n_agents)},
        {f"o{j}": (1.0, "1") for j in range(n_objects)},
        {name: (10.0 * k, 0.0, 0.0) for k, name in enumerate(regions)},
    )

    def drawn(*what):  # the same answer to the same question, whoever asks
        return zlib.crc32(repr((salt, what)).encode()) % 8 >= refusals

    def fits(region, content):
        bodies = (content.free_agents, content.objects, content.holds, sorted(content.carried))
        return drawn(region.name, *bodies)

    def can_carry(obj, team):
        return drawn(obj, sorted(team))

    agents = list(product(regions, repeat=n_agents))
    objects = list(product(regions, repeat=n_objects))
    grasps = list(product([None, *scenario.object_names], repeat=n_agents))
    everything = [State(*parts) for parts in product(agents, objects, grasps)]
    states = [state for state in everything if state_fault(scenario, state, fits) is None]
    system = form(scenario, fits, can_carry)
    assert {system.state(i) for i in range(system.n_states)} == set(states)
    ends = zip(system.sources.tolist(), system.targets.tolist(), strict=True)
    formed = [(system.state(before), system.state(after)) for before, after in ends]
    allowed = {pair for pair in product(states, repeat=2) if transition_fault(scenario, *pair, fits, can_carry) is None}
    assert len(formed) == len(set(formed))
    assert set(formed) == allowed
    assert np.all(np.diff(system.sources) >= 0)


def test_each_content_is_asked_once_per_region(case_ii):
    scenario, _ = case_ii
    asked = []
    rule = published_fits(scenario.fits)

    def fits(region, content):
        asked.append((region.name, content))
        return rule(region, content)

    form(scenario, fits, sum_rule(scenario))
    assert len(asked) == len(set(asked))


def test_without_leaves_out_transitions(case_i):
    scenario, start = case_i
    system = form(scenario, published_fits(scenario.fits), sum_rule(scenario))
    nonsense = State(("pi1", "pi3"), ("pi2", "pi1"), ("o1", None))
    fewer = system.without(frozenset({(start, start), (start, nonsense)}))
    assert fewer.n_transitions == system.n_transitions - 1
    index = system.index(start)
    assert not np.any((fewer.sources == index) & (fewer.targets == index))


@pytest.mark.parametrize("cost", [-1.0, float("nan"), float("inf")])
def test_a_cost_that_is_none_is_refused(case_i, cost):
    scenario, _ = case_i
    with pytest.raises(InvalidInputError, match="at least zero"):
        form(scenario, published_fits(scenario.fits), sum_rule(scenario), lambda before, after: cost)


def test_too_large_systems_are_refused_before_they_are_formed(make_scenario):
    scenario = make_scenario({f"a{i}": (1.0, "1") for i in range(12)}, {"o": (1.0, "1")})
    with pytest.raises(SearchLimitError, match="12 agents"):
        form(scenario, published_fits(scenario.fits), sum_rule(scenario))
