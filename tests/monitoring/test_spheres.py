"""Rules for spheres against loops over all members, on a step in which everything happens."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from drake_ltl.monitoring.duties import Members, duties, expected_start, regions_of
from drake_ltl.monitoring.spheres import apart, arrived, forbidden, staying, workspace
from drake_ltl.scenario.model import Agent, Region, Scenario, TransportObject

NAMES = ("a1", "a2", "a3", "a4", "o1", "o2")
REGIONS = (Region("west", (-5.0, 0.0, 0.0), 2.0), Region("east", (5.0, 0.0, 0.0), 2.0), Region("north", (0, 6, 0), 2.0))
MEMBERS = Members(
    NAMES[:4], NAMES[4:], {"a1": 0.5, "a2": 0.6, "a3": 0.7, "a4": 0.4}, {"o1": 0.3, "o2": 0.2}, {"o1": 1.5, "o2": 1.0}
)
RADII = MEMBERS.agent_radius | MEMBERS.object_radius
CENTRES = np.array([[-5, 1, 0], [-5, -1, 0], [5, 0, 0], [0, 6, 0], [-5, 0, 0], [0, 5, 0]], dtype=float)
FEW = settings(max_examples=30)
ANYWHERE = arrays(float, (6, 3), elements=st.floats(-9.0, 9.0, width=16))


def action(kind: str, agents: tuple[str, ...], start: str, goal: str, obj: str | None = None) -> dict:
    return {"kind": kind, "agents": agents, "object": obj, "from": start, "to": goal}


STEPS = (
    (action("grasp", ("a1",), "west", "west", "o1"), action("grasp", ("a2",), "west", "west", "o1")),
    (
        action("transport", ("a1", "a2"), "west", "east", "o1"),
        action("travel", ("a3",), "east", "west"),
        action("grasp", ("a4",), "north", "north", "o2"),
    ),
)


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return Scenario(
        "drawn",
        8.0,
        REGIONS,
        tuple(Agent(name, "no model", (0.0, 0.0), heading=0.0, power=1.0) for name in MEMBERS.agents),
        tuple(TransportObject(name, "no model", (0.0, 0.0), power_needed=1.0) for name in MEMBERS.objects),
    )


@pytest.fixture(scope="module")
def duty(scenario):
    """Of the second step: a1 and a2 carry o1 from west to east, a3 travels from east to west, a4 grasps o2 in north."""
    return duties(expected_start(MEMBERS, scenario, CENTRES), STEPS)[1]


def who(rule, centres) -> set[tuple[str, ...]]:
    return {finding.who for finding in rule.findings(centres)}


def gap(centres, a: str, b: str, radii: dict[str, float]) -> float:
    return float(np.linalg.norm(centres[NAMES.index(a)] - centres[NAMES.index(b)])) - radii[a] - radii[b]


@FEW
@given(ANYWHERE)
def test_clearances(duty, centres):
    """The team is one ball about o1; its agents are kept apart as agents; a4 may touch o2."""
    radii = RADII | {"o1": 1.5}
    pairs = [*combinations(("a3", "a4", "o2", "o1"), 2), ("a1", "a2")]
    wanted = {pair for pair in pairs if pair != ("a4", "o2") and gap(centres, *pair, radii) <= 0.0}
    assert who(apart(duty, MEMBERS), centres) == wanted


@FEW
@given(ANYWHERE)
def test_forbidden_regions(duty, scenario, centres):
    wanted = {
        (name, "north")
        for name, radius in (("a3", 0.7), ("o1", 1.5))
        if np.linalg.norm(centres[NAMES.index(name)] - [0, 6, 0]) <= radius + 2.0
    }
    assert who(forbidden(duty, MEMBERS, scenario), centres) == wanted


@FEW
@given(ANYWHERE)
def test_workspace(duty, scenario, centres):
    radii = RADII | {"o1": 1.5}
    balls = ("a3", "a4", "o1", "o2")
    out = {name: np.linalg.norm(centres[NAMES.index(name)]) + radii[name] - 8.0 for name in balls}
    found = who(workspace(duty, MEMBERS, scenario), centres)
    assert found == {(name,) for name, beyond in out.items() if beyond > 1e-9}  # what rounding explains


@FEW
@given(ANYWHERE)
def test_who_stays_and_who_has_arrived(duty, scenario, centres):
    places = {"a4": "north", "o2": "north", "a1": "east", "a2": "east", "o1": "east", "a3": "west"}
    ball = {region.name: region for region in REGIONS}
    out = {
        (name, place)
        for name, place in places.items()
        if np.linalg.norm(centres[NAMES.index(name)] - ball[place].centre) + RADII[name] - 2.0 > 1e-9
    }
    stays = {pair for pair in out if pair[0] in ("a4", "o2")}
    assert who(staying(duty, MEMBERS, scenario), centres) == stays
    assert who(arrived(duty, MEMBERS, scenario), centres) == out - stays


def test_values_and_words(duty, scenario):
    centres = CENTRES.copy()
    centres[2] = centres[4] + [2.0, 0.0, 0.0]
    (finding,) = apart(duty, MEMBERS).findings(centres)
    assert (finding.who, finding.what) == (("a3", "o1"), "a3 and o1 with a1 and a2 overlap")
    assert finding.value == pytest.approx(2.0 - 0.7 - 1.5)
    assert (finding.limit, finding.unit) == (0.0, "m")


def test_at_rest_nobody_moves_and_what_is_held_may_be_touched(duty):
    rest = duty.rest
    assert rest.roles.movers == ()
    assert ("a1", "o1") in rest.roles.exempt
    assert who(apart(rest, MEMBERS), CENTRES) == set()


def test_regions_are_read_off_spheres(scenario):
    centres = CENTRES.copy()
    centres[0] = [-5.0, 1.6, 0.0]  # the centre is inside, the sphere is not
    assert regions_of(MEMBERS, scenario, centres) == {
        "a1": None,
        "a2": "west",
        "a3": "east",
        "a4": "north",
        "o1": "west",
        "o2": "north",
    }
