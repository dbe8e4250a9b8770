"""Plans from JSON: what was written is read, whatever else is there is refused with all that is wrong."""

from __future__ import annotations

import copy
import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_ltl.errors import InvalidInputError
from drake_ltl.planning.fits import published_fits
from drake_ltl.planning.plan import Plan
from drake_ltl.planning.plan_json import plan_to_json
from drake_ltl.planning.plan_reader import plan_from_json
from drake_ltl.planning.planner import plan

leaves = st.none() | st.booleans() | st.integers() | st.floats() | st.sampled_from(["a1", "pi1", "o1", "travel", ""])
trees = st.recursive(leaves, lambda part: st.lists(part, max_size=2) | st.dictionaries(st.text(), part, max_size=2))


@pytest.fixture(scope="module")
def written(case_i):
    scenario, start = case_i
    found = plan(scenario, start, published_fits(scenario.fits))
    return json.loads(json.dumps(plan_to_json(found, scenario))), scenario, found


def test_what_is_written_is_read(written):
    data, scenario, found = written
    assert plan_from_json(data, scenario) == found


def lines(data, scenario) -> list[str]:
    with pytest.raises(InvalidInputError) as caught:
        plan_from_json(data, scenario)
    assert len(str(caught.value).splitlines()) == len(caught.value.mistakes)
    return str(caught.value).splitlines()


def test_every_mistake_is_said(written):
    data, scenario, _ = copy.deepcopy(written)
    data["prefix"][0]["agents"]["a1"] = "pi9"
    data["prefix"][0]["grasps"]["a2"] = ["o1"]
    del data["suffix"][0]["objects"]["o1"]
    data["steps"][0][0] |= {"kind": "fly", "with": 3}
    data["prefix_cost"] = float("nan")
    found = [line.split(": ")[0] for line in lines(data, scenario)]
    step, state = "steps[0][0]", "prefix[0]"
    of_states = [f"{state}.agents.a1", f"{state}.grasps.a2", "suffix[0].objects.o1"]
    assert found == [*of_states, f"{step}.kind", f"{step}.with", "prefix_cost"]


def test_steps_and_states_are_as_many(written):
    data, scenario, _ = copy.deepcopy(written)
    data["steps"].pop()
    assert lines(data, scenario)[0].startswith("steps: there are")
    assert any("suffix: is empty" in line for line in lines(data | {"suffix": []}, scenario))


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_spoilt_plans(written, draw):
    data, scenario, _ = copy.deepcopy(written)
    place, key = data, draw.draw(st.sampled_from(sorted(data)))
    while isinstance(place[key], (dict, list)) and place[key] and draw.draw(st.integers(0, 3)):
        place = place[key]
        keys = sorted(place) if isinstance(place, dict) else range(len(place))
        key = draw.draw(st.sampled_from(keys))
    place[key] = draw.draw(trees)
    try:
        read = plan_from_json(data, scenario)
    except InvalidInputError:
        assert lines(data, scenario)
    else:
        assert isinstance(read, Plan)


@pytest.mark.parametrize("data", [None, [], 3, "plan", {}, {"status": "unknown"}, {"status": ["optimal"]}])
def test_what_is_no_plan(written, data):
    assert lines(data, written[1])
