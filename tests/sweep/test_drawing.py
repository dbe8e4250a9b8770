"""What is drawn for a run."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from drake_ltl import mission
from drake_ltl.planning.geometry import Geometry
from drake_ltl.scenario import load, loads
from drake_ltl.scenario.starts import check_starts
from drake_ltl.sweep import drawing, starts
from drake_ltl.sweep.drawing import GAINS, Drawn, draw, drawn_from_json, drawn_scenario, write_drawn


@pytest.fixture
def without_walks(monkeypatch) -> None:
    """Starts are the scenario's own."""

    def own(scenario, geometry, plan, rng):
        return {member.name: member.position for member in (*scenario.agents, *scenario.objects)}

    monkeypatch.setattr(drawing, "draw_starts", own)


def test_a_run_depends_on_its_seed_and_number_alone(sweep, without_walks):
    runs = [draw(sweep, number) for number in (2, 0, 1, 2)]
    assert runs[0] == runs[3]
    assert len({one.gains["force"] for one in runs}) == 3
    assert draw(dataclasses.replace(sweep, seed=4), 2) != runs[0]


def test_sources_are_those_that_a_seed_spawns(sweep):
    spawned = np.random.SeedSequence(sweep.seed).spawn(5)[4]
    assert sweep.random(4).uniform() == np.random.default_rng(spawned).uniform()


@settings(max_examples=50)
@given(st.floats(0.0, 90.0), st.floats(0.0, 90.0), st.integers(0, 2**31))
def test_changes_stay_within_what_is_stated(sweep, gains, masses, seed):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(drawing, "draw_starts", lambda *_: {})
        drawn = draw(dataclasses.replace(sweep, gains=gains, masses=masses, seed=seed), 0)
    nominal = sweep.scenario.controller
    assert set(drawn.gains) == set(GAINS)
    for name, value in drawn.gains.items():
        assert abs(value / getattr(nominal, name) - 1.0) <= gains / 100.0 + 1e-5  # of six digits
    assert set(drawn.masses) == {"o1", "o2"}
    for factor in drawn.masses.values():
        assert abs(factor - 1.0) <= masses / 100.0 + 1e-5


def test_the_drawn_start_is_valid_and_has_a_plan(sweep, case_ii, models, monkeypatch):
    """A short walk of the paper's second example, in which bodies have little room."""
    monkeypatch.setattr(starts, "ROUNDS", 2)
    drawn = draw(sweep, 0)
    assert drawn_from_json(json.loads(json.dumps(dataclasses.asdict(drawn)))) == drawn
    scenario = drawn_scenario(case_ii, drawn)
    before, after = (check_starts(one, models.geometry) for one in (case_ii, scenario))
    assert {name: one.region for name, one in after.agents.items()} == {
        name: one.region for name, one in before.agents.items()
    }
    assert {name: one.region for name, one in after.objects.items()} == {
        name: one.region for name, one in before.objects.items()
    }
    members = (*case_ii.agents, *case_ii.objects)
    assert sum(drawn.positions[member.name] != member.position for member in members) >= 3
    assert mission.plan_and_place(scenario, models).plan.cost == sweep.plan.cost


def test_the_text_says_all_but_the_masses(case_ii, tmp_path):
    positions = {member.name: (0.1234, -1e-5) for member in (*case_ii.agents, *case_ii.objects)}
    drawn = Drawn(positions, {name: 7.123 + index for index, name in enumerate(GAINS)}, {"o1": 0.99, "o2": 1.0})
    write_drawn(case_ii, drawn, tmp_path / "run.yaml", "run 3 of seed 0, stalled: two\nlines")
    text = (tmp_path / "run.yaml").read_text(encoding="utf-8")
    assert text.splitlines()[:2] == [
        "# run 3 of seed 0, stalled: two lines",
        "# masses in the run, as shares of the models': o1 0.99, o2 1",
    ]
    scenario = load(tmp_path / "run.yaml")
    expected = dataclasses.replace(
        starts.placed_at(case_ii, positions),
        controller=dataclasses.replace(case_ii.controller, **drawn.gains),
        source=text,
    )
    assert scenario == expected


def test_settings_and_paths_of_the_file_are_kept(shuttle_text, tmp_path, examples):
    """An empty block, other settings, and a model beside the file."""
    urdf = examples.parent / "models" / "agents" / "planar_arm.urdf"
    (tmp_path / "arm.urdf").write_text(urdf.read_text(encoding="utf-8"), encoding="utf-8")
    text = shuttle_text.replace("package://drake_ltl_models/agents/planar_arm.urdf", "arm.urdf")
    drawn = Drawn({"a1": (-2.5, 0.25)}, {"force": 30.0}, {})
    for block in ("controller:\n", "controller: {kappa: 12.5, force: 10}\n"):
        scenario = loads(text + block, base=tmp_path)
        changed = drawn_scenario(scenario, drawn)
        assert changed.agents[0].model == str((tmp_path / "arm.urdf").resolve())
        assert changed.agents[0].position == (-2.5, 0.25)
        assert changed.controller == dataclasses.replace(scenario.controller, force=30.0)


def test_starts_fill_their_region_evenly(shuttle_text, monkeypatch):
    """One sphere in a disc: the square of its distance from the middle is uniform, and so is its direction."""
    monkeypatch.setattr(starts, "place", lambda *_: None)
    scenario = loads(shuttle_text)
    geometry = Geometry({"a1": 1.25}, {}, {}, {})
    rng = np.random.default_rng(0)
    points = np.array([starts.draw_starts(scenario, geometry, None, rng)["a1"] for _ in range(400)])
    offsets = points - scenario.region("near").centre[:2]
    share = (np.linalg.norm(offsets, axis=1) / (2.5 - 1.25)) ** 2
    turn = np.arctan2(*offsets.T) / (2.0 * math.pi) + 0.5
    assert share.max() <= 1.0
    for uniform in (share, turn):
        assert stats.kstest(uniform, "uniform").pvalue > 0.01  # the same every time, as the seed is


PAIR = """\
workspace: {{radius: 8.0}}
regions:
  room: {{centre: [0, 0, 0], radius: 3.0}}
agents:
  a1: {{model: package://drake_ltl_models/agents/planar_arm.urdf, position: [-1.2, 0]}}
  a2: {{model: package://drake_ltl_models/agents/planar_arm.urdf, position: [{x}, 0]}}
"""


@pytest.mark.parametrize(("gap", "margin"), [(0.5, 0.05), (0.02, 0.02)])
def test_drawn_spheres_keep_a_margin(monkeypatch, gap, margin):
    """That of planning, or what the scenario's own start has of it."""
    monkeypatch.setattr(starts, "place", lambda *_: None)
    scenario = loads(PAIR.format(x=-1.2 + 2.4 + gap))
    geometry = Geometry({"a1": 1.2, "a2": 1.2}, {}, {}, {})
    rng = np.random.default_rng(1)
    drawn = [starts.draw_starts(scenario, geometry, None, rng) for _ in range(60)]
    gaps = np.array([math.dist(one["a1"], one["a2"]) - 2.4 for one in drawn])
    assert margin - 1e-12 <= gaps.min() < margin + 0.05


def test_starts_from_which_nothing_can_be_placed_are_left(shuttle_text, monkeypatch):
    from drake_ltl.errors import PlacementError

    def refuse(plan, scenario, geometry, at):
        if at.agents["a1"].p_WC[0] > -2.7:
            raise PlacementError("no", 0)

    monkeypatch.setattr(starts, "place", refuse)
    scenario = loads(shuttle_text.replace("position: [-2.5", "position: [-2.8"))
    geometry = Geometry({"a1": 1.25}, {}, {}, {})
    drawn = [starts.draw_starts(scenario, geometry, None, np.random.default_rng(k))["a1"] for k in range(50)]
    assert all(x <= -2.7 for x, _ in drawn)
    assert len(set(drawn)) > 45
