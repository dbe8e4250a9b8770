"""Files as older versions wrote them are read, and what they do not hold is said."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from drake_ltl.errors import InvalidInputError
from drake_ltl.execution.recording import Recording
from drake_ltl.execution.recording_versions import whose_potential

SAMPLES = 3
STEP = {
    "number": 0,
    "actions": [{"kind": "travel", "agents": ["a1"], "object": None, "from": "pi1", "to": "pi2"}],
    "start": 0.0,
    "duration": 1.0,
    "finished": False,
}
INTERVAL = {"step": 0, "phase": 0, "travels": {"a1": [1.0] * 4}, "transports": {}, "waiting": [], "reaches": {}}


def header_of(version: int) -> dict:
    header = {
        "format": "drake_ltl recording",
        "version": version,
        "scenario": "name: old\nseed: 12\n",
        "versions": {"drake": "1.0"},
        "agents": ["a1"],
        "objects": ["o1"],
        "agent_radius": {"a1": 1.25},
        "object_radius": {"o1": 0.5},
        "team_radius": {"o1": 2.6},
        "prefix_length": 1,
        "suffix_length": 1,
        "completed": False,
        "reason": "interrupted",
        "steps": [STEP],
    }
    return header if version == 1 else header | {"intervals": [INTERVAL]}


def arrays_of(version: int) -> dict[str, np.ndarray]:
    """As the versions 1 and 2 began: later files of version 2 have efforts and manipulabilities."""
    shapes = {"time": (), "lyapunov": (), "q/a1": (4,), "qd/a1": (4,), "centre/a1": (3,), "pose/o1": (7,)}
    shapes |= {"velocity/o1": (6,)} | ({"weld_gap": (1,), "weld_angle": (1,)} if version == 1 else {})
    arrays = {name: np.arange(float(SAMPLES * np.prod(s))).reshape(SAMPLES, *s) for name, s in shapes.items()}
    whole = {"step": (), "phase": (), "mode": (1,), "grasp": (1,)}
    return arrays | {name: np.zeros((SAMPLES, *shape), dtype=np.int64) for name, shape in whole.items()}


def write(path: Path, header: dict, arrays: dict[str, np.ndarray]) -> Path:
    text = json.dumps(header, sort_keys=True).encode()
    np.savez_compressed(path, header=np.frombuffer(text, dtype=np.uint8), **arrays)
    return path


@pytest.mark.parametrize(
    ("version", "lacks"),
    [
        (1, ("intervals", "effort", "manipulability", "gathering", "lift")),
        (2, ("effort", "manipulability", "gathering", "lift")),
    ],
)
def test_old_files_are_read(tmp_path, version, lacks):
    arrays = arrays_of(version)
    recording = Recording.load(write(tmp_path / "old.npz", header_of(version), arrays))
    assert recording.lacks == lacks
    assert recording.seed == 12
    assert len(recording.intervals) == version - 1
    np.testing.assert_array_equal(recording.q["a1"], arrays["q/a1"])
    assert recording.effort.shape == recording.manipulability.shape == (SAMPLES, 1)
    recording.save(tmp_path / "new.npz")
    assert Recording.load(tmp_path / "new.npz").lacks == lacks


def test_efforts_that_are_there_are_kept(tmp_path):
    arrays = arrays_of(2) | {name: np.full((SAMPLES, 1), 0.5) for name in ("effort", "manipulability")}
    recording = Recording.load(write(tmp_path / "old.npz", header_of(2), arrays))
    assert recording.lacks == ("gathering", "lift")
    np.testing.assert_array_equal(recording.effort, arrays["effort"])


@pytest.mark.parametrize(("text", "seed"), [("name: x", 0), ("seed: -1", 0), ("seed: [", 0), ("5", 0), ("seed: 3", 3)])
def test_seeds_of_scenarios_that_say_strange_things(tmp_path, text, seed):
    header = header_of(2) | {"scenario": text}
    assert Recording.load(write(tmp_path / "old.npz", header, arrays_of(2))).seed == seed


@pytest.mark.parametrize(("version", "name"), [(1, "weld_gap"), (1, "time"), (2, "scenario"), (2, "agents")])
def test_old_files_that_are_damaged(tmp_path, version, name):
    header, arrays = header_of(version), arrays_of(version)
    (header if name in header else arrays).pop(name)
    with pytest.raises(InvalidInputError, match=f"lacks '{name}'"):
        Recording.load(write(tmp_path / "old.npz", header, arrays))


@pytest.mark.parametrize("lacks", [["nonsense"], ["gathering"], ["lift", "gathering"], ["lift", "lift"]])
@pytest.mark.parametrize("version", [2, 6])
def test_lacks_of_no_version(tmp_path, lacks, version):
    """To lack something without what came after it would choose another V at will."""
    header, arrays = header_of(2) | {"version": version, "lacks": lacks, "seed": 0, "monitored": []}, arrays_of(2)
    arrays |= {name: np.full((SAMPLES, 1), 0.5) for name in ("effort", "manipulability")}
    with pytest.raises(InvalidInputError, match=r"lacks is \[.*\], not what recordings of some version lack"):
        Recording.load(write(tmp_path / "changed.npz", header, arrays))


@pytest.mark.parametrize(("version", "expected"), [(1, 1), (2, 4), (3, 4), (4, 4), (5, 5), (6, 6)])
def test_whose_potential(tmp_path, version, expected):
    header = header_of(min(version, 2)) | {"version": version, "seed": 0, "monitored": []}
    arrays = arrays_of(min(version, 2))
    if version > 1:
        arrays |= {name: np.full((SAMPLES, 1), 0.5) for name in ("effort", "manipulability")}
    assert whose_potential(Recording.load(write(tmp_path / "old.npz", header, arrays)).lacks) == expected
