"""The diagram of case ii, built once and never run."""

from __future__ import annotations

import pytest
from drake_ltl.diagrams import MakeMissionDiagram


@pytest.fixture(scope="session")
def mission_diagram(mission, case_ii, models):
    return MakeMissionDiagram(mission, case_ii, models, num_steps=2)


@pytest.fixture(scope="session")
def separate_diagram(mission, case_ii, models):
    """With one system for each control law and agent."""
    return MakeMissionDiagram(mission, case_ii, models, num_steps=2, separate_controllers=True)
