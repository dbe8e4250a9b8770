"""A mission that either of two robots can carry out, and what became of it when one of them stopped on its way."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from drake_ltl import mission
from drake_ltl.scenario import Scenario, loads

MISSIONS = Path(__file__).resolve().parents[2] / "benchmarks" / "missions"


def text_of(name: str) -> str:
    """One of the scenarios of the table of faults."""
    return (MISSIONS / f"{name}.yaml").read_text(encoding="utf-8")


RELAY = text_of("relay").replace(" & F(a1.top | a2.top)", "")
"""One of the two regions is enough here."""


@pytest.fixture(scope="session")
def mission_text() -> Callable[[str], str]:
    """mission_text("relay"): one of the scenarios of the table of faults."""
    return text_of


@pytest.fixture(scope="session")
def relay():
    """(scenario, models, mission) without faults."""
    scenario = loads(RELAY)
    models = mission.measure(scenario)
    return scenario, models, mission.plan_and_place(scenario, models)


@pytest.fixture(scope="session")
def traveller(relay) -> str:
    """Who goes."""
    return relay[2].plan.moves[0][0].agents[0]


@pytest.fixture(scope="session")
def with_fault(relay) -> Callable[[str], Scenario]:
    """with_fault("{kind: ..}"): the scenario with this fault, or with these, one in a line."""

    def make(*faults: str) -> Scenario:
        return loads(RELAY + "faults:\n" + "".join(f"  - {fault}\n" for fault in faults))

    return make


@pytest.fixture(scope="session")
def recovered(relay, traveller, with_fault):
    """(run, scenario): the traveller stops after 1.5 s."""
    _, models, planned = relay
    scenario = with_fault(f"{{kind: agent_stops, agent: {traveller}, time: 1.5}}")
    return mission.simulate(planned, scenario, models, announce=lambda line: None), scenario
