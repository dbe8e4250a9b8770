"""`drake-ltl explain`."""

from __future__ import annotations

import re

import pytest


@pytest.fixture(scope="module")
def case_i_text(examples) -> str:
    import contextlib
    import io

    from drake_ltl.cli import main

    with contextlib.redirect_stdout(io.StringIO()) as out:
        assert main(["explain", str(examples / "case_i.yaml")]) == 0
    return out.getvalue()


def sections(text: str) -> dict[str, list[str]]:
    """Title -> lines."""
    found = {}
    for part in text.strip().split("\n\n"):
        title, *lines = part.splitlines()
        found[title] = [line.strip() for line in lines]
    return found


def test_formulas_in_words(case_i_text):
    lines = sections(case_i_text)["What is asked for"]
    for formula, meaning in {
        "G !pi3": "a1 must never enter pi3",
        "G(pi1 -> X pi4)": "whenever o1 is in pi1, in the next step o1 is in pi4",
        "F pi4": "o2 must visit pi4 at some time",
    }.items():
        assert lines[lines.index(formula) + 1] == meaning


def test_known_propositions(case_i_text):
    assert sections(case_i_text)["What formulas may name"][0] == "a1, a2, o1, o2: pi1, pi2, pi3, pi4"


def test_services_are_named_with_their_regions(drake_ltl, examples):
    lines = sections(drake_ltl("explain", examples / "hospital_cart.yaml").out)["What formulas may name"]
    assert "porter_2: charge (in ward), lobby, isolation" in lines


def test_sizes(case_i_text):
    """The published number of states of TS; all of them can be reached."""
    lines = sections(case_i_text)["How large it is"]
    assert any(line.startswith("transition system TS: 560 states, ") for line in lines)
    assert any(re.fullmatch(r"Büchi automaton BA of the paper: \d+ states, \d+ edges", line) for line in lines)
    assert any(line.startswith("deterministic automaton that is searched: ") for line in lines)


def test_what_counts_steps(case_i_text, drake_ltl, examples):
    assert "o1: G(pi1 -> X pi4)" in sections(case_i_text)["What depends on the number of steps"]
    lines = sections(drake_ltl("explain", examples / "patrol.yaml").out)["What depends on the number of steps"]
    assert lines == ["Nothing: a step in which all wait changes no verdict."]


def test_there_is_a_plan(case_i_text):
    assert "cost 14928, no plan costs less" in " ".join(sections(case_i_text)["Whether there is a plan"])


def test_why_there_is_none(drake_ltl, examples):
    result = drake_ltl("explain", examples / "forbidden_room.yaml")
    assert (result.status, result.err) == (1, "")
    lines = sections(result.out)["Whether there is a plan"]
    assert lines[0].startswith("No: ")
    assert "strong must never enter lab (strong: G !lab)" in lines
    assert "without any one of them the others alone have a plan, found and checked" in lines


def test_it_fits_eighty_columns_and_is_plain(case_i_text):
    assert max(map(len, case_i_text.splitlines())) <= 80
    assert "\x1b" not in case_i_text
    assert not any(line.endswith(" ") for line in case_i_text.splitlines())


def test_bad_input(drake_ltl, changed):
    result = drake_ltl("explain", changed({"power: 4": "power: 0"}))
    assert (result.status, result.out) == (2, "")
    assert result.err.startswith("agents.a2.power")
