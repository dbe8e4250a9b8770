"""`drake-ltl simulate` on a mission of seconds."""

from __future__ import annotations

import json
import re

import pytest

from drake_ltl.cli import simulate
from drake_ltl.execution.recording import Recording

KEYS = {
    "satisfied",
    "violations",
    "word",
    "steps",
    "min_clearance",
    "max_lyapunov_increase",
    "max_weld_error",
    "simulated_seconds",
    "wall_seconds",
    "realtime_factor",
}


def read(path) -> dict:
    data = json.loads(path.read_text(encoding="utf-8"))
    assert set(data) == KEYS
    return data


def test_everything_is_written(drake_ltl, shuttle_file, tmp_path):
    out = tmp_path / "out"
    result = drake_ltl(
        "simulate",
        shuttle_file,
        *("--json", tmp_path / "verdict.json"),
        *("--recording", tmp_path / "run.npz"),
        *("--record", tmp_path / "page.html"),
        *("--graphviz", tmp_path / "systems.dot"),
        *("--report", out / "deep"),
    )
    assert result.status == 0, result.err
    assert "SATISFIED" in result.out
    data = read(tmp_path / "verdict.json")
    assert data["satisfied"] is True
    assert data["violations"] == []
    assert data["word"] == [["a1.near"], ["a1.far"], ["a1.near"]]
    assert set(data["min_clearance"]) == {"agent_agent", "agent_object", "team_other", "forbidden_region"}
    assert [set(step) for step in data["steps"]] == [{"actions", "start", "duration"}] * 2
    assert data["simulated_seconds"] > 1.0
    assert data["wall_seconds"] > 0.0
    assert data["realtime_factor"] == pytest.approx(data["simulated_seconds"] / data["wall_seconds"])
    report = out / "deep"
    assert read(report / "verdict.json") == data
    assert json.loads((report / "plan.json").read_text(encoding="utf-8"))["status"] == "optimal"
    assert (report / "recording.npz").read_bytes() == (tmp_path / "run.npz").read_bytes()
    figures = {path.name for path in (report / "figures").iterdir()}
    assert {name.removesuffix(".svg") for name in figures if name.endswith(".svg")} == {
        name.removesuffix(".pdf") for name in figures if name.endswith(".pdf")
    }
    assert {"map.pdf", "step_02.pdf", "steps.pdf", "clearances.pdf", "lyapunov.pdf", "automaton_1.pdf"} <= figures
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "<html" in page.lower()
    assert "mission_controller" in (tmp_path / "systems.dot").read_text(encoding="utf-8")


def test_what_was_simulated_can_be_verified(drake_ltl, shuttle_file, tmp_path):
    rounds = drake_ltl("simulate", shuttle_file, "--suffix-rounds", "2", "--recording", tmp_path / "run.npz")
    assert rounds.status == 0
    assert len(Recording.load(tmp_path / "run.npz").steps) == 4
    result = drake_ltl("verify", tmp_path / "run.npz", "--json", tmp_path / "verdict.json")
    assert result.status == 0
    assert "SATISFIED" in result.out
    data = read(tmp_path / "verdict.json")
    assert data["satisfied"] is True
    assert data["wall_seconds"] is data["realtime_factor"] is None  # which no recording knows
    report = drake_ltl("view", tmp_path / "run.npz", "--report", tmp_path)
    assert (report.status, report.err) == (0, "")
    assert report.out.replace("\n", "") == f"wrote {tmp_path / 'report.html'}"
    assert "shuttle: report" in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert read(tmp_path / "verdict.json") == data
    assert (tmp_path / "figures" / "step_04.pdf").read_bytes().startswith(b"%PDF-")


def test_a_run_that_fails_is_violated(drake_ltl, shuttle_file, tmp_path):
    text = shuttle_file.read_text(encoding="utf-8") + "simulation: {step_time_limit: 1.0}\n"
    shuttle_file.write_text(text, encoding="utf-8")
    result = drake_ltl(
        "simulate", shuttle_file, "--json", tmp_path / "verdict.json", "--recording", tmp_path / "run.npz"
    )
    assert result.status == 1
    assert "VIOLATED" in result.out
    data = read(tmp_path / "verdict.json")
    assert data["satisfied"] is False
    assert any("did not finish within 1 s: a1" in violation for violation in data["violations"])
    assert drake_ltl("verify", tmp_path / "run.npz").status == 1


def test_an_interrupted_run_is_kept_and_judged(drake_ltl, shuttle_file, tmp_path, monkeypatch):
    def reporter(bar):
        def report(progress):
            if progress.time >= 1.0:
                raise KeyboardInterrupt

        return report

    monkeypatch.setattr(simulate, "_reporter", reporter)
    result = drake_ltl("simulate", shuttle_file, "--recording", tmp_path / "run.npz")
    assert result.status == 130
    assert result.err == "interrupted\n"
    assert "interrupted" in result.out
    assert Recording.load(tmp_path / "run.npz").reason == "interrupted"


def test_what_cannot_be_is_infeasible(drake_ltl, shuttle_file, tmp_path):
    text = shuttle_file.read_text(encoding="utf-8").replace("GF near", "G !near")
    shuttle_file.write_text(text, encoding="utf-8")
    result = drake_ltl("simulate", shuttle_file, "--json", tmp_path / "verdict.json")
    assert result.status == 1
    reason, *clash = result.err.splitlines()
    assert reason.startswith("infeasible: ")
    assert clash
    data = read(tmp_path / "verdict.json")
    assert data["satisfied"] is False
    assert len(data["violations"]) == 1
    assert {key for key in KEYS if data[key] is None} == KEYS - {"satisfied", "violations"}


CRAMPED = """\
workspace: {radius: 20.0}
regions:
  near: {centre: [-6.0, 0.0, 0.0], radius: 4.0}
  far: {centre: [6.0, 0.5, 0.0], radius: 4.0}
agents:
  a1: {model: package://drake_ltl_models/agents/planar_arm.urdf, position: [-7.0, 0.0], heading: 0.0}
  a2: {model: package://drake_ltl_models/agents/planar_arm.urdf, position: [5.0, 2.0], heading: 0.0}
objects:
  crate:
    model: package://drake_ltl_models/objects/crate.sdf
    position: [-5.0, -2.0]
    power_needed: 2
    spec: "F far"
"""


def test_bodies_without_places_are_not_a_formula_s_fault(drake_ltl, tmp_path):
    """Both robots would have to stand in line with the crate, which is too near to the region's border."""
    path = tmp_path / "cramped.yaml"
    path.write_text(CRAMPED, encoding="utf-8")
    assert drake_ltl("plan", path).status == 0
    result = drake_ltl("simulate", path, "--json", tmp_path / "verdict.json")
    assert result.status == 1
    (line,) = result.err.splitlines()
    assert re.match(r"no plan: no places for the bodies were found in any of the \d+ plans tried; ", line)
    assert re.search(r"the cheapest fails at step \d+ \(.*grasps crate in near.*\), whatever places are tried: ", line)
    assert "formula" not in line
    assert read(tmp_path / "verdict.json")["violations"] == [line.removeprefix("no plan: ")]


def test_bad_input(drake_ltl, shuttle_file):
    text = shuttle_file.read_text(encoding="utf-8").replace("power: 1", "power: -1")
    shuttle_file.write_text(text, encoding="utf-8")
    result = drake_ltl("simulate", shuttle_file)
    assert result.status == 2
    assert result.err.startswith("agents.a1.power: ")
    assert len(result.err.splitlines()) == 1


def test_a_model_that_cannot_be_used(drake_ltl, shuttle_file, tmp_path, examples):
    urdf = (examples.parent / "models" / "agents" / "planar_arm.urdf").read_text(encoding="utf-8")
    (tmp_path / "arm.urdf").write_text(urdf.replace('<frame name="grasp"', '<frame name="hand"'), encoding="utf-8")
    text = shuttle_file.read_text(encoding="utf-8")
    text = text.replace("package://drake_ltl_models/agents/planar_arm.urdf", "arm.urdf")
    shuttle_file.write_text(text, encoding="utf-8")
    result = drake_ltl("simulate", shuttle_file)
    assert result.status == 2
    (line,) = result.err.splitlines()
    assert line.startswith("agents.a1.model: arm.urdf has no frame 'grasp'")


@pytest.mark.parametrize("option", ["--json", "--recording", "--record", "--graphviz"])
def test_outputs_are_checked_before_the_work(drake_ltl, tmp_path, option):
    result = drake_ltl("simulate", tmp_path / "nothing.yaml", option, tmp_path / "no" / "file")
    assert result.status == 2
    assert "there is no folder" in result.err


def test_a_report_needs_a_folder(drake_ltl, shuttle_file):
    result = drake_ltl("simulate", shuttle_file, "--report", shuttle_file)
    assert result.status == 2
    assert str(shuttle_file) in result.err
    assert len(result.err.splitlines()) == 1


@pytest.mark.parametrize("output", ["--record", "--graphviz"])
def test_a_disk_that_is_full(drake_ltl, shuttle_file, output):
    result = drake_ltl("simulate", shuttle_file, output, "/dev/full")
    assert result.status == 2
    assert result.err.splitlines()[-1] == "/dev/full: No space left on device"


def test_bad_input_leaves_no_folder(drake_ltl, tmp_path):
    result = drake_ltl("simulate", tmp_path / "nothing.yaml", "--report", tmp_path / "out" / "deep")
    assert result.status == 2
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("rounds", ["0", "-1", "many", "1.5", "1000000", "9" * 5000])
def test_rounds_that_are_none(drake_ltl, shuttle_file, rounds):
    result = drake_ltl("simulate", shuttle_file, "--suffix-rounds", rounds)
    assert result.status == 2
    assert f"{rounds!r} is not a whole number from 1 to 100000" in result.err


def test_options_of_live_pages_need_one(drake_ltl, shuttle_file):
    result = drake_ltl("simulate", shuttle_file, "--realtime-rate", "2", "--meshcat-host", "localhost")
    assert result.status == 2
    assert result.err.splitlines() == [
        "--meshcat-host: has nothing to show; add --meshcat",
        "--realtime-rate: has nothing to show; add --meshcat",
    ]
