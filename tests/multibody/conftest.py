"""Agents and objects as scenarios name them, and models that are changed a little."""

from __future__ import annotations

import pytest
from drake_ltl.models import package_xml

from drake_ltl.scenario.model import Agent, TransportObject

ARM = "package://drake_ltl_models/agents/planar_arm.urdf"
CRATE = "package://drake_ltl_models/objects/crate.sdf"


@pytest.fixture(scope="session")
def make_agent():
    """make_agent(heading=0, model=ARM, ...)"""

    def make(heading: float = 0.0, model: str = ARM, **options) -> Agent:
        return Agent("a1", str(model), (0.0, 0.0), heading, power=1.0, **options)

    return make


@pytest.fixture(scope="session")
def make_object():
    """make_object(model=CRATE, ...)"""

    def make(model: str = CRATE, **options) -> TransportObject:
        return TransportObject("o1", str(model), (0.0, 0.0), power_needed=1.0, **options)

    return make


@pytest.fixture
def changed_model(tmp_path):
    """changed_model("agents/planar_arm.urdf", {old: new}): a copy of a shipped model with some text replaced."""

    def make(name: str, changes: dict[str, str]):
        text = (package_xml().parent / name).read_text(encoding="utf-8")
        for old, new in changes.items():
            assert old in text, old
            text = text.replace(old, new)
        path = tmp_path / name.rpartition("/")[2]
        path.write_text(text, encoding="utf-8")
        return path

    return make
