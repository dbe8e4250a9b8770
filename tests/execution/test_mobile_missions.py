"""Mobile manipulators carry: with a planar arm, with each other, and as somebody else's file."""

from __future__ import annotations

import numpy as np
import pytest
from drake_ltl.models import package_xml

from drake_ltl.mission import measure, plan_and_place, simulate
from drake_ltl.multibody import AgentModel
from drake_ltl.scenario import loads
from drake_ltl.verification import verify
from drake_ltl.verification.poses import rotations

pytestmark = pytest.mark.mission

ERRAND = """\
name: errand
workspace: {{radius: 20.0}}
regions:
  near: {{centre: [-7.5, 0.0, 0.0], radius: 6.5}}
  far: {{centre: [7.0, 0.5, 0.0], radius: 6.0}}
agents:
  a1: {{model: {first}, position: [-10.0, 2.5]}}
  a2: {{model: {second}, position: [5.0, 2.0]}}
objects:
  crate:
    model: package://drake_ltl_models/objects/crate.sdf
    position: [-7.0, 0.0]
    power_needed: 2
    spec: "GF near & GF far"
"""
PLANAR, SIX, SEVEN = (
    f"package://drake_ltl_models/agents/{name}.urdf"
    for name in ("planar_arm", "mobile_manipulator", "mobile_manipulator_7")
)


def carried_out(first: str, second: str, base=None):
    """(recording, verdict, agents' models) of the errand."""
    scenario = loads(ERRAND.format(first=first, second=second), base=base)
    models = measure(scenario)
    run = simulate(plan_and_place(scenario, models), scenario, models)
    return run.recording, verify(run.recording, scenario), models.agents


@pytest.mark.parametrize("team", [(PLANAR, SIX), (SIX, SIX), (SIX, SEVEN)], ids=["mixed", "two alike", "six and seven"])
def test_teams_carry(team):
    recording, verdict, agents = carried_out(*team)
    assert verdict.satisfied, [str(violation) for violation in verdict.violations]
    assert sum(action["kind"] == "transport" for step in recording.steps for action in step.actions) == 2
    assert verdict.max_lyapunov_increase <= 1e-6
    carrying = (recording.mode >= 3).all(axis=1)
    assert_lifted(recording)
    for name, model in agents.items():
        if model.is_redundant:
            assert_at_ease(model, recording.q[name], carrying)


def assert_lifted(recording) -> None:
    """Once it is lifted, no foot of the crate touches the floor on the way, however it tilts."""
    feet = np.array([[x, y, -0.25] for x in (-0.2, 0.2) for y in (-0.2, 0.2)])
    for step in recording.steps[-2:]:
        now = recording.step == step.number
        pose, time = recording.pose["crate"][now], recording.time[now]
        away = np.linalg.norm(pose[:, 4:6] - pose[-1, 4:6], axis=1)
        under_way = pose[(time >= time[0] + 0.5) & (away >= 0.3)]
        low = under_way[:, 6] + (rotations(under_way).as_matrix()[:, 2] @ feet.T).min(axis=1)
        assert low.min() > 2e-3  # [m], what contact may give way


def assert_at_ease(model: AgentModel, q: np.ndarray, carrying: np.ndarray) -> None:
    """It stays far from singularities and from the limits of its joints, and comes back to the posture of its grasp."""
    w = np.array([model.manipulability(row) for row in q[carrying]])
    assert w.min() > 0.8 * w[0]
    lower, upper = model.arm_limits
    inside = np.minimum(q[carrying][:, 2:] - lower, upper - q[carrying][:, 2:])
    assert np.all(inside[:, 1:] > 0.1)  # [rad]; the base's yaw has no limits
    for before, after in _transports(carrying):
        np.testing.assert_allclose(q[after, 2:], q[before, 2:], atol=0.03)  # [rad], the tolerance of joints' goals


def _transports(carrying: np.ndarray) -> list[tuple[int, int]]:
    """First and last sample of each."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], carrying, [False]]).astype(int)))
    return [(begin, end - 1) for begin, end in edges.reshape(-1, 2)]


FOREIGN = {
    '<joint name="yaw"': '<joint name="theta"',  # both the joint and its transmission
    'upper="0.9"': 'upper="1.0"',
    '<drake:rotor_inertia value="2e-6"/>': '<drake:rotor_inertia value="1e-6"/>',
    '<mass value="4"/>': '<mass value="3"/>',
}


def test_somebody_else_s_file_carries(tmp_path):
    """Named and weighed otherwise, next to the scenario."""
    text = (package_xml().parent / "agents" / "mobile_manipulator.urdf").read_text(encoding="utf-8")
    for old, new in FOREIGN.items():
        assert old in text, old
        text = text.replace(old, new)
    (tmp_path / "robot.urdf").write_text(text, encoding="utf-8")
    _, verdict, agents = carried_out("robot.urdf", PLANAR, base=tmp_path)
    assert agents["a1"].joint_names[2] == "theta"
    assert verdict.satisfied, [str(violation) for violation in verdict.violations]


def test_torques_at_their_limits_are_reported(tmp_path):
    """Motors of the base too weak for what the control laws ask: the plant cuts off, and the recording says so."""
    text = (package_xml().parent / "agents" / "mobile_manipulator.urdf").read_text(encoding="utf-8")
    assert text.count('effort="300"') == 2
    (tmp_path / "weak.urdf").write_text(text.replace('effort="300"', 'effort="12"'), encoding="utf-8")
    recording, verdict, agents = carried_out("weak.urdf", PLANAR, base=tmp_path)
    np.testing.assert_array_equal(agents["a1"].effort_limits[:2], [12.0, 12.0])
    assert verdict.max_effort["a1"] > 1.0 >= verdict.max_effort["a2"]
    assert recording.effort[:, 0].max() == verdict.max_effort["a1"]
