import dataclasses
import json
import re

import numpy as np
import pytest
from pydrake.math import RigidTransform

from drake_ltl.visualization.meshcat_scene import DrawWorkspace, MakeMeshcat
from drake_ltl.visualization.page_data import PageData, recorded_page_data
from drake_ltl.visualization.page_overlay import with_overlay
from drake_ltl.visualization.recorded_page import StartPage, WritePage

EMPTY = "<!doctype html><html><head><title>Viewer</title></head><body></body></html>"
LOADS = re.compile(r"""<(?:script|link|img|iframe)\b[^>]*\b(?:src|href)\s*=\s*["']?(?!data:)""", re.IGNORECASE)
"""A tag that makes the browser fetch something."""


def data_of(page: str) -> dict:
    return json.loads(re.search(r"const data = (\{.*\});", page).group(1))


def test_chapters_follow_the_steps(recording, scenario):
    chapters = recorded_page_data(recording, scenario).chapters
    last = recording.steps[-1]
    assert [c.begin for c in chapters] == [*(step.start for step in recording.steps), last.start + last.duration]
    assert chapters[2].heading == "Step 3 of 4 (suffix, round 1)"
    assert chapters[2].lines == ("a + b carry crate: east → west",)
    assert chapters[-1].heading == "All steps done"


def test_a_run_that_stopped_says_why(recording, scenario):
    stopped = dataclasses.replace(recording, completed=False, reason="interrupted")
    last = recorded_page_data(stopped, scenario).chapters[-1]
    assert (last.heading, last.lines) == ("Stopped", ("interrupted",))


def test_goals_are_read_off_the_poses(recording, scenario):
    asked = dataclasses.replace(scenario.objects[0], spec="F west & GF east")
    data = recorded_page_data(recording, dataclasses.replace(scenario, objects=(asked, *scenario.objects[1:])))
    assert [formula for _, formula, _ in data.demands] == ["F west", "GF east"]
    # The crate starts in the east, and is set down in the west by the third step.
    assert [c.goals[0] for c in data.chapters] == [("owed", "F west")] * 3 + [("met", "")] * 2
    # The round begins with the third step's start, where the crate is still in the east.
    assert [c.goals[1][0] for c in data.chapters] == ["met"] * 5


def test_what_everybody_does_changes_with_modes_and_grasps(recording, scenario):
    activities = recorded_page_data(recording, scenario).activities
    assert [text for _, text in activities["a"]] == [
        "travels to east",
        "reaches for crate",
        "carries crate to west",
        "backs off from crate",
    ]
    assert [text for _, text in activities["crate"]] == ["free", "carried by a, b", "held by b"]
    assert [text for _, text in activities["idle"]] == ["free"]


def test_no_text_breaks_out_of_the_overlay():
    evil = "</script><script>alert(1)</script>"
    page = with_overlay(EMPTY, PageData(title="a < b & c", chapters=(), legend={evil: "#000000"}))
    assert evil not in page
    assert page.count("</script>") == 1
    assert "<title>a &lt; b &amp; c</title>" in page
    assert data_of(page)["legend"] == [[evil, "#000000"]]


def test_only_pages_of_meshcat_are_taken():
    with pytest.raises(ValueError, match="</body>"):
        with_overlay("nothing", PageData("", ()))


def test_the_page_has_all_and_loads_nothing(recording, scenario, tmp_path):
    meshcat = MakeMeshcat()
    DrawWorkspace(meshcat, scenario)
    StartPage(meshcat)
    for time in (0.0, 1.0):
        meshcat.SetTransform("/mission/members/a", RigidTransform(np.array([time, 0.0, 0.0])), time)
    path = WritePage(meshcat, tmp_path / "page.html", recorded_page_data(recording, scenario))
    page = path.read_text(encoding="utf-8")
    data = data_of(page)
    assert data["chapters"][0]["lines"] == ["a: west → east", "b: west → east"]
    assert [name for name, _ in data["legend"]] == ["a", "b", "crate", "idle"]
    assert f"<title>{scenario.name}</title>" in page
    assert not LOADS.search(page)
    assert page.rstrip().endswith("</html>")


def test_meshcat_is_not_open_to_the_network():
    assert "localhost" in MakeMeshcat().web_url()
