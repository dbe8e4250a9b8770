"""The report's page and its evidence."""

from __future__ import annotations

import dataclasses
import re

import pytest

from drake_ltl.verification.clearances import KINDS
from drake_ltl.verification.verdict import Verdict
from drake_ltl.visualization.evidence import evidence
from drake_ltl.visualization.figures import run_drawings
from drake_ltl.visualization.report import Picture, _write, report_html

LOADS = re.compile(r"""\b(?:src|srcset)\s*=\s*["'](?!data:)|<(?:link|script|iframe)\b|url\(""", re.IGNORECASE)


@pytest.fixture
def asked(scenario):
    """The same scenario, with something to do for the crate."""
    crate = dataclasses.replace(scenario.objects[0], spec="F west & G !nowhere")
    return dataclasses.replace(scenario, name="a < b", objects=(crate, *scenario.objects[1:]))


@pytest.fixture
def verdict(recording) -> Verdict:
    word = (("crate.east",), ("crate.east",), ("crate.east",), ("crate.west",), ("crate.west",))
    return Verdict(True, (), word, recording.steps, dict.fromkeys(KINDS), 0.0, 0.0, 0.0, 0.0, 40.0)


def test_the_page_stands_alone(recording, asked, verdict):
    drawings = {d.name: d for d in run_drawings(recording, asked) if d.name in ("gantt", "step_01")}
    pictures = {name: Picture(drawing.title, drawing.svg()) for name, drawing in drawings.items()}
    page = report_html(recording, asked, verdict, pictures, ())
    assert "<title>a &lt; b: report</title>" in page
    assert page.count("<img ") == page.count('src="data:image/svg+xml;base64,') == 2
    assert not LOADS.search(page)
    assert "$" not in page
    for title in ("Verdict", "Plan", "Steps", "Versions"):
        assert f"<h2>{title}</h2>" in page
    assert "<h2>Automata</h2>" not in page


def test_evidence_says_where_it_is_seen(recording, asked, verdict):
    found = evidence(asked, verdict.word, recording.prefix_length, recording.suffix_length)
    assert [(e.verdict, e.seen) for e in found] == [
        ("holds", "crate.west: 3 to 4"),
        ("holds", "crate.nowhere: never"),
    ]


@pytest.mark.parametrize(
    ("spec", "steps", "expected"),
    [("G east", 5, "fails"), ("FG east", 5, "fails"), ("F nowhere", 3, "open"), ("G !east", 3, "fails")],
)
def test_evidence_of_what_fails_or_is_open(recording, asked, verdict, spec, steps, expected):
    crate = dataclasses.replace(asked.objects[0], spec=spec)
    scenario = dataclasses.replace(asked, objects=(crate, *asked.objects[1:]))
    (found,) = evidence(scenario, verdict.word[:steps], recording.prefix_length, recording.suffix_length)
    assert found.verdict == expected


def test_a_file_that_cannot_be_written_whole_stays_as_it_was(tmp_path):
    page = tmp_path / "report.html"
    page.write_text("of an earlier run", encoding="utf-8")
    with pytest.raises(TypeError):
        _write(page, None)
    assert page.read_text(encoding="utf-8") == "of an earlier run"
