"""`drake-ltl plan`."""

from __future__ import annotations

import json
import signal

import pytest

from drake_ltl.cli import planning

PLAN_KEYS = {
    "scenario",
    "status",
    "prefix_cost",
    "suffix_cost",
    "cost",
    "lower_bound",
    "prefix",
    "suffix",
    "steps",
    "counts",
    "seconds",
}
COUNTS = {"ts_states", "ts_transitions", "automaton_states", "automaton_edges", "product_states"}
SECONDS = {"transition_system", "automaton", "search", "total"}
NO_PLAN = {"prefix_cost", "suffix_cost", "cost", "lower_bound", "prefix", "suffix", "steps"}
PUBLISHED = "fits: {agent: 1.25, grasping: 2.5, object: 0.5, capacity: 5.75}"


def read(path) -> dict:
    data = json.loads(path.read_text(encoding="utf-8"))
    assert set(data) == PLAN_KEYS
    assert set(data["counts"]) == COUNTS
    assert set(data["seconds"]) == SECONDS
    return data


@pytest.mark.parametrize(
    ("case", "prefix", "suffix", "states"),
    [("case_i", 10080, 4848, 560), ("case_ii", 4941, 2886, 3112)],
)
def test_the_paper_s_examples(drake_ltl, examples, tmp_path, case, prefix, suffix, states):
    result = drake_ltl("plan", examples / f"{case}.yaml", "--json", tmp_path / "plan.json")
    assert result.status == 0
    assert result.err == ""
    data = read(tmp_path / "plan.json")
    assert (data["scenario"], data["status"]) == (case, "optimal")
    assert (data["prefix_cost"], data["suffix_cost"], data["cost"]) == (prefix, suffix, prefix + suffix)
    assert data["lower_bound"] == data["cost"]
    assert data["counts"]["ts_states"] == states
    assert len(data["steps"]) == len(data["prefix"]) + len(data["suffix"])
    for state in (*data["prefix"], *data["suffix"]):
        assert set(state) == {"agents", "objects", "grasps"}
        assert set(state["agents"]) == set(state["grasps"])
    for action in (action for actions in data["steps"] for action in actions):
        assert set(action) == {"kind", "agents", "object", "from", "to"}
    assert all(seconds >= 0.0 for seconds in data["seconds"].values() if seconds is not None)
    assert case in result.out
    assert "optimal" in result.out
    assert "not checked: whether the bodies find places" in result.out


def test_geometric_fits_are_measured(drake_ltl, changed, tmp_path):
    result = drake_ltl("plan", changed({PUBLISHED: "fits: geometric"}), "--json", tmp_path / "plan.json")
    assert result.status == 0
    assert read(tmp_path / "plan.json")["status"] == "optimal"


def test_radii_smaller_than_the_bodies_are_refused_where_models_are_loaded(drake_ltl, changed):
    """The published rule counts bodies and asks for no radius: with all of them stated no model is loaded."""
    small = {"team_radius: 2.67": "team_radius: 2.0"}
    assert drake_ltl("plan", changed(small)).status == 0
    result = drake_ltl("plan", changed({**small, PUBLISHED: "fits: geometric"}))
    assert result.status == 2
    (line,) = result.err.splitlines()
    assert line.startswith("team_radius: 2.0 is less than the 2.6339 m that who grasps o1")
    assert line.endswith("write at least 2.664, or leave it out")


def test_what_cannot_be_is_infeasible(drake_ltl, changed, tmp_path):
    path = changed({'spec: "GF pi3"': 'spec: "GF pi3 & G !pi3"'})
    result = drake_ltl("plan", path, "--json", tmp_path / "plan.json")
    assert result.status == 1
    assert result.out == ""
    reason, *clash = result.err.splitlines()
    assert reason.startswith("infeasible: ")
    assert [line for line in clash if "o2: GF pi3" in line]
    assert [line for line in clash if "o2: G !pi3" in line]
    assert all(line.startswith("  ") for line in clash)
    data = read(tmp_path / "plan.json")
    assert data["status"] == "infeasible"
    assert {key for key in PLAN_KEYS if data[key] is None} == NO_PLAN
    assert set(data["counts"].values()) == set(data["seconds"].values()) == {None}


def test_time_runs_out(drake_ltl, changed, tmp_path):
    """Less than it takes to build a transition system."""
    result = drake_ltl("plan", changed({}), "--time-limit", "0.001", "--json", tmp_path / "plan.json")
    assert result.status == 1
    (line,) = result.err.splitlines()
    assert "time limit of 0.001 s" in line
    assert read(tmp_path / "plan.json")["status"] == "unknown"


def test_time_does_not_run_out_later(drake_ltl, shuttle_file):
    """The alarm is off once the plan is found."""
    assert drake_ltl("plan", shuttle_file, "--time-limit", "60").status == 0
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    assert signal.getsignal(signal.SIGALRM) is signal.SIG_DFL


@pytest.mark.parametrize("seconds", ["0", "-1", "nan", "inf", "soon"])
def test_time_limits_that_are_none(drake_ltl, shuttle_file, seconds):
    result = drake_ltl("plan", shuttle_file, "--time-limit", seconds)
    assert result.status == 2
    assert f"{seconds!r} is not a number of seconds above 0" in result.err


def test_a_file_without_a_name(drake_ltl, shuttle_file):
    for arguments in (("plan", ""), ("plan", shuttle_file, "--json", ""), ("simulate", " "), ("verify", "")):
        result = drake_ltl(*arguments)
        assert result.status == 2
        assert "the name is empty" in result.err


def test_methods(drake_ltl, shuttle_file):
    assert drake_ltl("plan", shuttle_file, "--method", "explicit").status == 0
    result = drake_ltl("plan", shuttle_file, "--method", "guess")
    assert result.status == 2
    assert "'guess'" in result.err


def test_every_mistake_has_its_line(drake_ltl, changed):
    path = changed(
        {"power: 4": "power: -4", "radius: 30.0": "radius: nan", "seed: 0": "sede: 0", '"G !pi3"': '"G !pi9"'}
    )
    result = drake_ltl("plan", path)
    assert result.status == 2
    assert result.out == ""
    lines = result.err.splitlines()
    for where in ("agents.a2.power", "workspace.radius", "sede", "agents.a1.spec"):
        assert sum(line.startswith(where) for line in lines) == 1, where
    assert len(lines) == 4


@pytest.mark.parametrize("content", ["", "- 1", "name: [", "\x00", "name: x\n"])
def test_files_that_are_no_scenario(drake_ltl, tmp_path, content):
    path = tmp_path / "bad.yaml"
    path.write_text(content, encoding="utf-8")
    result = drake_ltl("plan", path)
    assert result.status == 2
    assert result.err
    assert result.out == ""


def test_a_file_that_is_not_there(drake_ltl, tmp_path):
    for path in (tmp_path / "nothing.yaml", tmp_path):
        result = drake_ltl("plan", path)
        assert result.status == 2
        (line,) = result.err.splitlines()
        assert str(path) in line


def test_outputs_are_checked_before_the_work(drake_ltl, tmp_path):
    """Also before the scenario is looked at."""
    result = drake_ltl("plan", tmp_path / "nothing.yaml", "--json", tmp_path / "no" / "plan.json")
    assert result.status == 2
    assert "there is no folder" in result.err
    result = drake_ltl("plan", tmp_path / "nothing.yaml", "--json", tmp_path)
    assert result.status == 2
    assert "is a folder" in result.err


def test_a_disk_that_is_full(drake_ltl, shuttle_file):
    result = drake_ltl("plan", shuttle_file, "--json", "/dev/full")
    assert result.status == 2
    assert result.err == "/dev/full: No space left on device\n"


def test_starts_are_checked(drake_ltl, changed):
    result = drake_ltl("plan", changed({"position: [0.5, 0.0]": "position: [7.5, 0.0]"}))
    assert result.status == 2
    (line,) = result.err.splitlines()
    assert line.startswith("agents.a1.position: ")


def test_interruption(drake_ltl, shuttle_file, monkeypatch):
    def interrupted(*args, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(planning, "plan_by", interrupted)
    result = drake_ltl("plan", shuttle_file)
    assert result.status == 130
    assert result.err == "interrupted\n"


def test_all_outputs(drake_ltl, examples, tmp_path):
    result = drake_ltl("plan", examples / "case_ii.yaml", "--outputs", tmp_path / "deep" / "folder")
    assert (result.status, result.err) == (0, "")
    names = {path.name for path in (tmp_path / "deep" / "folder").iterdir()}
    assert names == {"plan.json", "plan.txt", "plan.dot", "projections.json", "automaton.hoa"}


def test_outputs_that_cannot_be_written_are_refused_before_planning(drake_ltl, examples, tmp_path):
    (tmp_path / "file").touch()
    result = drake_ltl("plan", examples / "case_ii.yaml", "--outputs", tmp_path / "file")
    assert (result.status, result.out) == (2, "")
    assert len(result.err.splitlines()) == 1
