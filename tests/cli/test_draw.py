"""`drake-ltl draw`."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest
from matplotlib.image import imread


@pytest.fixture(scope="module")
def svg(examples, tmp_path_factory) -> str:
    """The map of case ii."""
    from drake_ltl.cli import main

    file = tmp_path_factory.mktemp("map") / "case_ii.svg"
    assert main(["draw", str(examples / "case_ii.yaml"), "--output", str(file)]) == 0
    return file.read_text(encoding="utf-8")


def test_formulas_stand_beside_the_map(svg, case_ii):
    elements = ET.fromstring(svg).iter()
    svg_texts = ["".join(element.itertext()).strip() for element in elements if element.tag.endswith("}text")]
    for member in (*case_ii.agents, *case_ii.objects):
        if member.spec != "1":
            assert member.spec in svg_texts
    assert "a1  (power 2)" in svg_texts
    assert "o1  (needs power 5)" in svg_texts


def test_a_picture_is_drawn(drake_ltl, shuttle_file, tmp_path):
    result = drake_ltl("draw", shuttle_file, "--output", tmp_path / "map.png")
    assert (result.status, result.err) == (0, "")
    assert str(tmp_path / "map.png") in result.out.replace("\n", "")
    picture = imread(tmp_path / "map.png")
    assert picture.shape[0] > 800
    assert picture.std() > 0.01  # not an empty sheet


@pytest.mark.parametrize("name", ["map", "map.gif", "map.PNG.txt", ""])
def test_other_kinds_of_pictures_are_refused(drake_ltl, shuttle_file, tmp_path, name):
    result = drake_ltl("draw", shuttle_file, "--output", tmp_path / name if name else "")
    assert result.status == 2
    assert "--output" in result.err
    assert sorted(path.name for path in tmp_path.iterdir()) == [shuttle_file.name]


def test_a_place_that_is_not_there(drake_ltl, shuttle_file, tmp_path):
    result = drake_ltl("draw", shuttle_file, "--output", tmp_path / "nowhere" / "map.png")
    assert result.status == 2
    assert "there is no folder" in result.err
