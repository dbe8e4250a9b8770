"""load, plan, simulate and verify from the top of the package, and how what they return shows itself."""

from __future__ import annotations

import base64
import subprocess
import sys
from xml.etree import ElementTree

import pytest
from rich.console import Console

import drake_ltl
from drake_ltl import examples
from drake_ltl.api import planning_problem
from drake_ltl.errors import InvalidInputError
from drake_ltl.planning.methods import plan_by
from drake_ltl.planning.own_plan import own_plan
from drake_ltl.planning_geometry import planning_geometry

LIGHT = """
import sys
import drake_ltl
assert not {"numpy", "pydrake", "spot", "rich"} & set(sys.modules), "import drake_ltl"
scenario = drake_ltl.load("case_ii")
plan = drake_ltl.plan(scenario)
assert plan.cost == 7827.0
assert "pydrake" not in sys.modules, "planning"
"""


def test_importing_loads_nothing_and_planning_no_drake():
    done = subprocess.run([sys.executable, "-c", LIGHT], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_every_name_is_there_and_an_unknown_one_is_not():
    assert all(getattr(drake_ltl, name) for name in drake_ltl.__all__)
    assert set(drake_ltl.__all__) <= set(dir(drake_ltl))
    with pytest.raises(AttributeError, match="no attribute 'plans'"):
        _ = drake_ltl.plans


def test_examples_are_loaded_by_name_and_files_by_path(examples):
    assert drake_ltl.load("patrol") == drake_ltl.load(examples / "patrol.yaml") == drake_ltl.Scenario.load("patrol")
    with pytest.raises(InvalidInputError, match="examples are case_i, case_ii"):
        drake_ltl.load("patrols")


def test_examples_are_installed_with_the_library():
    assert set(examples.names()) >= {"patrol", "case_i", "case_ii", "forbidden_room"}
    assert all(examples.path(name).is_file() for name in examples.names())


@pytest.fixture(scope="module")
def starter():
    from drake_ltl.scenario.starter import STARTER

    return drake_ltl.loads(STARTER)


@pytest.fixture(scope="module")
def problem(starter):
    """The models are measured once."""
    return starter, *planning_problem(starter, planning_geometry(starter))


ERRAND = {
    "prefix": ["a2: dock -> depot"],
    "suffix": [
        "a1 grasps crate; a2 grasps crate",
        "{a1, a2} carry crate: depot → dock",
        "{a1, a2} carry crate: dock -> depot",
        "a1 releases crate; a2 releases crate",
    ],
}


def test_an_own_plan_is_read_in_the_words_of_tables(problem):
    """Not the cheapest, so it shows that nothing was planned anew."""
    plan = own_plan(*problem, **ERRAND)
    assert (len(plan.prefix), len(plan.suffix)) == (1, 4)
    assert plan.prefix_cost == 256.0
    assert plan.suffix_cost == 6 * 256.0  # two robots and the crate, there and back
    best = plan_by("explicit", *problem)[0]
    printed = {"prefix": texts(best)[: best.loop], "suffix": texts(best)[best.loop :]}
    assert own_plan(*problem, **printed).moves == best.moves


def texts(plan):
    from drake_ltl.planning.table import action_text

    return ["; ".join(action_text(action) for action in actions) for actions in plan.moves]


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"suffix": []}, "suffix: has no steps"),
        ({"prefix": ["a2 goes home"]}, "step 1: 'a2 goes home' is no action; write `a: x -> y`"),
        ({"prefix": ["a3: dock -> depot"]}, "step 1: 'a3' is not an agent; write one of a1, a2"),
        ({"prefix": ["a2: dock -> attic"]}, "step 1: 'attic' is not a region"),
        ({"prefix": ["a2: depot -> dock"]}, "step 1: a2 is in dock, not in depot"),
        ({"prefix": ["a2 grasps box"]}, "step 1: 'box' is not an object"),
        ({"suffix": ERRAND["suffix"][:2]}, "suffix: ends with a1 in dock.* but begins with a1 in depot"),
        ({"suffix": ["all wait"]}, "plan: the plan's word does not satisfy"),
        ({"prefix": [], "suffix": ["a1 carries crate: depot -> dock", "a1 carries crate: dock -> depot"]}, "moved by"),
    ],
)
def test_what_is_wrong_with_an_own_plan_is_said(problem, change, complaint):
    with pytest.raises(InvalidInputError, match=complaint):
        own_plan(*problem, **(ERRAND | change))


def shown(thing) -> str:
    console = Console(width=100, record=True, file=open("/dev/null", "w"))  # noqa: SIM115
    console.print(thing)
    console.file.close()
    return console.export_text()


def test_scenarios_show_members_and_formulas(case_ii):
    assert repr(case_ii) == "Scenario('case_ii', 3 agents, 2 objects, 4 regions)"
    for text in (shown(case_ii), case_ii._repr_html_()):
        assert "case_ii: 3 agents, 2 objects, 4 regions" in text
        assert "needs 5" in text
    assert "G(pi1 -&gt; F pi4)" in case_ii._repr_html_()


def test_scenarios_show_a_map_in_notebooks(case_ii):
    svg = case_ii._repr_svg_()
    assert ElementTree.fromstring(svg).tag.endswith("svg")
    assert svg.count('id="text_') >= 4 + 3 + 2  # names of regions, agents and objects
    data = case_ii._repr_html_().partition("base64,")[2].partition('"')[0]
    assert base64.b64decode(data).decode() == svg
    assert svg == case_ii._repr_svg_()


def test_a_scenario_that_cannot_be_drawn_shows_its_table(case_ii):
    from dataclasses import replace

    outside = replace(case_ii, agents=(replace(case_ii.agents[0], position=(9.0, 9.0)), *case_ii.agents[1:]))
    html = outside._repr_html_()
    assert html.startswith("<p>no map: agents.a1.position")
    assert "<table>" in html


def test_plans_show_their_steps(problem):
    plan = plan_by("explicit", *problem)[0]
    assert repr(plan).startswith("Plan(optimal, J = ")
    for text in (shown(plan), plan._repr_html_()):
        assert "crate: depot → dock" in text.replace("\N{NO-BREAK SPACE}", " ")
        assert "repeated for ever" in text


@pytest.mark.mission
def test_a_plan_of_ones_own_is_carried_out_and_judged(tmp_path, shuttle_text):
    """Each part alone: a plan nobody searched, a run of it, a verdict from its file."""
    scenario = drake_ltl.loads(shuttle_text)
    plan = drake_ltl.own_plan(scenario, suffix=["a1: near -> far", "a1: far -> near"])
    run = drake_ltl.simulate(scenario, plan, suffix_rounds=1)
    assert repr(run).startswith("Run('shuttle', 2 steps, ")
    run.recording.save(tmp_path / "run.npz")
    verdict = drake_ltl.verify(tmp_path / "run.npz")
    assert verdict.satisfied
    assert repr(verdict).startswith("Verdict(satisfied, 2 steps, ")
    for text in (shown(verdict), verdict._repr_html_()):
        assert "SATISFIED" in text
        assert "shuttle" in text
        assert "rise of V" in text


def test_a_method_that_there_is_not_is_refused(starter):
    with pytest.raises(InvalidInputError, match="there is no method 'quick'; take one of auto, explicit, bounded"):
        drake_ltl.plan(starter, method="quick")
