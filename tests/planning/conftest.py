"""The paper's two cases, and small worlds to plan in."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import pytest

from drake_ltl.planning.plan import State
from drake_ltl.scenario.model import Agent, PublishedFits, Region, Scenario, TransportObject

CENTRES = {
    "pi1": (0.0, 0.0, 0.0),
    "pi2": (-14.0, -14.0, 0.0),
    "pi3": (20.0, -10.0, 0.0),
    "pi4": (-16.0, 15.0, 0.0),
}
PUBLISHED = PublishedFits(agent=1.25, grasping=2.5, object=0.5, capacity=5.75)


def _scenario(
    agents: Mapping[str, tuple[float, str]],
    objects: Mapping[str, tuple[float, str]],
    centres: Mapping[str, tuple[float, float, float]] | None = None,
    spec: str = "1",
    **others: object,
) -> Scenario:
    """Agents by (power, formula), objects by (power needed, formula)."""
    return Scenario(
        name="test",
        workspace_radius=30.0,
        regions=tuple(Region(name, centre, 3.5) for name, centre in (centres or CENTRES).items()),
        agents=tuple(Agent(name, "", (0.0, 0.0), 0.0, power, own) for name, (power, own) in agents.items()),
        objects=tuple(TransportObject(name, "", (0.0, 0.0), need, own) for name, (need, own) in objects.items()),
        spec=spec,
        **{"fits": PUBLISHED, **others},
    )


@pytest.fixture(scope="session")
def make_scenario() -> Callable[..., Scenario]:
    return _scenario


@pytest.fixture(scope="session")
def case_i() -> tuple[Scenario, State]:
    """Case i of the paper and its initial state."""
    scenario = _scenario(
        {"a1": (2.0, "G !pi3"), "a2": (4.0, "GF pi3")},
        {"o1": (5.0, "GF pi1 & G(pi1 -> X pi4)"), "o2": (6.0, "F pi4")},
    )
    return scenario, State(("pi1", "pi3"), ("pi2", "pi1"), (None, None))


@pytest.fixture(scope="session")
def case_ii() -> tuple[Scenario, State]:
    """Case ii of the paper and its initial state."""
    scenario = _scenario(
        {"a1": (2.0, "G !pi3"), "a2": (4.0, "GF pi3"), "a3": (3.0, "1")},
        {"o1": (5.0, "GF pi1 & G(pi1 -> F pi4)"), "o2": (6.0, "GF pi3")},
    )
    return scenario, State(("pi1", "pi3", "pi4"), ("pi2", "pi1"), (None, None, None))
