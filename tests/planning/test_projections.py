"""A plan member by member: the same regions, grasps and letters, nothing lost."""

from __future__ import annotations

import json

import pytest

from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.plan import State
from drake_ltl.planning.planner import plan
from drake_ltl.planning.projections import Station, project, project_all, projections_to_json
from drake_ltl.planning.words import letter_of, satisfies


@pytest.fixture(scope="module")
def planned(case_ii):
    scenario, start = case_ii
    return plan(scenario, start, published_fits(scenario.fits)), scenario


def test_all_projections_together_are_the_plan(planned):
    found, scenario = planned
    ways = {projection.member: projection.prefix + projection.suffix for projection in project_all(found, scenario)}
    for step, state in enumerate(found.states):
        agents = [ways[name][step] for name in scenario.agent_names]
        objects = [ways[name][step] for name in scenario.object_names]
        held = tuple(station.grasps[0] if station.grasps else None for station in agents)
        assert State(tuple(s.region for s in agents), tuple(s.region for s in objects), held) == state
        for name, station in zip(scenario.object_names, objects, strict=True):
            holders = tuple(a for a, grasp in zip(scenario.agent_names, state.grasps, strict=True) if grasp == name)
            assert station.grasps == holders
        word = {f"{name}.{p}" for name, stations in ways.items() for p in stations[step].letter}
        assert word == letter_of(scenario, state)
    assert all(len(p.suffix) == len(found.suffix) for p in project_all(found, scenario))


def test_each_member_satisfies_its_own_formula_on_its_own_projection(planned):
    found, scenario = planned
    for member in (*scenario.agents, *scenario.objects):
        own = project(found, scenario, member.name)
        letters = [[station.letter for station in part] for part in (own.prefix, own.suffix)]
        assert satisfies(member.spec, *letters)


def test_text_and_services(make_scenario):
    services = {"a1": {"pi1": ("charge", "rest")}}
    scenario = make_scenario({"a1": (1.0, "F charge")}, {"o1": (1.0, "GF pi2 & GF pi1")}, services=services)
    found = plan(scenario, State(("pi1",), ("pi1",), (None,)), lambda region, content: True)
    assert str(project(found, scenario, "a1")) == "a1: pi1 (pi1[o1] pi2[o1])"
    assert str(project(found, scenario, "o1")) == "o1: pi1 (pi1[a1] pi2[a1])"
    assert project(found, scenario, "a1").prefix == (Station("pi1", (), frozenset({"charge", "rest"})),)


def test_json(planned):
    found, scenario = planned
    data = json.loads(json.dumps(projections_to_json(found, scenario), allow_nan=False))
    assert list(data["agents"]) == ["a1", "a2", "a3"]
    assert list(data["objects"]) == ["o1", "o2"]
    assert data["agents"]["a1"]["prefix"][0] == {"region": "pi1", "grasps": [], "letter": ["pi1"]}
    assert len(data["objects"]["o2"]["suffix"]) == len(found.suffix)
    assert {"region": "pi3", "grasps": ["a2", "a3"], "letter": ["pi3"]} in data["objects"]["o2"]["prefix"]


def test_unknown_members_are_named(planned):
    found, scenario = planned
    with pytest.raises(KeyError, match="'a9' is no agent or object; they are a1, a2, a3, o1, o2"):
        project(found, scenario, "a9")
