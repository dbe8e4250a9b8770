"""Plans without a list of transitions: the same cost, steps and actions as with one, on small random problems."""

from __future__ import annotations

import zlib

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from drake_ltl.errors import InfeasibleError
from drake_ltl.planning import models
from drake_ltl.planning.factored import loops
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.plan import State
from drake_ltl.planning.planner import plan
from drake_ltl.planning.power import sum_rule
from drake_ltl.planning.transition_system import form
from drake_ltl.scenario.model import PublishedFits

PUBLISHED = PublishedFits(agent=1.25, grasping=2.5, object=0.5, capacity=5.75)
CENTRES = st.lists(st.sampled_from([0.0, 0.0, 1.0, 2.0, 4.0]), min_size=2, max_size=3)
"""Of regions on a line; some in the same place, so that ways are free."""
ROOM = PublishedFits(agent=1.0, grasping=1.5, object=0.5, capacity=4.0)


@pytest.fixture(autouse=True)
def never_listed(monkeypatch):
    monkeypatch.setattr(models, "MOST_LISTED", -1)


def formulas(names, leaves=4):
    atoms = st.sampled_from(names).flatmap(lambda name: st.sampled_from([name, f"!{name}"]))
    return st.recursive(
        atoms,
        lambda inner: st.one_of(
            st.tuples(st.sampled_from(["X", "F", "G", "GF", "FG", "!"]), inner).map(lambda x: f"{x[0]}({x[1]})"),
            st.tuples(inner, st.sampled_from(["&", "|", "U", "R", "->"]), inner).map(
                lambda x: f"({x[0]}) {x[1]} ({x[2]})"
            ),
        ),
        max_leaves=leaves,
    )


def value(*arguments, **others):
    """(status, J, moves, actions) of a plan; None if there is none. J to ten digits: it is summed up in many orders."""
    try:
        found = plan(*arguments, **others)
    except InfeasibleError:
        return None
    return (
        found.status,
        float(f"{found.cost:.10g}"),
        len(found.moves),
        sum(len(a.agents) for move in found.moves for a in move),
    )


def assert_same(scenario, start, fits, **others):
    system = form(scenario, fits, sum_rule(scenario))
    listed = value(scenario, start, fits, system=system, **others)
    factored = value(scenario, start, fits, **others)
    if listed is not None and listed[0] == "optimal":
        assert factored == listed
    else:
        assert (listed is None) == (factored is None)


@settings(deadline=None, max_examples=120)
@given(data=st.data(), xs=CENTRES)
def test_teams_with_objects(make_scenario, data, xs):
    regions = [f"r{k}" for k in range(len(xs))]
    n_agents, n_objects = data.draw(st.sampled_from([(1, 0), (2, 0), (3, 0), (1, 1), (2, 1), (3, 1), (2, 2)]))
    own = st.one_of(st.just("1"), st.just("1"), formulas(regions, 3))
    agents = {f"a{i}": (data.draw(st.sampled_from([1.0, 1.0, 2.0])), data.draw(own)) for i in range(n_agents)}
    objects = {f"o{j}": (data.draw(st.sampled_from([1.0, 2.0])), data.draw(own)) for j in range(n_objects)}
    everything = [f"{member}.{region}" for member in (*agents, *objects) for region in regions]
    spec = data.draw(st.one_of(st.just("1"), formulas(everything, 4)))
    scenario = make_scenario(agents, objects, {r: (x, 0.0, 0.0) for r, x in zip(regions, xs, strict=True)}, spec)
    where = st.sampled_from(regions)
    start = State(*(tuple(data.draw(where) for _ in range(n)) for n in (n_agents, n_objects)), (None,) * n_agents)
    salt, refusals = data.draw(st.integers(0, 10**6)), data.draw(st.integers(0, 2))

    def picky(region, content):
        empty = not content.holds and not content.carried  # the start is possible
        return empty or zlib.crc32(repr((salt, region.name, content)).encode()) % 8 >= refusals

    fits = published_fits(ROOM) if data.draw(st.booleans()) else picky
    weight = st.sampled_from([0.0, 1.0, 1.0, 3.0])
    alpha, beta = data.draw(st.tuples(weight, weight))
    seen = [start] * data.draw(st.integers(0, 1))
    assert_same(scenario, start, fits, alpha=alpha, beta=beta, seen=seen)


@pytest.fixture(params=["merged", "labelled"])
def way_to_close(request):
    """Loops are looked for again with agents by name where they cannot be closed otherwise; here always."""
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "labelled":
            patch.setattr(loops, "_with_identities", lambda *_: None)
        yield request.param


@settings(deadline=None, max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    spec=formulas(["a0.r0", "a0.r1", "o0.r0", "o0.r1", "o1.r1"], 6),
    need=st.sampled_from([1.0, 2.0]),
    x=st.integers(0, 2),
)
@example(spec="GF o0.r0 & GF o0.r1 & GF o1.r0 & GF o1.r1", need=1.0, x=1)
@example(spec="G(o0.r0 -> X o0.r1) & G(o0.r1 -> X o0.r0) & G(o1.r0 -> X o1.r1) & G(o1.r1 -> X o1.r0)", need=1.0, x=1)
@example(spec="G(o0.r0 -> X o0.r1) & G(o0.r1 -> X X X o0.r0)", need=1.0, x=1)
@example(spec="FG a0.r1 & GF o0.r1 & GF o0.r0", need=1.0, x=1)
@example(spec="F a0.r1 & G !a0.r1", need=1.0, x=1)
def test_interchangeable_helpers(make_scenario, way_to_close, spec, need, x):
    """a0 is named; a1 and a2 are not."""
    agents = {"a0": (1.0, "1"), "a1": (1.0, "1"), "a2": (1.0, "1")}
    centres = {"r0": (0.0, 0.0, 0.0), "r1": (float(x), 0.0, 0.0)}
    scenario = make_scenario(agents, {"o0": (need, "1"), "o1": (1.0, "1")}, centres, spec)
    start = State(("r0", "r1", "r0"), ("r0", "r1"), (None, None, None))
    assert_same(scenario, start, published_fits(ROOM))


ERRANDS = ["1", "GF {}", "GF {} & GF {}", "G !{}", "F({} & F {})", "G({} -> F {}) & GF {}", "G({} -> X {}) & GF {}"]


@settings(deadline=None, max_examples=20)
@given(data=st.data(), cost=st.sampled_from(["squared_distance", "distance"]), room=st.sampled_from([PUBLISHED, ROOM]))
def test_errands_in_the_papers_regions(make_scenario, data, cost, room):
    """Ways of quite different lengths, and loops that meet some marks long before others."""
    regions = st.sampled_from(["pi1", "pi2", "pi3", "pi4"])
    errand = st.tuples(st.sampled_from(ERRANDS), regions, regions, regions).map(lambda x: x[0].format(*x[1:]))
    agents = {"a0": (3.0, data.draw(errand)), "a1": (3.0, "1"), "a2": (3.0, "1")}
    objects = {"o0": (data.draw(st.sampled_from([3.0, 5.0])), data.draw(errand))}
    start = State(*(tuple(data.draw(regions) for _ in range(n)) for n in (3, 1)), (None,) * 3)
    assert_same(make_scenario(agents, objects, cost=cost), start, published_fits(room))


def test_a_mark_is_met_early_and_the_way_back_is_short(make_scenario):
    """Close to the end of the loop the nearest edges with some marks are far away, those of the next round."""
    agents = {"a0": (3.0, "1"), "a1": (3.0, "G(pi2 -> X pi3) & GF pi2"), "a2": (3.0, "1")}
    objects = {"o0": (5.0, "GF pi3"), "o1": (5.0, "GF pi2")}
    scenario = make_scenario(agents, objects, spec="GF(a0.pi1 & o0.pi2)", cost="distance")
    start = State(("pi1", "pi4", "pi4"), ("pi3", "pi3"), (None,) * 3)
    assert value(scenario, start, published_fits(ROOM)) == ("optimal", pytest.approx(472.1629530239395), 8, 17)
