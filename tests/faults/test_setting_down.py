"""A team whose grasp breaks in the air: who still holds the load sets it down, level, before it lets go."""

from __future__ import annotations

import numpy as np
import pytest
from pydrake.math import RigidTransform, RotationMatrix

from drake_ltl import mission
from drake_ltl.execution.leg import befallen
from drake_ltl.execution.situations import situation
from drake_ltl.faults.legs import Bodies
from drake_ltl.faults.losses import DOOR, GRIP, OBJECT, Losses
from drake_ltl.monitoring.violation import Violation
from drake_ltl.scenario import loads
from drake_ltl.systems.progress import Measurement
from drake_ltl.verification import verify

MISSION = """
name: lone_hand
workspace: {radius: 20.0}
regions:
  store: {centre: [-9.0, 0.0, 0.0], radius: 7.5}
  yard: {centre: [9.0, 0.0, 0.0], radius: 7.5}
agents:
  a1: {model: "package://drake_ltl_models/agents/planar_arm.urdf", position: [-13.4, 3.2], power: 2, radius: 1.25}
  a2: {model: "package://drake_ltl_models/agents/planar_arm.urdf", position: [-9.0, -5.3], power: 2, radius: 1.25}
objects:
  crate:
    model: package://drake_ltl_models/objects/crate.sdf
    position: [-9.0, 0.0]
    power_needed: 4
    radius: 0.5
    team_radius: 2.67
spec: "F crate.yard"
faults:
  - {kind: weld_breaks, agent: a1, step: 2}
"""


@pytest.fixture(scope="module")
def run_and_scenario():
    """a1 loses its grasp as soon as the crate comes off the floor; nobody else is left."""
    scenario = loads(MISSION)
    models = mission.measure(scenario)
    planned = mission.plan_and_place(scenario, models)
    return mission.simulate(planned, scenario, models, announce=lambda line: None), scenario


def test_the_run_ends_with_the_reason_and_nothing_else_is_wrong(run_and_scenario):
    run, scenario = run_and_scenario
    assert "a1 cannot grasp any more: no run" in run.recording.reason
    assert run.recording.monitored == ()
    assert {violation.kind for violation in verify(run.recording, scenario).violations} == {"run"}


def test_it_lies_flat_before_anybody_lets_go(run_and_scenario):
    recording = run_and_scenario[0].recording
    pose = recording.pose["crate"]
    held = (recording.grasp == 0).any(axis=1)
    let_go = len(held) - int(np.argmax(held[::-1]))
    assert pose[:let_go, 6].max() > 0.25 + 0.02  # it was in the air
    tilt = 2.0 * np.hypot(pose[:, 1], pose[:, 2])
    assert np.rad2deg(tilt[let_go]) < 0.05
    assert np.rad2deg(tilt.max()) < 2.0  # nor did it sag meanwhile: with nobody to bear it by 3 degrees
    assert abs(pose[let_go, 6] - 0.25) < 5e-4
    turned = 2.0 * pose[-1, 3]
    assert abs(np.rad2deg(turned)) < 0.05  # who cannot turn can grasp it again, at 0.1 degrees


@pytest.mark.parametrize(("degrees", "stuck"), [(0.05, False), (0.2, True)])
def test_what_is_turned_by_more_than_welds_may_be_off_nobody_grasps_who_cannot_turn(degrees, stuck):
    scenario = loads(MISSION)
    models = mission.measure(scenario)
    turned = RigidTransform(RotationMatrix.MakeZRotation(np.deg2rad(degrees)), [-9.0, 0.0, 0.25])
    q = {agent.name: np.array([x, 5.0, 0.5, 1.0]) for agent, x in zip(scenario.agents, (-12.0, -6.0), strict=True)}
    qd = {name: np.zeros(4) for name in q}
    now = Measurement(1.0, q, qd, {"crate": turned}, {"crate": np.zeros(6)})
    seen = situation(Bodies(scenario, models, now), Losses())
    assert ("crate" in seen.stuck) == stuck


def test_all_whom_faults_befell_are_named():
    def seen(monitor: str, *who: str) -> Violation:
        return Violation(monitor, 1.0, 1, who, "")

    found = befallen([seen(GRIP, "a2", "crate"), seen(DOOR, "yard"), seen(OBJECT, "crate"), seen(GRIP, "a1", "crate")])
    assert found == ("a2", "crate", "a1")
