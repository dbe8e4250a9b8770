"""What a reader sees of a plan, and what a program reads."""

from __future__ import annotations

import io
import json

import pytest
from rich.console import Console

from drake_ltl.errors import InvalidInputError
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.plan import State
from drake_ltl.planning.plan_json import no_plan_json, plan_to_json
from drake_ltl.planning.plan_reader import plan_from_json
from drake_ltl.planning.planner import plan
from drake_ltl.planning.table import plan_table


@pytest.fixture(scope="module")
def planned(case_ii):
    scenario, start = case_ii
    return plan(scenario, start, published_fits(scenario.fits)), scenario


def shown(found, scenario, width):
    console = Console(width=width, record=True, file=io.StringIO())
    console.print(plan_table(found, scenario))
    return console.export_text().replace("\N{NO-BREAK SPACE}", " ")


@pytest.mark.parametrize("width", [80, 160])
def test_the_table_shows_every_action(planned, width):
    text = shown(*planned, width)
    lines = text.splitlines()
    assert max(map(len, lines)) <= width
    for piece in (
        "start: a1 in pi1, a2 in pi3, a3 in pi4, o1 in pi2, o2 in pi1",
        "a2: pi3 → pi1; a3: pi4 → pi1",
        "a2 grasps o2; a3 grasps o2",
        "{a2, a3} carry o2: pi1 → pi3",
        "a3 releases o2",
        "J = 7827 = 4941 (prefix) + 2886 (suffix), optimal",
    ):
        assert piece in text
    numbers = [line.split()[0] for line in lines if line.split() and line.split()[0].rstrip("*").isdigit()]
    found, _ = planned  # a row for each step, counted from 1; those of the suffix, to its begin again, have a star
    prefix = len(found.prefix)
    assert numbers == [f"{k}" if k <= prefix else f"{k}*" for k in range(1, len(found.moves) + 1)]
    assert len(numbers) == len(found.prefix) + len(found.suffix)


def test_the_costs_stand_on_one_line_however_narrow_the_table_is(make_scenario):
    scenario = make_scenario({"a1": (1.0, "GF pi1 & GF pi2")}, {})
    found = plan(scenario, State(("pi1",), (), (None,)), lambda region, content: True)
    lines = [line.rstrip() for line in shown(found, scenario, 80).splitlines()]
    assert [line for line in lines if line.startswith("J = ") and line.endswith("(suffix), optimal")]


def test_lines_break_between_actions(planned):
    text = shown(*planned, 40)
    assert any(line.strip().endswith("a3: pi4 → pi1") for line in text.splitlines())


def test_waiting_and_single_carriers_are_shown(make_scenario):
    scenario = make_scenario({"a1": (1.0, "1")}, {"o1": (1.0, "F pi2")}, spec="X X a1.pi1 & X !a1.pi2")
    found = plan(scenario, State(("pi1",), ("pi1",), ("o1",)), lambda region, content: True)
    text = shown(found, scenario, 80)
    assert "a1 carries o1: pi1 → pi2" in text
    assert "start: a1 in pi1, o1 in pi1, a1 grasps o1" in text
    assert "all wait" in text


def test_json_has_the_keys_of_the_contract(planned):
    found, scenario = planned
    data = json.loads(json.dumps(plan_to_json(found, scenario), allow_nan=False))
    assert (data["cost"], data["status"], data["lower_bound"]) == (7827.0, "optimal", 7827.0)
    assert data["prefix"][0] == {
        "agents": {"a1": "pi1", "a2": "pi3", "a3": "pi4"},
        "objects": {"o1": "pi2", "o2": "pi1"},
        "grasps": {"a1": None, "a2": None, "a3": None},
    }
    assert data["steps"][2] == [
        {"kind": "transport", "agents": ["a2", "a3"], "object": "o2", "from": "pi1", "to": "pi3"}
    ]
    assert len(data["steps"]) == len(data["prefix"]) + len(data["suffix"])
    assert data["counts"]["product_states"] == 28008
    assert set(data["seconds"]) == {"transition_system", "automaton", "search", "total"}
    assert set(no_plan_json(scenario)) == set(data)
    assert plan_from_json(data, scenario) == found


def test_json_without_a_plan(case_i):
    data = no_plan_json(case_i[0])
    assert (data["scenario"], data["status"], data["cost"], data["prefix"]) == ("test", "infeasible", None, None)
    assert set(data["counts"].values()) == {None}
    with pytest.raises(InvalidInputError, match="status: 'infeasible' is unknown"):
        plan_from_json(data, case_i[0])
