"""What many tests share: the paper's second example, its models and its mission, each made once."""

from __future__ import annotations

from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parent.parent / "examples"


@pytest.fixture(scope="session")
def examples() -> Path:
    """The folder of example scenarios."""
    return EXAMPLES


@pytest.fixture(scope="session")
def case_ii():
    """Three agents, two objects."""
    from drake_ltl.scenario import load

    return load(EXAMPLES / "case_ii.yaml")


@pytest.fixture(scope="session")
def models(case_ii):
    """Everything measured from the models of case ii."""
    from drake_ltl.multibody import MeasureGeometry

    return MeasureGeometry(case_ii)


@pytest.fixture(scope="session")
def mission(case_ii, models):
    """Case ii planned and placed."""
    from drake_ltl.mission import plan_and_place

    return plan_and_place(case_ii, models)


@pytest.fixture(scope="session")
def program(case_ii, models, mission):
    """Case ii in joint coordinates."""
    from drake_ltl.systems.program import mission_program

    return mission_program(mission, models, case_ii)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Fast tests first: whole missions come last."""
    items.sort(key=lambda item: item.get_closest_marker("mission") is not None)
