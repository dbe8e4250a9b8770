"""A user's LeafSystem in the place of one of the mission's controllers."""

from __future__ import annotations

import pytest
from drake_ltl.diagrams import MakeMissionDiagram
from pydrake.systems.framework import LeafSystem

from drake_ltl.errors import InvalidInputError
from drake_ltl.mission import measure, plan_and_place
from drake_ltl.scenario import loads


class Own(LeafSystem):
    """Torques of zero, from the ports of a transition controller of the planar arm."""

    def __init__(self, gradient: int = 4, output: str = "torque"):
        super().__init__()
        self.DeclareVectorInputPort("state", 8)
        self.DeclareVectorInputPort("gradient", gradient)
        self.DeclareVectorOutputPort(output, 4, lambda context, value: value.SetFromVector([0.0] * 4))


@pytest.fixture(scope="module")
def parts(shuttle_text):
    scenario = loads(shuttle_text)
    models = measure(scenario)
    return plan_and_place(scenario, models), scenario, models


def test_it_stands_where_the_usual_one_would(parts):
    own = Own()
    made = MakeMissionDiagram(*parts, num_steps=1, own_controllers={"transition_a1": own})
    assert made.diagram.GetSubsystemByName("transition_a1") is own
    switch = made.diagram.GetSubsystemByName("switch_a1")
    graph = made.diagram.connection_map()
    selected = [port.get_name() for (system, port), (source, _) in by_objects(made.diagram, graph) if source is own]
    assert selected == ["transition"]
    assert switch.get_input_port(2).get_name() == "transition"


def by_objects(diagram, graph):
    """Connections as ((system, port), (system, port))."""
    for (system, port), (source, output) in graph.items():
        yield (system, system.get_input_port(port)), (source, source.get_output_port(output))


def test_an_unknown_name_is_refused_with_the_known_ones(parts):
    with pytest.raises(InvalidInputError, match="write one of hold_a1, transition_a1, reach_a1"):
        MakeMissionDiagram(*parts, num_steps=1, own_controllers={"transit_a1": Own()})


@pytest.mark.parametrize(
    ("own", "wanted"), [(Own(gradient=3), "'gradient' of size 4"), (Own(output="tau"), "'torque' of size 4")]
)
def test_ports_that_do_not_fit_are_named(parts, own, wanted):
    with pytest.raises(InvalidInputError, match=wanted):
        MakeMissionDiagram(*parts, num_steps=1, own_controllers={"transition_a1": own})
