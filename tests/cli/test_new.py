"""`drake-ltl new`."""

from __future__ import annotations

from pathlib import Path


def test_a_new_scenario_is_sound_and_has_a_plan(drake_ltl, tmp_path):
    file = tmp_path / "errand.yaml"
    written = drake_ltl("new", file)
    assert (written.status, written.err) == (0, "")
    assert f"drake-ltl plan {file}" in written.out
    assert drake_ltl("check", file).status == 0
    planned = drake_ltl("plan", file)
    assert planned.status == 0
    assert "{a1, a2} carry crate: depot → dock" in planned.out.replace("\N{NO-BREAK SPACE}", " ")


def test_without_a_name_it_is_scenario_yaml(drake_ltl, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert drake_ltl("new").status == 0
    assert [path.name for path in Path().iterdir()] == ["scenario.yaml"]


def test_nothing_is_overwritten(drake_ltl, tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("mine", encoding="utf-8")
    result = drake_ltl("new", file)
    assert (result.status, result.out) == (2, "")
    assert result.err == f"{file}: is there already; name a new file\n"
    assert file.read_text(encoding="utf-8") == "mine"


def test_a_dangling_link_is_not_followed(drake_ltl, tmp_path):
    link = tmp_path / "link.yaml"
    link.symlink_to(tmp_path / "elsewhere.yaml")
    assert drake_ltl("new", link).status == 2
    assert not (tmp_path / "elsewhere.yaml").exists()


def test_a_place_that_is_not_there(drake_ltl, tmp_path):
    result = drake_ltl("new", tmp_path / "nowhere" / "errand.yaml")
    assert result.status == 2
    assert len(result.err.splitlines()) == 1
    assert "No such file or directory" in result.err
