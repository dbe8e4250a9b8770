import dataclasses
import json
import re

import numpy as np
import pytest
from pydrake.math import RigidTransform

from drake_ltl.visualization.meshcat_scene import DrawWorkspace, MakeMeshcat
from drake_ltl.visualization.recorded_page import StartPage, WritePage, captions_of, legend_of, with_overlay

EMPTY = "<!doctype html><html><head><title>Viewer</title></head><body></body></html>"
LOADS = re.compile(r"""<(?:script|link|img|iframe)\b[^>]*\b(?:src|href)\s*=\s*["']?(?!data:)""", re.IGNORECASE)
"""A tag that makes the browser fetch something."""


def data_of(page: str) -> dict:
    return json.loads(re.search(r"const data = (\{.*\});", page).group(1))


def test_captions_follow_the_steps(recording):
    captions = captions_of(recording)
    assert [begin for begin, _ in captions] == [step.start for step in recording.steps] + [
        recording.steps[-1].start + recording.steps[-1].duration
    ]
    assert captions[2][1] == "Step 3 of 4 (suffix, round 1)\na + b carry crate: east → west"
    assert captions[-1][1] == "All steps done"


def test_a_run_that_stopped_says_why(recording):
    stopped = dataclasses.replace(recording, completed=False, reason="interrupted")
    assert captions_of(stopped)[-1][1] == "Stopped\ninterrupted"


def test_no_text_breaks_out_of_the_overlay():
    evil = "</script><script>alert(1)</script>"
    page = with_overlay(EMPTY, [(0.0, f"one\n{evil}")], title="a < b & c", legend={evil: "#000000"})
    assert evil not in page
    assert page.count("</script>") == 1
    assert "<title>a &lt; b &amp; c</title>" in page
    assert data_of(page)["captions"] == [[0.0, ["one", evil]]]


def test_only_pages_of_meshcat_are_taken():
    with pytest.raises(ValueError, match="</body>"):
        with_overlay("nothing", [])


def test_the_page_has_all_and_loads_nothing(recording, scenario, tmp_path):
    meshcat = MakeMeshcat()
    DrawWorkspace(meshcat, scenario)
    StartPage(meshcat)
    for time in (0.0, 1.0):
        meshcat.SetTransform("/mission/members/a", RigidTransform(np.array([time, 0.0, 0.0])), time)
    path = WritePage(
        meshcat, tmp_path / "page.html", captions_of(recording), title=scenario.name, legend=legend_of(recording)
    )
    page = path.read_text(encoding="utf-8")
    data = data_of(page)
    assert data["captions"][0] == [0.0, ["Step 1 of 4 (prefix)", "a: west → east", "b: west → east"]]
    assert [name for name, _ in data["legend"]] == ["a", "b", "crate", "idle"]
    assert f"<title>{scenario.name}</title>" in page
    assert not LOADS.search(page)
    assert "viewer.animator.time" in page
    assert page.rstrip().endswith("</html>")


def test_meshcat_is_not_open_to_the_network():
    assert "localhost" in MakeMeshcat().web_url()
