"""Where models are found, and which of them can be agents and objects."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from drake_ltl.errors import InvalidInputError
from drake_ltl.scenario import load, loads, model_files


def urdf(*kinds: str) -> str:
    """A URDF with one joint of each kind."""
    joints = "".join(f'<joint name="j{index}" type="{kind}"/>' for index, kind in enumerate(kinds))
    return f'<robot name="r">{joints}<transmission><joint name="j9"/></transmission></robot>'


def test_shipped_models_are_found_and_sound():
    for folder, check in (("agents", model_files.check_agent), ("objects", model_files.check_object)):
        uris = model_files.shipped(folder)
        assert uris
        for uri in uris:
            check(model_files.resolve(uri))
    planar_arm = model_files.resolve("package://drake_ltl_models/agents/planar_arm.urdf")
    assert model_files.check_agent(planar_arm) == 2


def test_uris(tmp_path):
    assert model_files.resolve("a/b.urdf", tmp_path) == tmp_path / "a" / "b.urdf"
    assert model_files.resolve("/a/b.urdf", tmp_path) == Path("/a/b.urdf")
    assert model_files.resolve("file:///a/b%20c.urdf") == Path("/a/b c.urdf")
    for uri in ("package://other/b.urdf", "model://b.urdf"):
        with pytest.raises(ValueError, match="not a known"):
            model_files.resolve(uri)


def test_arm_joints_are_counted_after_the_base(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(urdf("prismatic", "fixed", "prismatic", "revolute", "continuous", "revolute", "fixed"))
    assert model_files.check_agent(path) == 3


@pytest.mark.parametrize(
    ("content", "part"),
    [
        (
            urdf("prismatic", "prismatic", "revolute", "fixed"),
            "has 3 movable joints (j0, j1, j2), not at least 4",
        ),
        (urdf(), "has 0 movable joints (none)"),
        (urdf(*["revolute"] * 6), "joint 'j0' of model.urdf is revolute, not prismatic"),
        ("<robot>", "not well-formed XML"),
        ("", "not well-formed XML"),
        ("<sdf/>", "begins with <sdf>, not with <robot>"),
        ('<?xml version="1.0" encoding="nonsense"?><robot/>', "not well-formed XML"),
    ],
)
def test_model_that_is_no_agent(tmp_path, data, content, part):
    (tmp_path / "model.urdf").write_text(content)
    data["agents"]["a1"]["model"] = "model.urdf"
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(data, sort_keys=False))
    with pytest.raises(InvalidInputError) as caught:
        load(tmp_path / "scenario.yaml")
    (mistake,) = caught.value.mistakes
    assert mistake.where == "agents.a1.model"
    assert part in mistake.what
    assert "at least two joints of its arm" in mistake.remedy


def test_model_that_is_no_object(tmp_path, data):
    (tmp_path / "crate.sdf").write_text("<svg/>")
    data["objects"]["o1"]["model"] = "crate.sdf"
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(data))
    with pytest.raises(InvalidInputError, match="begins with <svg>, not with <sdf> or <robot>"):
        load(tmp_path / "scenario.yaml")


@pytest.mark.parametrize(("limit", "good"), [("-1 1", True), ("1 1", True), ("1 -1", False), ("nan 1", False)])
def test_limits_are_in_order(tmp_path, limit, good):
    """Drake would end the process."""
    lower, upper = limit.split()
    text = urdf("prismatic", "prismatic", "revolute", "revolute")
    path = tmp_path / "arm.urdf"
    path.write_text(
        text.replace('type="revolute"/>', f'type="revolute"><limit lower="{lower}" upper="{upper}"/></joint>')
    )
    if good:
        assert model_files.check_agent(path) == 2
    else:
        with pytest.raises(ValueError, match=r"'j2' of arm\.urdf has a lower limit above"):
            model_files.check_agent(path)


def test_paths_start_at_the_file_s_folder_and_become_absolute(tmp_path, data, monkeypatch):
    (tmp_path / "robots").mkdir()
    arm = tmp_path / "robots" / "arm.urdf"
    arm.write_text(urdf("prismatic", "prismatic", "revolute", "revolute"))
    data["agents"]["a1"]["model"] = "robots/arm.urdf"
    data["agents"]["a2"]["model"] = f"file://{arm}"
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(data, sort_keys=False))
    monkeypatch.chdir(tmp_path / "robots")
    scenario = load("../scenario.yaml")
    assert [agent.model for agent in scenario.agents] == [str(arm), str(arm)]
    assert scenario.objects[0].model.startswith("package://")


def test_a_relative_path_is_looked_for_where_the_message_says(tmp_path, data):
    data["agents"]["a1"]["model"] = "models/arm.urdf"
    data["agents"]["a2"]["model"] = str(tmp_path / "arm.urdf")
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(data, sort_keys=False))
    with pytest.raises(InvalidInputError) as caught:
        load(tmp_path / "scenario.yaml")
    relative, absolute = caught.value.mistakes
    assert relative.what == f"'models/arm.urdf' is no file (looked for as {tmp_path / 'models' / 'arm.urdf'})"
    assert absolute.what == f"{str(tmp_path / 'arm.urdf')!r} is no file"


def test_a_misspelt_model_is_told_its_name_and_all_that_there_are(data):
    data["agents"]["a1"]["model"] = "package://drake_ltl_models/agents/planar_arms.urdf"
    with pytest.raises(InvalidInputError) as caught:
        loads(yaml.safe_dump(data, sort_keys=False))
    (mistake,) = caught.value.mistakes
    assert mistake.remedy.startswith("did you mean `planar_arm.urdf`? ")
    assert "bases/differential_drive.urdf" in mistake.remedy
