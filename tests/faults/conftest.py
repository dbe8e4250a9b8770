"""A mission that either of two robots can carry out, and what became of it when one of them stopped on its way."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from drake_ltl import mission
from drake_ltl.scenario import Scenario, loads

RELAY = """\
name: relay
workspace: {radius: 12.0}
regions:
  left: {centre: [-6.0, 0.0, 0.0], radius: 3.6}
  right: {centre: [6.0, 0.0, 0.0], radius: 3.6}
  top: {centre: [0.0, 8.0, 0.0], radius: 2.8}
agents:
  a1: {model: "package://drake_ltl_models/agents/planar_arm.urdf", position: [-6.5, 1.5], radius: 1.25}
  a2: {model: "package://drake_ltl_models/agents/planar_arm.urdf", position: [-6.5, -1.6], radius: 1.25}
objects: {}
spec: "F(a1.right | a2.right)"
"""


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
