"""Radii that a scenario states, against what the bodies reach."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from drake_ltl.errors import InvalidInputError
from drake_ltl.multibody import MeasureGeometry
from drake_ltl.multibody.radii import TEAM_SLACK, round_up
from drake_ltl.scenario import load, loads

CYLINDER = """\
<sdf version="1.9"><model name="drum"><link name="drum">
  <inertial><mass>1</mass></inertial>
  <collision name="drum"><geometry><cylinder><radius>0.3</radius><length>0.4</length></cylinder></geometry></collision>
</link>
<frame name="grasp_ring" attached_to="drum"><pose>0.37 0 0.08 3.14159265 1.57079633 0</pose></frame></model></sdf>
"""


@pytest.fixture(scope="module")
def unstated(case_ii):
    return MeasureGeometry(stating(case_ii)).geometry


def stating(scenario, agent=None, obj=None, team=None):
    """The scenario with other radii."""
    return replace(
        scenario,
        agents=tuple(replace(one, radius=agent) for one in scenario.agents),
        objects=tuple(replace(one, radius=obj, team_radius=team) for one in scenario.objects),
        team_radius=team,
    )


def refusals(scenario) -> dict[str, str]:
    """Key -> rest of the line."""
    with pytest.raises(InvalidInputError) as caught:
        MeasureGeometry(scenario)
    return {mistake.where: f"{mistake.what}; {mistake.remedy}" for mistake in caught.value.mistakes}


@pytest.mark.parametrize("example", ["case_i.yaml", "case_ii.yaml"])
def test_the_published_radii_cover_the_bodies(examples, example):
    scenario = load(examples / example)
    geometry = MeasureGeometry(scenario).geometry
    assert set(geometry.agent_radius.values()) == {1.25}
    assert set(geometry.object_radius.values()) == {0.5}
    assert set(geometry.team_radius.values()) == {2.67}


def test_radii_smaller_than_the_bodies_are_refused_one_line_for_each(case_ii):
    lines = refusals(stating(case_ii, agent=0.3, obj=0.2, team=1.0))
    assert set(lines) == {
        *(f"agents.a{k}.radius" for k in (1, 2, 3)),
        *(f"objects.o{k}.radius" for k in (1, 2)),
        "team_radius",
    }
    assert re.match(r"0\.3 is less than the 1\.2125 m that a1 .*; write at least 1\.213,", lines["agents.a1.radius"])
    assert re.match(r"0\.2 is less than the 0\.3775 m that o1 .*; write at least 0\.378,", lines["objects.o1.radius"])
    assert re.match(r"1\.0 is less than the 2\.6.* m that who grasps o.*; write at least 2\.6", lines["team_radius"])


def test_a_team_radius_of_one_object_is_named_where_it_stands(case_ii):
    first, second = case_ii.objects
    lines = refusals(replace(case_ii, objects=(first, replace(second, team_radius=2.0))))
    assert set(lines) == {"objects.o2.team_radius"}


def test_what_is_asked_for_passes_and_a_millimetre_less_does_not(case_ii, unstated):
    agent = max(unstated.agent_radius.values())
    obj = max(unstated.object_radius.values())
    team = round_up(max(unstated.team_radius.values()) - TEAM_SLACK)  # advised is some slack: not demanded
    geometry = MeasureGeometry(stating(case_ii, agent, obj, team)).geometry
    assert set(geometry.team_radius.values()) == {team}
    less = refusals(stating(case_ii, agent - 0.001, obj - 0.001, team - 0.001))
    assert {"agents.a1.radius", "objects.o1.radius", "team_radius"} <= set(less)


def test_an_honest_radius_of_a_round_body_passes(case_ii, tmp_path):
    """Radii are measured on a polygon around the rim; the body itself ends before its corners."""
    path = tmp_path / "drum.sdf"
    path.write_text(CYLINDER, encoding="utf-8")
    exact = float(np.hypot(0.3, 0.2))
    drum = replace(case_ii.objects[0], model=str(path), radius=exact, team_radius=None)
    scenario = replace(case_ii, objects=(drum,))
    assert MeasureGeometry(scenario).geometry.object_radius["o1"] == exact
    measured = MeasureGeometry(replace(scenario, objects=(replace(drum, radius=None),))).geometry.object_radius["o1"]
    assert exact < measured < exact + 0.003
    assert set(refusals(replace(scenario, objects=(replace(drum, radius=0.99 * exact),)))) == {"objects.o1.radius"}


def test_the_key_for_all_objects_is_remembered(examples):
    text = (examples / "case_ii.yaml").read_text(encoding="utf-8")
    assert loads(text).team_radius == 2.67
    assert loads(text.replace("team_radius: 2.67", "")).team_radius is None
