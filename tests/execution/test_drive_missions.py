"""A whole mission of a differential drive, with a model of the user's own, and an arm: carried out and judged."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from drake_ltl.mission import measure, plan_and_place, simulate
from drake_ltl.scenario import loads
from drake_ltl.scenario.model_files import resolve
from drake_ltl.verification import verify

pytestmark = pytest.mark.mission

TEXT = """
name: change_places
workspace: {radius: 7.0}
regions:
  pi1: {centre: [-2.5, 0, 0], radius: 2.4}
  pi2: {centre: [2.5, 0, 0], radius: 2.4}
agents:
  a1:
    model: package://drake_ltl_models/agents/planar_arm.urdf
    position: [-2.6, 0.2]
    spec: "F pi2"
  a2:
    model: MODEL
    position: [2.2, 0.3]
    heading: 2.5
    headings: {pi1: -1.5}
    spec: "F pi1"
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Recording and verdict: the drive is twice as heavy as the shipped one, and weaker."""
    path = tmp_path_factory.mktemp("models") / "own.urdf"
    text = resolve("package://drake_ltl_models/bases/differential_drive.urdf").read_text()
    path.write_text(text.replace('mass value="8"', 'mass value="16"').replace('effort="2.5"', 'effort="1.0"'))
    scenario = loads(TEXT.replace("MODEL", path.name), base=path.parent)
    scenario = dataclasses.replace(scenario, source=TEXT.replace("MODEL", str(path)))
    models = measure(scenario)
    recording = simulate(plan_and_place(scenario, models), scenario, models).recording
    return recording, scenario, verify(recording, scenario)


def test_all_promises_hold(run):
    recording, _, verdict = run
    assert verdict.satisfied, verdict.violations
    assert verdict.max_lyapunov_increase <= 1e-7  # a tenth of what counts
    assert verdict.min_clearance["agent_agent"] > 0.05
    assert verdict.max_arrival_turn < 0.03
    assert verdict.max_slide < 1e-3  # tyres creep: regularised friction
    assert verdict.max_effort["a2"] <= 1.0
    assert set(verdict.min_manipulability) == {"a1"}
    assert np.abs(recording.qd["a2"][:, :2]).max() > 0.3  # it did go there


def test_its_wheels_roll(run):
    """Speed of each tyre over the floor: of the axle above the wheel, less what the wheel rolls."""
    recording, scenario, _ = run
    drive = measure(scenario).agents["a2"].drive
    q, qd = recording.q["a2"], recording.qd["a2"]
    v = np.cos(q[:, 2]) * qd[:, 0] + np.sin(q[:, 2]) * qd[:, 1]
    for side, wheel in ((-1.0, qd[:, 6]), (1.0, qd[:, 7])):
        slip = v + side * drive.half_track * qd[:, 2] - drive.wheel_radius * (wheel + qd[:, 4])
        assert np.abs(slip[1:]).max() < 2e-3  # regularised friction creeps


def test_a_drive_that_slides_is_found_out(run):
    """Positions and velocities agree, but no tyre moves so."""
    recording, scenario, _ = run
    q, qd = recording.q["a2"].copy(), recording.qd["a2"].copy()
    ramp = 0.02 * np.sin(np.linspace(0.0, np.pi, len(q))) ** 2 * 5.0
    q[:, 1] += ramp
    qd[:, 1] += np.diff(ramp, prepend=0.0) / 0.005
    forged = dataclasses.replace(
        recording, q=recording.q | {"a2": q}, qd=recording.qd | {"a2": qd}, centre=recording.centre
    )
    said = [str(violation) for violation in verify(forged, scenario).violations]
    assert any("a2 moves across its heading" in text for text in said)


def test_so_is_one_that_faces_elsewhere(run):
    recording, scenario, _ = run
    arm, drive = scenario.agents
    told = dataclasses.replace(scenario, agents=(arm, dataclasses.replace(drive, headings={"pi1": -1.4})))
    kinds = {violation.kind for violation in verify(recording, told).violations}
    assert kinds == {"drive"}
