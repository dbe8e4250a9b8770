"""What a release says of itself agrees everywhere."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

import drake_ltl

REPOSITORY = Path(__file__).parents[1]


def test_versions_agree():
    tomllib = pytest.importorskip("tomllib", reason="tomllib is part of Python from 3.11 on")
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = yaml.safe_load((REPOSITORY / "CITATION.cff").read_text(encoding="utf-8"))
    assert project["version"] == drake_ltl.__version__ == citation["version"]
    assert f"## {drake_ltl.__version__}" in (REPOSITORY / "CHANGELOG.md").read_text(encoding="utf-8")


def test_every_package_is_installed():
    """Editable installations have them all; a forgotten one would be missed in wheels alone."""
    tomllib = pytest.importorskip("tomllib", reason="tomllib is part of Python from 3.11 on")
    settings = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    found = {file.parent.relative_to(REPOSITORY) for file in (REPOSITORY / "drake_ltl").rglob("*.py")}
    elsewhere = {"drake_ltl.diagrams", "drake_ltl.models", "drake_ltl.examples"}
    assert set(settings["packages"]) == {".".join(folder.parts) for folder in found} | elsewhere


def test_the_citation_names_the_paper_and_the_licence():
    citation = yaml.safe_load((REPOSITORY / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["cff-version"] == "1.2.0"
    assert citation["license"] == "BSD-3-Clause"
    assert "Temporal Logic Formulas" in citation["preferred-citation"]["title"]
