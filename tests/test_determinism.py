"""The same scenario and seed give the same bytes, in whatever order Python's sets and hashes come."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

HASH_SEEDS = ("1", "2024")

SCENARIO = """
name: fetch
workspace: {radius: 14}
regions:
  pi1: {centre: [-4, 0, 0], radius: 3}
  pi2: {centre: [4, 0, 0], radius: 3}
  pi3: {centre: [0, 8, 0], radius: 3}
agents:
  a1: {model: package://drake_ltl_models/agents/planar_arm.urdf, position: [-4, 1], spec: GF pi2 & G !pi3}
  a2: {model: package://drake_ltl_models/agents/planar_arm.urdf, position: [4, 1], spec: F pi1 | F pi3}
objects:
  o1: {model: package://drake_ltl_models/objects/crate.sdf, position: [-4, -1.2], spec: F pi2}
seed: 3
simulation: {time_step: 0.01}
"""

PROGRAM = """
import json, sys
from pathlib import Path
from drake_ltl.mission import measure, plan_and_place, simulate
from drake_ltl.planning.methods import plan_by
from drake_ltl.planning.plan_json import plan_to_json
from drake_ltl.scenario import load

folder = Path(sys.argv[1])
scenario = load(folder / "fetch.yaml")
models = measure(scenario)
mission = plan_and_place(scenario, models)

def report(progress):
    if progress.time >= 1.0:
        raise KeyboardInterrupt

run = simulate(mission, scenario, models, report=report)
run.recording.save(folder / f"{sys.argv[2]}.npz")
(folder / f"{sys.argv[2]}.json").write_text(json.dumps(plan_to_json(mission.plan, scenario)))
"""


@pytest.fixture(scope="module")
def runs(tmp_path_factory) -> Path:
    """A folder with the plan and one second of the run, once for each hash seed."""
    folder = tmp_path_factory.mktemp("runs")
    (folder / "fetch.yaml").write_text(SCENARIO, encoding="utf-8")
    for seed in HASH_SEEDS:
        environment = os.environ | {"PYTHONHASHSEED": seed}
        subprocess.run([sys.executable, "-c", PROGRAM, folder, seed], env=environment, check=True)
    return folder


def test_plans(runs):
    one, other = (json.loads((runs / f"{seed}.json").read_text(encoding="utf-8")) for seed in HASH_SEEDS)
    assert one.pop("seconds").keys() == other.pop("seconds").keys()
    assert json.dumps(one) == json.dumps(other)
    assert one["steps"]


def test_recordings(runs):
    one, other = ((runs / f"{seed}.npz").read_bytes() for seed in HASH_SEEDS)
    assert one == other


def test_a_recording_says_what_it_is_of(runs):
    with np.load(runs / f"{HASH_SEEDS[0]}.npz") as archive:
        header = json.loads(archive["header"].tobytes())
        assert len(archive["time"]) > 40
    assert header["scenario"] == SCENARIO
    assert header["seed"] == 3
    assert {"drake_ltl", "drake", "numpy"} <= set(header["versions"])
