"""`drake-ltl simulate` when a monitor sees something: it says what, and that the run is violated."""

from __future__ import annotations

import json
import re

import pytest

from drake_ltl.execution.recording import Recording
from drake_ltl.systems import mission_controller

LINE = re.compile(r"the lyapunov monitor saw: step 1, 0\.\d{3} s: V rises, relative to its start: \S+ \(limit 1e-06\)")


@pytest.fixture
def upwards(monkeypatch):
    """Travellers go up the navigation function."""
    right = mission_controller.transition_torque
    monkeypatch.setattr(mission_controller, "transition_torque", lambda g, slope, K, qd: right(g, -slope, K, qd))


def in_one_line(text: str) -> str:
    return " ".join(text.split())


def test_the_first_thing_ends_the_run(drake_ltl, shuttle_file, tmp_path, upwards):
    path = tmp_path / "run.npz"
    result = drake_ltl("simulate", shuttle_file, "--recording", path, "--json", tmp_path / "verdict.json")
    assert result.status == 1
    assert LINE.search(in_one_line(result.err))
    assert "VIOLATED" in result.out
    (seen,) = Recording.load(path).monitored
    violations = json.loads((tmp_path / "verdict.json").read_text(encoding="utf-8"))["violations"]
    assert any(violation.endswith(f"the run ended early: a monitor saw: {seen}") for violation in violations)
    assert drake_ltl("verify", path).status == 1


def test_keep_going(drake_ltl, shuttle_file, tmp_path, upwards):
    path = tmp_path / "run.npz"
    shuttle_file.write_text(
        shuttle_file.read_text(encoding="utf-8") + "simulation: {step_time_limit: 1.0}\n", encoding="utf-8"
    )
    result = drake_ltl("simulate", shuttle_file, "--keep-going", "--recording", path)
    assert result.status == 1
    assert len(LINE.findall(in_one_line(result.err))) == 1
    recording = Recording.load(path)
    assert recording.time[-1] > recording.monitored[0].time + 0.2
    assert f"the {recording.monitored[0].monitor} monitor saw" in in_one_line(result.out)


def test_a_host_that_is_none(drake_ltl, shuttle_file):
    result = drake_ltl("simulate", shuttle_file, "--meshcat", "--meshcat-host", "203.0.113.9")
    assert result.status == 2
    assert "argument --meshcat-host: '203.0.113.9' is no address of this computer" in result.err
