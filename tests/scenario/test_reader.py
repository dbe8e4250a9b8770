"""What scenario files mean, and what the reader says of each kind of mistake."""

from __future__ import annotations

import copy
import dataclasses
import math
from pathlib import Path
from typing import Any

import pytest
import yaml

from drake_ltl.errors import InvalidInputError
from drake_ltl.scenario import load, loads
from drake_ltl.scenario.faults import KINDS, Fault
from drake_ltl.scenario.model import PublishedFits, Scenario
from drake_ltl.scenario.reader import LARGEST_TOLERANCES

EXAMPLES = Path(__file__).parents[2] / "examples"


def put(data: dict[str, Any], path: str, value: Any) -> None:
    """Sets the entry at a key path such as `agents.a1.radius`."""
    *parents, last = path.split(".")
    for parent in parents:
        data = data.setdefault(parent, {})
    data[last] = value


def read(data: dict[str, Any]) -> Scenario:
    return loads(yaml.safe_dump(data, sort_keys=False))


def fault_entry(fault: Fault) -> dict[str, Any]:
    """As a file has it."""
    when = {"time": fault.time, "step": fault.step}
    entry = {"kind": fault.kind, KINDS[fault.kind].member: fault.who, **when, **fault.values}
    return {key: value for key, value in entry.items() if value is not None}


def dumped(scenario: Scenario) -> str:
    """A scenario file with every field written out."""
    data = dataclasses.asdict(scenario)
    for kind in ("regions", "agents", "objects"):
        data[kind] = {
            member.pop("name"): {key: value for key, value in member.items() if value is not None}
            for member in data[kind]
        }
    for agent in data["agents"].values():
        del agent["has_arm"]  # which its model says
    data["workspace"] = {"radius": data.pop("workspace_radius")}
    data["controller"]["lambda"] = data["controller"].pop("lambda_")
    del data["controller"]["kappa"]  # left out, it grows with the number of relations
    data["fits"] = data["fits"] or "geometric"
    if data["team_radius"] is None:
        del data["team_radius"]
    data["faults"] = [fault_entry(fault) for fault in scenario.faults]
    del data["source"]
    return yaml.safe_dump(data, sort_keys=False)


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*.yaml")), ids=lambda file: file.stem)
def test_examples_are_the_same_after_writing_out_all_fields(file):
    scenario = load(file)
    again = loads(dumped(scenario))
    assert dataclasses.replace(again, source=scenario.source) == scenario
    assert scenario.source == file.read_text()


def test_example_case_ii_is_the_paper_s():
    scenario = load(EXAMPLES / "case_ii.yaml")
    assert scenario.workspace_radius == 30
    assert [region.centre for region in scenario.regions] == [
        (0, 0, 0),
        (-14, -14, 0),
        (20, -10, 0),
        (-16, 15, 0),
    ]
    assert {agent.name: (agent.power, agent.spec) for agent in scenario.agents} == {
        "a1": (2, "G !pi3"),
        "a2": (4, "GF pi3"),
        "a3": (3, "1"),
    }
    assert {obj.name: (obj.power_needed, obj.spec) for obj in scenario.objects} == {
        "o1": (5, "GF pi1 & G(pi1 -> F pi4)"),
        "o2": (6, "GF pi3"),
    }
    assert scenario.fits == PublishedFits(agent=1.25, grasping=2.5, object=0.5, capacity=5.75)


def test_defaults(data):
    scenario = read(data)
    assert [agent.heading for agent in scenario.agents] == pytest.approx([0, 2 * math.pi / 3])
    assert [agent.power for agent in scenario.agents] == [1, 1]
    assert scenario.agents[1].spec == scenario.spec == "1"
    assert scenario.agents[0].radius is scenario.agents[0].joints is scenario.objects[0].team_radius is None
    assert (scenario.cost, scenario.fits, scenario.seed) == ("squared_distance", None, 0)
    assert scenario.simulation.time_step == 0.005


def test_optional_entries(data):
    put(data, "agents.a1.joints", [0.1, -1])
    put(data, "team_radius", 2.6)
    put(data, "objects.o2", {**data["objects"]["o1"], "position": [1, 1], "team_radius": 2})
    put(data, "services.a1.pi2", ["charge", "dock"])
    put(data, "agents.a1.spec", "GF charge & F pi1")
    put(data, "spec", "F(a1.dock & o1.pi2)")
    put(data, "controller", {"kappa": 30, "lambda": 0.5})
    put(data, "simulation", {"time_step": 0.02, "suffix_rounds": 2})
    put(data, "tolerances", LARGEST_TOLERANCES)
    put(data, "fits", "geometric")
    put(data, "cost", "distance")
    scenario = read(data)
    assert scenario.agents[0].joints == (0.1, -1.0)
    assert [obj.team_radius for obj in scenario.objects] == [2.6, 2.0]
    assert scenario.services == {"a1": {"pi2": ("charge", "dock")}}
    assert (scenario.controller.kappa, scenario.controller.lambda_) == (30, 0.5)
    assert (scenario.simulation.suffix_rounds, scenario.cost) == (2, "distance")
    assert dataclasses.asdict(scenario.tolerances) == LARGEST_TOLERANCES


def test_which_way_objects_face(data):
    (plain,) = read(data).objects
    assert (plain.orientation, plain.headings, plain.is_turned) == ((0, 0, 0), {}, False)
    put(data, "objects.o1.heading", -0.5)
    put(data, "objects.o1.headings", {"pi1": -0.5, "pi2": 2})
    (turned,) = read(data).objects
    assert (turned.orientation, turned.heading, turned.headings) == ((0, 0, -0.5), -0.5, {"pi1": -0.5, "pi2": 2})
    assert turned.is_turned
    del data["objects"]["o1"]["heading"], data["objects"]["o1"]["headings"]["pi2"]
    put(data, "objects.o1.orientation", [0, 1.5708, -0.5])
    (lying,) = read(data).objects
    assert (lying.orientation, lying.heading, lying.is_turned) == ((0, 1.5708, -0.5), -0.5, False)


def test_a_heading_is_said_once(data, complaints):
    put(data, "objects.o1.heading", 1)
    put(data, "objects.o1.orientation", [0, 0, 1])
    (mistake,) = complaints(data)
    assert str(mistake).startswith("objects.o1.heading: stands beside `orientation`; write one of them")


def test_objects_may_be_none_and_a_name_may_be_left_out(data):
    del data["objects"], data["name"]
    scenario = loads(yaml.safe_dump(data), source_name="folder/errand.yaml")
    assert (scenario.objects, scenario.name) == ((), "errand")


def test_numbers_in_scientific_notation(data):
    text = yaml.safe_dump(data).replace("radius: 20", "radius: 2e1")
    assert loads(text).workspace_radius == 20


# One line for each kind of mistake: key path, bad value, where it must be reported, a part of the line.
MISTAKES = [
    # values of the wrong type
    ("name", 5, "name", "5 is not text"),
    ("workspace", 30, "workspace", "30 is not a map"),
    ("workspace.radius", "wide", "workspace.radius", "'wide' is not a number"),
    ("workspace.radius", True, "workspace.radius", "True is not a number"),
    ("regions", ["pi1"], "regions", "['pi1'] is not a map"),
    ("regions.pi1.centre", 0, "regions.pi1.centre", "[x, y, z]"),
    ("regions.pi1.centre", [0, 0], "regions.pi1.centre", "not a list of 3 numbers"),
    ("agents", "a1", "agents", "is not a map"),
    ("agents.a1.position", [0, None], "agents.a1.position", "None is not a number"),
    ("agents.a1.joints", "up", "agents.a1.joints", "'up' is not a list"),
    ("agents.a1.model", ["a"], "agents.a1.model", "is not text"),
    ("agents.a1.spec", 1, "agents.a1.spec", "1 is not a formula"),
    ("agents.a1.radius", None, "agents.a1.radius", "None is not a number"),
    ("spec", ["F a1.pi1"], "spec", "is not a formula"),
    ("services", "charge", "services", "is not a map"),
    ("services.a1", ["pi1"], "services.a1", "is not a map"),
    ("services.a1.pi1", "charge", "services.a1.pi1", "write [charge, dock]"),
    ("services.a1.pi1", [1], "services.a1.pi1", "1 is not text"),
    ("fits", 5.75, "fits", "5.75 is unknown"),
    ("fits", {"agent": 1}, "fits.capacity", "is missing"),
    ("cost", "time", "cost", "squared_distance, distance"),
    ("seed", 1.0, "seed", "1.0 is not a whole number"),
    ("seed", True, "seed", "True is not a whole number"),
    ("controller", 40, "controller", "is not a map"),
    # numbers out of range
    ("workspace.radius", 0, "workspace.radius", "0 is not a positive number"),
    ("regions.pi1.radius", -3.5, "regions.pi1.radius", "-3.5 is not a positive number"),
    ("regions.pi1.radius", math.nan, "regions.pi1.radius", "nan is not a positive number"),
    ("regions.pi1.centre", [0, 0, -math.inf], "regions.pi1.centre", "-inf is not a finite number"),
    ("agents.a1.position", [math.inf, 0], "agents.a1.position", "inf is too large"),
    ("agents.a1.position", [10**400, 0], "agents.a1.position", "is too large"),
    ("agents.a1.heading", math.nan, "agents.a1.heading", "nan is not a finite number"),
    ("agents.a1.joints", [0, math.nan], "agents.a1.joints", "nan is not a finite number"),
    ("agents.a1.power", -1, "agents.a1.power", "-1 is not a positive number"),
    ("agents.a1.radius", -1.25, "agents.a1.radius", "-1.25 is not a positive number"),
    ("objects.o1.power_needed", 0, "objects.o1.power_needed", "0 is not a positive number"),
    ("objects.o1.radius", 1e-300, "objects.o1.radius", "1e-300 is not a positive number"),
    ("objects.o1.team_radius", 0, "objects.o1.team_radius", "0 is not a positive number"),
    ("team_radius", -1, "team_radius", "-1 is not a positive number"),
    ("objects.o1.heading", math.inf, "objects.o1.heading", "inf is too large"),
    ("objects.o1.heading", [0, 0, 1], "objects.o1.heading", "[0, 0, 1] is not a number"),
    ("objects.o1.orientation", 1.5, "objects.o1.orientation", "write [roll, pitch, yaw] in rad"),
    ("objects.o1.orientation", [0, 1.5], "objects.o1.orientation", "is not a list of 3 numbers"),
    ("objects.o1.headings", 1.5, "objects.o1.headings", "1.5 is not a map"),
    ("objects.o1.headings.pi1", "north", "objects.o1.headings.pi1", "'north' is not a number"),
    ("objects.o1.headings.pi3", 0, "objects.o1.headings.pi3", "there is no region 'pi3'; did you mean"),
    ("tolerances.angle", 0.2, "tolerances.angle", "0.2 is too large; write a positive number (1e-09 to 0.1)"),
    ("seed", -1, "seed", "-1 is not a whole number of at least 0"),
    ("seed", 2**63, "seed", "write a whole number (0 to"),
    ("controller.kappa", 0, "controller.kappa", "0 is not a positive number"),
    ("controller.lambda", -0.1, "controller.lambda", "-0.1 is not zero or a positive number"),
    ("tolerances.speed", -1, "tolerances.speed", "-1 is not a positive number"),
    ("tolerances.position", 0.11, "tolerances.position", "0.11 is too large; write a positive number (1e-09 to 0.1)"),
    ("tolerances.joint", 0.11, "tolerances.joint", "0.11 is too large; write a positive number (1e-09 to 0.1)"),
    ("tolerances.speed", 1000, "tolerances.speed", "1000 is too large; write a positive number (1e-09 to 0.5)"),
    ("tolerances.weld_position", 100, "tolerances.weld_position", "100 is too large"),
    ("tolerances.weld_angle", 3.1, "tolerances.weld_angle", "3.1 is too large"),
    ("simulation.time_step", 0.05, "simulation.time_step", "0.05 is too large"),
    ("simulation.suffix_rounds", 0, "simulation.suffix_rounds", "0 is not a whole number of at least 1"),
    ("fits", {"agent": -1, "grasping": 1, "object": 1, "capacity": 1}, "fits.agent", "-1 is not a positive"),
    # unknown keys
    ("workspce", {"radius": 3}, "workspce", "did you mean `workspace`?"),
    (
        "regions.pi1.center",
        [0, 0, 0],
        "regions.pi1.center",
        "did you mean `centre`? known keys: centre, radius",
    ),
    ("agents.a1.colour", "red", "agents.a1.colour", "known keys: model, joints, position"),
    ("agents.a1.team_radius", 2.6, "agents.a1.team_radius", "is not a known key"),
    ("objects.o1.power", 2, "objects.o1.power", "known keys: model, position, power_needed"),
    ("controller.lambda_", 0, "controller.lambda_", "did you mean `lambda`?"),
    ("simulation.dt", 0.01, "simulation.dt", "known keys: time_step"),
    ("fits", {"agents": 1}, "fits.agents", "did you mean `agent`?"),
    ("3", 4, "3", "is not a known key"),
    # names
    ("regions.Pi3", {"centre": [0, 9, 0], "radius": 1}, "regions.Pi3", "'Pi3' cannot stand in a formula"),
    ("regions.xor", {"centre": [0, 9, 0], "radius": 1}, "regions.xor", "'xor' is a word of temporal logic"),
    ("agents.Gripper", {}, "agents.Gripper", "use lower-case letters"),
    ("objects.o-1", {}, "objects.o-1", "'o-1' cannot stand in a formula"),
    ("services.a1.pi1", ["Charge"], "services.a1.pi1", "'Charge' cannot stand in a formula"),
    ("services.a1.pi1", ["dock", "dock"], "services.a1.pi1", "names a service twice"),
    ("services.a9.pi1", ["dock"], "services.a9", "there is no member 'a9'"),
    ("services.a1.pi9", ["dock"], "services.a1.pi9", "known regions: pi1, pi2"),
    ("objects.a1", {}, "objects.a1", "an agent is called 'a1' as well"),
    # regions
    ("regions", {}, "regions", "there is no region"),
    ("regions.pi2.centre", [6.5, 0, 0], "regions.pi2", "overlaps region 'pi1' by 0.5 m"),
    ("regions.pi2.centre", [10, 0, 15], "regions.pi2", "reaches 1.528 m beyond the workspace"),
    # members
    ("agents", {}, "agents", "there is no agent"),
    ("agents", None, "agents", "there is no agent"),
    ("agents.a1", None, "agents.a1.model", "is missing; add a line `model: ...`"),
    ("agents.a1", {"position": [0, 0]}, "agents.a1.model", "is missing"),
    ("objects.o1", {"radius": 3, "team_radius": 2}, "objects.o1", "team_radius 2 is less"),
    ("agents.a1.position", [3, 2.6], "agents.a1.position", "lies in no region"),
    ("objects.o1.position", [1e5, 0], "objects.o1.position", "move it towards the centre of pi"),
    # models
    ("agents.a1.model", "nowhere.urdf", "agents.a1.model", "one of: package://drake_ltl_models/agents/"),
    ("objects.o1.model", "nowhere.sdf", "objects.o1.model", "one of: package://drake_ltl_models/objects/"),
    ("agents.a1.model", "package://elsewhere/arm.urdf", "agents.a1.model", "not a known package"),
    ("agents.a1.model", "https://robots.example/arm.urdf", "agents.a1.model", "not a known scheme"),
    ("agents.a1.joints", [0, 0, 0], "agents.a1.joints", "planar_arm.urdf has 2 arm joints"),
    # formulas
    ("agents.a1.spec", "G !pi1 &", "agents.a1.spec", "unexpected end of formula at its end"),
    ("agents.a1.spec", "G )pi1", "agents.a1.spec", "at ')pi1' (column 3)"),
    ("agents.a1.spec", "", "agents.a1.spec", "empty input"),
    ("agents.a1.spec", "(" * 9999, "agents.a1.spec", "opens 9999 parentheses and closes 0"),
    ("agents.a1.spec", "F pié", "agents.a1.spec", "characters that no formula has"),
    ("agents.a1.spec", "F pi11", "agents.a1.spec", "did you mean `pi1`? known propositions: pi1, pi2"),
    ("agents.a1.spec", "F a1.pi1", "agents.a1.spec", "unknown proposition 'a1.pi1'"),
    ("agents.a1.spec", "F pi7 & G pi8", "agents.a1.spec", "unknown propositions: 'pi7', 'pi8'"),
    ("agents.a1.spec", "GGripper", "agents.a1.spec", "unknown proposition 'ripper'"),
    ("agents.a1.spec", "F[1:3] pi1", "agents.a1.spec", "has a bounded operator"),
    ("agents.a1.spec", "[]<> pi1", "agents.a1.spec", "write G for [] and F for <>"),
    ("agents.a1.spec", "{pi1;pi2}<>->pi1", "agents.a1.spec", "beyond linear temporal logic"),
    ("spec", "F pi1", "spec", "write member.proposition"),
    ("spec", "F a3.pi1", "spec", "known: a1.pi1, a1.pi2, a2.pi1"),
    ("spec", "F a1.dock", "spec", "known: a1.pi1, a1.pi2"),
]


@pytest.mark.parametrize(
    ("path", "value", "where", "part"),
    MISTAKES,
    ids=[f"{path}={value!r}"[:60] for path, value, *_ in MISTAKES],
)
def test_mistake_is_reported_with_its_place_and_remedy(data, complaints, path, value, where, part):
    put(data, path, value)
    lines = [str(mistake) for mistake in complaints(data) if mistake.where == where]
    assert any(part in line for line in lines), complaints(data)


def test_service_hides_the_name_of_its_region(data, complaints):
    put(data, "services.a1.pi2", ["charge"])
    (mistake,) = complaints(data)  # a1's formula is GF pi2
    assert (mistake.where, mistake.remedy) == ("agents.a1.spec", "did you mean `pi1`? known propositions: pi1, charge")


def test_all_mistakes_are_reported_together(data, complaints):
    spoilt = {
        "workspace.radius": -1,
        "regions.pi2.radius": "wide",
        "agents.a1.power": True,
        "agents.a2.spec": "F(",
        "objects.o1.position": [1],
        "cost": "none",
        "extra": 0,
    }
    for path, value in spoilt.items():
        put(data, path, value)
    assert sorted(mistake.where for mistake in complaints(data)) == sorted(spoilt)


def test_touching_regions_and_workspace_are_no_mistake(data):
    put(data, "regions.pi2", {"centre": [7.0, 0, 0], "radius": 3.5})
    put(data, "workspace.radius", 10.5)
    assert read(data).workspace_radius == 10.5


def test_keys_that_yaml_reads_as_other_than_text(data, complaints):
    for key in ("on", "true", "Yes"):
        (mistake,) = complaints(yaml.safe_dump(data).replace("  pi1:\n", f"  {key}:\n"))
        assert (mistake.where, mistake.what) == ("regions.True", "the name is not text but True")
        assert mistake.remedy.startswith("choose another")  # in quotes, `true` would be refused as well
    (mistake,) = complaints(yaml.safe_dump(data).replace("  pi1:\n", "  1:\n"))
    assert (mistake.where, mistake.what) == ("regions.1", "the name 1 is not text")
    assert "beginning with a letter" in mistake.remedy  # quotes alone would not do


@pytest.mark.parametrize(("kind", "name"), [("regions", "pi1"), ("agents", "a1"), ("objects", "o1")])
def test_what_refers_to_a_name_that_cannot_be_used_is_not_called_unknown(data, complaints, kind, name):
    """Formulas and services say `pi1`, which would be right."""
    data |= {"spec": "F a1.pi1 & F o1.pi1", "services": {"a1": {"pi1": ["charge"]}, "o1": {"pi1": ["pi1"]}}}
    data["agents"]["a1"]["spec"] = "GF charge & F pi2"
    data[kind] = {name.title() if key == name else key: value for key, value in data[kind].items()}
    (mistake,) = complaints(data)
    assert mistake.where == f"{kind}.{name.title()}"


def test_a_service_that_cannot_be_named_so_is_one_mistake(data, complaints):
    data["services"] = {"a1": {"pi2": ["Charge"]}}
    data["agents"]["a1"]["spec"] = "GF charge"
    (mistake,) = complaints(data)
    assert mistake.where == "services.a1.pi2"


def test_a_number_of_thousands_of_digits_is_named_by_its_key(data, complaints):
    for sign in ("", "-", "+"):
        text = yaml.safe_dump(data).replace("power_needed: 2", f"power_needed: {sign}{'9' * 6000}")
        (mistake,) = complaints(text)
        assert mistake.where == "objects.o1.power_needed"
        assert "a number of thousands of digits" in mistake.what
        assert "1e-09 to 1e+09" in mistake.remedy


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("", "small.yaml: is empty"),
        ("# nothing\n", "small.yaml: is empty"),
        ("- a\n- b", "['a', 'b'] is not a map"),
        ("a: [1", "at line 1"),
        ("a: 1\nb: 2\na: 3", "the key 'a' stands twice in one map at line 3, column 1"),
        ("a: {b: 1, b: 2}", "the key 'b' stands twice"),
        ("a: {b: 1, b: 2}", "write each key of a map once"),
        ("a:\n\tb: 1", "indent with spaces"),
        ("a:\n  b\n    c: 1", "write a colon after every key, in the line before too"),
        ("a: 1\nb\nc: 3", "write a colon after every key"),
        ("a: {b: 1\nc: 3", "close every bracket"),
        ("a: 'b", "close every quote"),
        ("a:\n   b: 1\n  c: 2", "indent all keys of a map alike"),
        ('a: "1\nb: "2"', "close quotes"),
        ("a: &x [1]\nb: *x", "anchors and aliases"),
        ("a: *x", "anchors and aliases"),
        ("spec: !pi1", "the tag !pi1 is not read here at line 1, column 7"),
        ("spec: ! pi1", "the tag ! is not read here"),
        ("a: !!python/object/apply:os.getcwd []", "the tag"),
        ("a: !!timestamp x", "the tag"),
        ("? [a]\n: 1", "a key is not text"),
        ("? {a: 1}\n: 1", "a key is not text"),
        ("a: 1\n---\nb: 2", "expected a single document"),
        ("a: \x07", "special characters are not allowed"),
        ("a: " + "[" * 5000, "nested too deeply"),
        ("a: 0b_", "a number that cannot be read"),
        ("#" * 300_000, "is longer than"),
    ],
)
def test_text_that_is_no_scenario(complaints, text, part):
    (mistake,) = complaints(text)
    assert mistake.where == "small.yaml"
    assert part in str(mistake)


def test_values_that_yaml_1_1_would_turn_into_something_else(data):
    data["name"] = "NAME"
    for name in ("2020-13-45", "<<", "=", "1e5x"):
        assert loads(yaml.safe_dump(data).replace("NAME", name)).name == name


@pytest.mark.parametrize("make", ["missing", "folder", "latin", "long", "null"])
def test_file_that_cannot_be_read(tmp_path, make):
    path = tmp_path / "scenario.yaml"
    if make == "folder":
        path.mkdir()
    elif make == "latin":
        path.write_bytes("name: café".encode("latin-1"))
    elif make == "long":
        path.write_text("#" * 300_000)
    elif make == "null":
        path = Path(f"{path}\0")
    with pytest.raises(InvalidInputError) as caught:
        load(path)
    (mistake,) = caught.value.mistakes
    assert "scenario.yaml" in mistake.where
    assert len(str(caught.value).splitlines()) == 1


def test_byte_order_mark_is_skipped(tmp_path, data):
    path = tmp_path / "scenario.yaml"
    path.write_text(yaml.safe_dump(data), encoding="utf-8-sig")
    assert load(str(path)).name == "small"


def test_more_of_a_kind_than_anybody_plans_with(data, complaints):
    """One line, not one for each pair."""
    for kind in ("regions", "agents", "objects"):
        many = copy.deepcopy(data)
        ((_, entry), *_) = many[kind].items()
        many[kind] = {f"m{number}": copy.deepcopy(entry) for number in range(301)}
        assert f"{kind}: there are 301; write at most 300" in map(str, complaints(many))
    (mistake,) = [m for m in complaints({f"key{n}": n for n in range(301)} | data) if "unknown" in m.what]
    assert mistake.what == "301 keys are unknown"


def test_a_region_is_said_to_overlap_once(data, complaints):
    data["regions"] |= {f"s{n}": {"centre": [0, 0, 9], "radius": 1} for n in range(5)}
    found = [m.where for m in complaints(data) if "overlaps" in m.what]
    assert found == [f"regions.s{n}" for n in range(1, 5)]


@pytest.mark.parametrize(
    "text", ["[" * 60, "{a: " * 60, "- " * 60, "a:\n" + "".join(" " * n + "b:\n" for n in range(1, 60))]
)
def test_nesting(text):
    with pytest.raises(InvalidInputError, match="is nested too deeply"):
        loads(text)
