"""`drake-ltl check`."""

from __future__ import annotations

from drake_ltl.scenario import model_files


def test_a_sound_scenario(drake_ltl, examples):
    result = drake_ltl("check", examples / "case_ii.yaml")
    assert (result.status, result.err) == (0, "")
    assert result.out == "no mistakes found: 4 regions, 3 agents, 2 objects\n"


def test_all_mistakes_of_a_file_at_once(drake_ltl, changed):
    file = changed({"radius: 30.0": "radius: -1", 'spec: "G !pi3"': 'spec: "G !pi9"', "power: 4": "power: strong"})
    result = drake_ltl("check", file)
    assert (result.status, result.out) == (2, "")
    places = [line.split(":")[0] for line in result.err.splitlines()]
    assert places == ["workspace.radius", "agents.a1.spec", "agents.a2.power"]


def test_models_are_loaded(drake_ltl, changed):
    """A radius that is too small for the robot is known only from its model."""
    result = drake_ltl("check", changed({"radius: 1.25  ": "radius: 0.25  "}))
    assert result.status == 2
    assert result.err.startswith("agents.a1.radius")


def test_starts_are_looked_at(drake_ltl, shuttle_file):
    text = shuttle_file.read_text(encoding="utf-8").replace("position: [-2.5, 0.0]", "position: [-2.5, 1.9]")
    shuttle_file.write_text(text, encoding="utf-8")
    result = drake_ltl("check", shuttle_file)
    assert result.status == 2
    (line,) = result.err.splitlines()
    assert line.startswith("agents.a1.position")
    assert "lies in no region" in line


def test_no_file(drake_ltl, tmp_path):
    result = drake_ltl("check", tmp_path / "none.yaml")
    assert result.status == 2
    assert len(result.err.splitlines()) == 1


def test_an_example_by_its_name(drake_ltl, tmp_path, monkeypatch):
    """A file of that name comes first."""
    monkeypatch.chdir(tmp_path)
    assert drake_ltl("check", "patrol").out == "no mistakes found: 2 regions, 1 agent, 0 objects\n"
    (tmp_path / "patrol").write_text("", encoding="utf-8")
    assert "patrol: is empty" in drake_ltl("check", "patrol").err
    unknown = drake_ltl("check", "patrul")
    assert unknown.status == 2
    assert unknown.err.startswith("patrul: is neither a file nor the name of an example; examples are case_i, case_ii,")
    assert len(unknown.err.splitlines()) == 1


def test_models_elsewhere_are_allowed_on_the_command_line(drake_ltl, changed, tmp_path_factory):
    folder = tmp_path_factory.mktemp("robots")
    arm = model_files.resolve("package://drake_ltl_models/agents/planar_arm.urdf")
    (folder / "arm.urdf").write_bytes(arm.read_bytes())
    uri = "package://drake_ltl_models/agents/planar_arm.urdf   #"
    file = changed({uri: f"{folder}/arm.urdf   #"})
    refused = drake_ltl("check", file)
    assert refused.status == 2
    assert f"--allow-models {str(folder)!r}" in refused.err
    assert drake_ltl("check", file, "--allow-models", tmp_path_factory.getbasetemp()).status == 0
    assert drake_ltl("check", file).status == 2


def test_it_says_who_may_only_travel(drake_ltl):
    found, courier = drake_ltl("check", "courier").out.splitlines()
    assert found == "no mistakes found: 4 regions, 3 agents, 1 object"
    assert courier == "courier is a differential drive without an arm: it may travel, but not grasp or carry"
