"""A scenario uses files of the installed package and of its own folder; others only where they are allowed."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
import yaml

from drake_ltl.errors import InvalidInputError
from drake_ltl.scenario import load, model_access
from drake_ltl.scenario.model_access import allow_models, package_of
from drake_ltl.scenario.model_files import PACKAGE, resolve

JOINTS = "".join(f'<joint name="j{i}" type="{kind}"/>' for i, kind in enumerate(["prismatic"] * 2 + ["revolute"] * 2))


def robot(inside: str = "") -> str:
    return f'<robot name="r">{JOINTS}{inside}</robot>'


@pytest.fixture
def place(tmp_path) -> Path:
    """A folder `scenario` beside a folder `elsewhere` with a robot in it."""
    (tmp_path / "scenario").mkdir()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "arm.urdf").write_text(robot(), encoding="utf-8")
    return tmp_path


@pytest.fixture
def loaded(place, data):
    """Loads a scenario with a model for its first agent; the lines that are wrong with it."""

    def load_it(uri: str) -> list[str]:
        data["agents"]["a1"]["model"] = uri
        path = place / "scenario" / "scenario.yaml"
        path.write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
        try:
            load(path)
        except InvalidInputError as error:
            return [str(mistake) for mistake in error.mistakes if mistake.where == "agents.a1.model"]
        return []

    return load_it


def test_models_beside_the_scenario(place, loaded):
    (place / "scenario" / "robots").mkdir()
    arm = place / "scenario" / "robots" / "arm.urdf"
    arm.write_text(robot(), encoding="utf-8")
    for uri in ("robots/arm.urdf", str(arm), f"file://{arm}", "robots/../robots/arm.urdf"):
        assert loaded(uri) == []


def test_models_elsewhere_are_refused_unless_allowed(place, loaded):
    (place / "scenario" / "link.urdf").symlink_to(place / "elsewhere" / "arm.urdf")
    arm = place / "elsewhere" / "arm.urdf"
    up = "../" * len(resolve(f"package://{PACKAGE}/agents").parts)
    uris = ["../elsewhere/arm.urdf", "link.urdf", str(arm), f"file://{arm}", f"package://{PACKAGE}/agents/{up}{arm}"]
    for uri in uris:
        (line,) = loaded(uri)
        assert "outside the scenario's folder" in line
        assert f"--allow-models {str(place / 'elsewhere')!r}" in line
        with allow_models(place / "elsewhere"):
            assert loaded(uri) == []
        assert loaded(uri) == [line]


def test_it_is_not_told_whether_files_elsewhere_exist(loaded):
    (there,), (absent,) = loaded("/etc/passwd"), loaded("/etc/no such file")
    assert there.replace("passwd", "no such file") == absent


@pytest.mark.parametrize("uri", ["http://host/arm.urdf", "ftp://host/arm.urdf", "package://other/arm.urdf"])
def test_nothing_is_fetched(loaded, uri):
    with allow_models("/"):
        (line,) = loaded(uri)
    assert "is not a known" in line


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("http://host/arm.obj", "'http' is not a known scheme"),
        ("package://drake_models/arm.obj", "'drake_models' is not a known package"),
        ("/etc/passwd", "outside"),
        ("file:///etc/passwd", "outside"),
        ("../elsewhere/arm.obj", "outside"),
        ("%2E%2E/elsewhere/arm.obj", "outside"),
        ("package://mine/../../../etc/passwd", "outside"),
        ("model://mine/../elsewhere/arm.obj", "outside"),
        ("meshes/arm.obj", ""),
        ("package://mine/arm.obj", ""),
        (f"package://{PACKAGE}/agents/planar_arm.urdf", ""),
    ],
)
@pytest.mark.parametrize("element", ['<mesh filename="{}"/>', "<mesh><uri> {}\n</uri></mesh>", "<a:b_map>{}</a:b_map>"])
def test_what_a_model_names(place, loaded, name, words, element):
    package = "<package><name>mine</name></package>"
    (place / "scenario" / "package.xml").write_text(package, encoding="utf-8")
    text = robot(element.format(name)).replace("<robot", '<robot xmlns:a="http://a"')
    (place / "scenario" / "arm.urdf").write_text(text, encoding="utf-8")
    lines = loaded("arm.urdf")
    assert len(lines) == bool(words)
    if words:
        assert f"arm.urdf names {name!r}" in lines[0]
        assert words in lines[0]


GLTF = json.dumps({"buffers": [{"uri": "data:AAAA"}, {}], "images": [{"uri": "../secret.png"}]})


@pytest.mark.parametrize(
    ("mesh", "content"),
    [
        ("a.obj", b"# mesh\nmtllib ../secret.mtl\nv 0 0 0\n"),
        ("a.mtl", b"newmtl m\nmap_Kd -s 1 1 1 ../secret.png\n"),
        ("a.gltf", GLTF.encode()),
        ("a.glb", b"glTF\2\0\0\0----" + len(GLTF).to_bytes(4, "little") + b"JSON" + GLTF.encode()),
        ("a.sdf", b"<sdf><include><uri>../secret.sdf</uri></include></sdf>"),
    ],
)
def test_what_a_mesh_names(place, loaded, mesh, content):
    (place / "scenario" / "arm.urdf").write_text(robot(f'<mesh filename="{mesh}"/>'), encoding="utf-8")
    (place / "scenario" / mesh).write_bytes(content)
    (line,) = loaded("arm.urdf")
    assert f"{mesh} names '../secret" in line


def test_a_folder_of_a_model(place, loaded):
    """SDFormat includes a folder by what its model.config names."""
    (place / "scenario" / "inner").mkdir()
    (place / "scenario" / "inner" / "model.config").write_text("<model><sdf>../../x.sdf</sdf></model>")
    (place / "scenario" / "arm.urdf").write_text(robot("<uri>inner</uri>"), encoding="utf-8")
    (line,) = loaded("arm.urdf")
    assert "model.config names '../../x.sdf'" in line


@pytest.mark.parametrize("content", [b"", b"[1]", b'{"buffers": 3}', b"glTF", b"{" * 10_000, b"[" * 100_000])
def test_meshes_that_are_none(place, loaded, content):
    (place / "scenario" / "arm.urdf").write_text(robot('<mesh filename="a.gltf"/>'), encoding="utf-8")
    (place / "scenario" / "a.gltf").write_bytes(content)
    assert loaded("arm.urdf") == []


def test_models_that_name_each_other(place, loaded):
    (place / "scenario" / "arm.urdf").write_text(robot("<uri>arm.urdf</uri><uri>other.sdf</uri>"), encoding="utf-8")
    (place / "scenario" / "other.sdf").write_text("<sdf><uri>arm.urdf</uri></sdf>", encoding="utf-8")
    assert loaded("arm.urdf") == []


def test_a_bomb_of_entities_and_files_without_end(place, loaded, monkeypatch):
    entities = "".join(f'<!ENTITY e{i} "{f"&e{i - 1};" * 10 if i else "x" * 1000}">' for i in range(10))
    arm = place / "scenario" / "arm.urdf"
    arm.write_text(f"<!DOCTYPE robot [{entities}]>{robot('&e9;')}", encoding="utf-8")
    (line,) = loaded("arm.urdf")
    assert "not well-formed XML" in line
    os.mkfifo(place / "scenario" / "pipe")
    assert "is no file" in loaded("pipe")[0]
    arm.write_text(robot('<mesh filename="pipe"/>'), encoding="utf-8")
    assert loaded("arm.urdf") == []  # not opened: it would wait for ever
    monkeypatch.setattr(model_access, "LARGEST_FILE", 10)
    assert "larger than" in loaded("arm.urdf")[0]


def test_the_package_of_a_file(tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "package.xml").write_text("<package><name> robots </name></package>", encoding="utf-8")
    assert package_of(tmp_path / "meshes" / "a.obj") == ("robots", tmp_path)
    (tmp_path / "package.xml").write_text("<package>", encoding="utf-8")
    assert package_of(tmp_path / "a.obj") is None


@pytest.mark.parametrize(
    "uri", ["x" * 5000, "a/" * 3000, f"package://{PACKAGE}/{'x' * 5000}", "~nobody at all/x", "a\u0301.urdf"]
)
def test_lines_about_strange_names_are_short(loaded, uri):
    (line,) = loaded(uri)
    assert len(line) < 600
    assert line.isprintable()
