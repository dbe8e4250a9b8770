"""`drake-ltl verify` on good, bad and damaged files."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is empty"),
        (b"hello", "is not a recording"),
        (b"PK\x03\x04 and no more", "is a damaged archive"),
        (b"name: case_ii\n", "is not a recording"),
    ],
)
def test_damaged_files(drake_ltl, tmp_path, content, words):
    path = tmp_path / "run.npz"
    path.write_bytes(content)
    result = drake_ltl("verify", path, "--json", tmp_path / "verdict.json")
    assert result.status == 2
    (line,) = result.err.splitlines()
    assert line.startswith(f"{path}: {words}")
    assert not (tmp_path / "verdict.json").exists()


def test_a_file_that_is_not_there(drake_ltl, tmp_path):
    result = drake_ltl("verify", tmp_path / "nothing.npz")
    assert result.status == 2
    assert "No such file" in result.err


def test_outputs_are_checked_first(drake_ltl, tmp_path):
    result = drake_ltl("verify", tmp_path / "nothing.npz", "--json", tmp_path / "no" / "verdict.json")
    assert result.status == 2
    assert "there is no folder" in result.err


@pytest.mark.mission
def test_case_ii(drake_ltl, case_ii_run, tmp_path):
    case_ii_run.recording.save(tmp_path / "run.npz")
    result = drake_ltl("verify", tmp_path / "run.npz", "--json", tmp_path / "verdict.json")
    assert result.status == 0
    data = json.loads((tmp_path / "verdict.json").read_text(encoding="utf-8"))
    assert data["satisfied"] is True
    assert data["min_clearance"]["agent_agent"] > 0.0


@pytest.mark.mission
def test_case_ii_with_a_body_moved(drake_ltl, case_ii_run, tmp_path):
    """One agent's way put across another's: found on the poses, whatever the recording says else."""
    recording = case_ii_run.recording
    centre = dict(recording.centre) | {"a3": recording.centre["a2"] + np.array([0.3, 0.0, 0.0])}
    dataclasses.replace(recording, centre=centre).save(tmp_path / "run.npz")
    result = drake_ltl("verify", tmp_path / "run.npz")
    assert result.status == 1
    assert "a2 and a3 overlap" in result.out


@pytest.mark.mission
def test_a_scenario_that_is_damaged(drake_ltl, case_ii_run, tmp_path):
    text = case_ii_run.recording.scenario.replace("power: 4", "power: -4")
    dataclasses.replace(case_ii_run.recording, scenario=text).save(tmp_path / "run.npz")
    result = drake_ltl("verify", tmp_path / "run.npz")
    assert result.status == 2
    assert "agents.a2.power" in result.err
    assert len(result.err.splitlines()) == 1
