"""Every name on the page from the paper to the code is there."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "theory.md"
NAMES = sorted(set(re.findall(r"\]\[(drake_ltl[\w.]+)\]", PAGE.read_text(encoding="utf-8"))))
KINDS = (("Def.", 5), ("Lemma", 3), ("Remark", 3), ("Theorem", 1), ("Problem", 1))
EQUATIONS = ["1a", "1b", "2a", "2b", "3", "4", "5", "6", "7", "8", "9", "10a", "10b"]
PLACES = [f"({equation})" for equation in EQUATIONS]
PLACES += [f"{kind} {number}" for kind, most in KINDS for number in range(1, most + 1)]
"""All that the paper numbers."""


@pytest.mark.parametrize("name", NAMES)
def test_names_can_be_imported_and_say_what_they_are(name):
    module, _, attribute = name.rpartition(".")
    assert getattr(import_module(module), attribute).__doc__


@pytest.mark.parametrize("place", PLACES)
def test_everything_that_the_paper_numbers_is_in_a_row(place):
    rows = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("|") and "][" in line]
    row = next(line for line in rows if place in line.split("|")[1] or place in line.split("|")[2])
    assert "][drake_ltl." in row
