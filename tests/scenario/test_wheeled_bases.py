"""Differential drives as agents of a scenario file: what is read of them, and what is refused, a line for each."""

from __future__ import annotations

import pytest

from drake_ltl.cli import main
from drake_ltl.errors import InvalidInputError
from drake_ltl.scenario import loads
from drake_ltl.scenario.model_files import check_agent, is_drive, resolve

BASE = "package://drake_ltl_models/bases/differential_drive.urdf"
ARM = "package://drake_ltl_models/agents/planar_arm.urdf"
TEXT = """
workspace: {radius: 9.0}
regions:
  pi1: {centre: [-4, 0, 0], radius: 2}
  pi2: {centre: [4, 0, 0], radius: 2}
agents:
  a1:
    model: MODEL
    position: [-4, 0]
    spec: "GF pi2"
"""


def text(*lines: str, model: str = BASE) -> str:
    return TEXT.replace("MODEL", model) + "".join(f"    {line}\n" for line in lines)


def mistake_of(scenario: str, **options):
    with pytest.raises(InvalidInputError) as caught:
        loads(scenario, **options)
    (mistake,) = caught.value.mistakes
    return mistake


def test_a_drive_has_no_arm_and_no_power():
    (drive,) = loads(text("heading: 0.5", "headings: {pi2: 1.5}")).agents
    assert (drive.has_arm, drive.power, drive.joints) == (False, 0.0, None)
    assert (drive.heading, drive.headings) == (0.5, {"pi2": 1.5})
    (arm,) = loads(text(model=ARM)).agents
    assert (arm.has_arm, arm.power, arm.headings) == (True, 1.0, {})


def test_power_may_be_written_where_it_is_none():
    assert loads(text("power: 0")).agents[0].power == 0.0
    assert loads(text("power: 0"), check_models=False).agents[0].power == 0.0  # a recording's, whose models are lost


@pytest.mark.parametrize(
    ("scenario", "where", "what", "remedy"),
    [
        (text("power: 2"), "agents.a1.power", "has no arm", "write 0"),
        (text("power: 0", model=ARM), "agents.a1.power", "0", "positive"),
        (text("joints: [0.0, 0.0]"), "agents.a1.joints", "has no arm", "leave the key out"),
        (text("headings: {pi2: 1.5}", model=ARM), "agents.a1.headings", "only differential drives", "leave the key"),
        (text("headings: {pi3: 1.5}"), "agents.a1.headings.pi3", "there is no region", "known regions: pi1, pi2"),
        (
            text() + "fits: {agent: 1.25, grasping: 2.5, object: 0.5, capacity: 5.75}\n",
            "fits",
            "a1 has no arm",
            "geometric",
        ),
        (
            text() + "faults: [{kind: weld_breaks, agent: a1, time: 2.0}]\n",
            "faults[0].agent",
            "a1 is a differential drive, and holds nothing",
            "an agent with an arm",
        ),
    ],
)
def test_what_makes_no_sense_is_one_line(scenario, where, what, remedy):
    mistake = mistake_of(scenario)
    assert mistake.where == where
    assert what in mistake.what
    assert remedy in mistake.remedy


@pytest.fixture
def drive_with_arm(tmp_path):
    """The shipped drive, a joint on its deck."""
    joint = """
      <link name="mast"/>
      <joint name="lift" type="prismatic"><parent link="base"/><child link="mast"/><limit effort="1"/></joint>
    </robot>"""
    path = tmp_path / "with_arm.urdf"
    path.write_text(resolve(BASE).read_text().replace("</robot>", joint))
    return path


def test_an_arm_on_wheels_is_refused_with_the_remedy(drive_with_arm):
    mistake = mistake_of(text(model=drive_with_arm.name), base=drive_with_arm.parent)
    assert mistake.where == "agents.a1.model"
    assert "moves lift besides its wheels" in mistake.what
    assert "cannot approach, grasp or carry" in mistake.what
    assert "nothing moves but its wheels" in mistake.remedy


def test_the_same_with_the_joint_fixed_is_a_drive(drive_with_arm):
    drive_with_arm.write_text(drive_with_arm.read_text().replace('name="lift" type="prismatic"', 'type="fixed"'))
    assert is_drive(drive_with_arm)
    assert check_agent(drive_with_arm) == 0


def test_joints_called_left_and_right_do_not_make_a_drive_of_an_arm(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(resolve(ARM).read_text().replace('"q1"', '"left"').replace('"q2"', '"right"'))
    assert not is_drive(path)
    assert check_agent(path) == 2


@pytest.mark.parametrize("command", ["check", "plan", "draw", "explain", "simulate"])
def test_every_command_says_so(tmp_path, capsys, command):
    path = tmp_path / "shuttle.yaml"
    path.write_text(text("power: 2"))
    assert main([command, str(path)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("agents.a1.power: ")
    assert err.count("\n") == 1
