"""The assembled diagram, in its start context."""

from __future__ import annotations

import logging

import numpy as np
import pytest
from drake_ltl.diagrams import MakeMissionDiagram
from drake_ltl.models import package_xml
from pydrake.systems.analysis import InitializeParams, Simulator
from pydrake.systems.framework import DiagramBuilder, InputPortIndex
from pydrake.systems.primitives import ConstantVectorSource

from drake_ltl.mission import measure, plan_and_place
from drake_ltl.scenario import loads
from drake_ltl.systems.program import start_configuration
from drake_ltl.systems.signals import Mode


@pytest.fixture
def root(mission_diagram):
    return mission_diagram.CreateStartContext()


def plant_of(mission_diagram, root):
    plant = mission_diagram.transport_plant.plant
    return plant, plant.GetMyContextFromRoot(root)


def test_the_start_context_holds_nothing(mission_diagram, root):
    plant, context = plant_of(mission_diagram, root)
    assert not any(plant.GetConstraintActiveStatus(context, w) for w in mission_diagram.transport_plant.weld_ids)


def test_the_start_context_has_everybody_in_place_and_at_rest(mission_diagram, root, mission, case_ii, models):
    plant, context = plant_of(mission_diagram, root)
    parts = mission_diagram.transport_plant
    layout = mission.steps[0].before
    for agent in case_ii.agents:
        q = plant.GetPositions(context, parts.agents[agent.name])
        np.testing.assert_array_equal(q, start_configuration(layout.agents[agent.name], agent.name, models))
        np.testing.assert_allclose(q[:2], agent.position, atol=1e-9)  # where the scenario wants the base
    for obj in case_ii.objects:
        body = plant.GetBodyByName("crate", parts.objects[obj.name])
        np.testing.assert_allclose(body.EvalPoseInWorld(context).translation()[:2], obj.position, atol=1e-9)
    np.testing.assert_array_equal(plant.GetVelocities(context), 0.0)


def test_nothing_touches_at_the_start(mission_diagram, root):
    Simulator(mission_diagram.diagram, root).Initialize()  # contact is worked out with the torques of this instant
    plant, context = plant_of(mission_diagram, root)
    results = plant.get_contact_results_output_port().Eval(context)
    floor_contacts = 2 * 4  # the feet of two crates
    assert results.num_point_pair_contacts() <= floor_contacts


def test_everything_has_a_name(mission_diagram, separate_diagram):
    agents, objects = ("a1", "a2", "a3"), ("o1", "o2")
    common = {"plant", "scene_graph", "plan_supervisor", "actuation"}
    common |= {"log_state", "log_torque", "support", "log_record", "member_centres"}
    common |= {f"monitor_{name}" for name in mission_diagram.monitors}
    separate = {"navigation_field", "controls", *(f"transport_{obj}" for obj in objects)}
    separate |= {f"{kind}_{agent}" for kind in ("hold", "transition", "reach", "switch") for agent in agents}
    for made, controllers in ((mission_diagram, {"mission_controller"}), (separate_diagram, separate)):
        names = [system.get_name() for system in made.diagram.GetSystems()]
        assert sorted(names) == sorted(common | controllers)
        assert made.diagram.get_name() == "case_ii"


def test_nothing_is_warned_about(mission_diagram, caplog):
    with caplog.at_level(logging.WARNING, logger="drake"):
        mission_diagram.CreateStartContext()
    assert caplog.records == []


def test_switches_select_in_the_order_of_modes(separate_diagram):
    for agent in ("a1", "a2", "a3"):
        switch = separate_diagram.diagram.GetSubsystemByName(f"switch_{agent}")
        ports = [switch.get_input_port(i).get_name() for i in range(switch.num_input_ports())]
        assert ports[1:] == ["hold", "transition", "reach", "transport_o1", "transport_o2"]
        assert [Mode.HOLD, Mode.TRANSITION, Mode.REACH, Mode.TRANSPORT] == [0, 1, 2, 3]


def test_the_selected_controller_drives_the_agent(separate_diagram):
    """After initialization a1 holds and a2 travels: what their plant is actuated with are these torques."""
    diagram, root = separate_diagram.diagram, separate_diagram.CreateStartContext()
    simulator = Simulator(diagram, root)
    simulator.Initialize()
    plant, _ = plant_of(separate_diagram, root)
    supervisor, actuation = separate_diagram.supervisor, plant.MakeActuationMatrix()
    for agent, kind in (("a1", "hold"), ("a2", "transition")):
        mode = supervisor.get_mode_output_port(agent).Eval(supervisor.GetMyContextFromRoot(root))
        assert mode == InputPortIndex(1 + (Mode.HOLD if kind == "hold" else Mode.TRANSITION))
        instance = separate_diagram.transport_plant.agents[agent]
        controller = diagram.GetSubsystemByName(f"{kind}_{agent}")
        torque = controller.get_torque_output_port().Eval(controller.GetMyContextFromRoot(root))
        applied = actuation @ plant.get_actuation_input_port().Eval(plant.GetMyContextFromRoot(root))
        np.testing.assert_array_equal(plant.GetVelocitiesFromArray(instance, applied), torque)


def test_torques_reach_their_joints_in_whatever_order_the_actuators_are(shuttle_text, tmp_path):
    """A model's transmissions, and with them Drake's actuators, may stand in another order than its joints."""
    text = (package_xml().parent / "agents" / "planar_arm.urdf").read_text(encoding="utf-8")
    start, last = text.index('<transmission name="x">'), text.index('<transmission name="q2">')
    end = text.index("</robot>")
    (tmp_path / "arm.urdf").write_text(text[:start] + text[last:end] + text[start:last] + text[end:], encoding="utf-8")
    scenario = loads(
        shuttle_text.replace("package://drake_ltl_models/agents/planar_arm.urdf", "arm.urdf"), base=tmp_path
    )
    models = measure(scenario)
    diagram = MakeMissionDiagram(plan_and_place(scenario, models), scenario, models, num_steps=1)
    simulator = Simulator(diagram.diagram, diagram.CreateStartContext())
    simulator.Initialize()
    plant, context = plant_of(diagram, simulator.get_mutable_context())
    controller = diagram.diagram.GetSubsystemByName("mission_controller")
    torque = controller.get_torque_output_port().Eval(controller.GetMyContextFromRoot(simulator.get_context()))
    actuation = plant.get_actuation_input_port().Eval(context)
    assert np.abs(torque - actuation).max() > 0.1  # they do stand in another order
    np.testing.assert_array_equal(plant.MakeActuationMatrix() @ actuation, torque)


def state(simulator) -> np.ndarray:
    """All discrete state, of plant and supervisor."""
    values = simulator.get_context().get_discrete_state()
    return np.concatenate([values.value(i) for i in range(values.num_groups())])


def test_two_contexts_are_independent(mission_diagram):
    """One diagram, two missions: advanced in turns, each goes on as if it were alone."""
    alone = Simulator(mission_diagram.diagram, mission_diagram.CreateStartContext())
    alone.AdvanceTo(0.3)
    first = Simulator(mission_diagram.diagram, mission_diagram.CreateStartContext())
    second = Simulator(mission_diagram.diagram, mission_diagram.CreateStartContext())
    plant = mission_diagram.transport_plant.plant
    moved = plant.GetMyMutableContextFromRoot(second.get_mutable_context())
    a1 = mission_diagram.transport_plant.agents["a1"]
    plant.SetPositions(moved, a1, plant.GetPositions(moved, a1) + np.array([0.1, 0.0, 0.0, 0.0]))
    for time in (0.1, 0.2, 0.3):
        first.AdvanceTo(time)
        second.AdvanceTo(time)
    np.testing.assert_array_equal(state(first), state(alone))
    assert not np.array_equal(state(second), state(alone))


def test_a_context_can_be_cloned(mission_diagram):
    simulator = Simulator(mission_diagram.diagram, mission_diagram.CreateStartContext())
    simulator.AdvanceTo(0.1)
    clone = simulator.get_context().Clone()
    simulator.AdvanceTo(0.2)
    other = Simulator(mission_diagram.diagram, clone)
    other.Initialize(InitializeParams(suppress_initialization_events=True))  # the mission has begun
    assert clone.get_time() == pytest.approx(0.1)
    other.AdvanceTo(0.2)
    np.testing.assert_array_equal(state(other), state(simulator))


def test_the_graph_shows_controllers_and_switches(separate_diagram):
    dot = separate_diagram.diagram.GetGraphvizString(max_depth=1)
    for name in ("plan_supervisor", "navigation_field", "transition_a1", "transport_o2", "switch_a3", "reach_a2"):
        assert name in dot
    assert "PortSwitch" in dot


def test_users_may_bring_systems_of_their_own(mission, case_ii, models):
    builder = DiagramBuilder()
    builder.AddNamedSystem("mine", ConstantVectorSource([1.0]))
    made = MakeMissionDiagram(mission, case_ii, models, num_steps=1, builder=builder)
    assert made.diagram.GetSubsystemByName("mine").get_output_port().size() == 1


# Monitors.


def test_monitors_by_name(mission, case_ii, models):
    def names(monitors) -> set[str]:
        return set(MakeMissionDiagram(mission, case_ii, models, num_steps=1, monitors=monitors).monitors)

    assert names({"geometry", "word"}) == {"geometry", "word"}
    assert names(False) == set()
    assert names(True) == {"spheres", "arrival", "word", "lyapunov", "torque", "weld", "geometry"}
    with pytest.raises(ValueError, match="no monitors are called sphere; there are arrival, "):
        names({"sphere"})
