from pathlib import Path

import numpy as np
import pytest
from drake_ltl.diagrams.quiet import without_half_space_warning
from drake_ltl.diagrams.transport_plant import AddTransportPlant
from pydrake.geometry import Role
from pydrake.systems.framework import DiagramBuilder

from drake_ltl.multibody import MeasureGeometry
from drake_ltl.scenario import load
from drake_ltl.systems.signals import NO_GRASP, Mode
from drake_ltl.visualization.meshcat_scene import DrawWorkspace, MakeMeshcat, _paint_agents, grid_spacing
from drake_ltl.visualization.mission_overlay import MissionOverlay, member_path, name_path, sphere_path, team_path
from drake_ltl.visualization.palette import agent_colours

EXAMPLE = Path(__file__).parents[2] / "examples" / "case_ii.yaml"


@pytest.fixture(scope="module")
def case_ii():
    scenario = load(EXAMPLE)
    return scenario, MeasureGeometry(scenario)


@pytest.fixture(scope="module")
def meshcat():
    return MakeMeshcat()


def publish(overlay, models, modes, q, origins):
    context = overlay.CreateDefaultContext()
    status = np.array([0, 0, *modes, *[NO_GRASP] * len(modes)], dtype=float)
    overlay.get_status_input_port().FixValue(context, status)
    for name, model in models.agents.items():
        overlay.get_state_input_port(name).FixValue(context, np.concatenate([q[name], np.zeros(model.n)]))
    for name, p_WO in origins.items():
        overlay.get_state_input_port(name).FixValue(context, np.concatenate([[1.0, 0, 0, 0], p_WO, np.zeros(6)]))
    overlay.ForcedPublish(context)


def is_visible(meshcat, path: str) -> bool:
    """The packed property ends with the value: 0xc3 is true and 0xc2 is false in MessagePack."""
    return {b"\xc3": True, b"\xc2": False}[meshcat._GetPackedProperty(path, "visible")[-1:]]


def position(meshcat, path: str) -> np.ndarray:
    """Translation of a packed transform: 16 big-endian doubles by columns, each after its MessagePack type."""
    packed = meshcat._GetPackedTransform(path)[-16 * 9 :]
    return np.array([np.frombuffer(packed[9 * i + 1 : 9 * i + 9], dtype=">f8")[0] for i in (12, 13, 14)])


def test_overlay_shows_one_sphere_for_each_body(case_ii, meshcat):
    _, models = case_ii
    overlay = MissionOverlay(models, meshcat, name_height=1.0)
    q = {name: np.array([i, 2.0 * i, 0.3, 0.4]) for i, name in enumerate(models.agents)}
    origins = {name: np.array([5.0, i, 0.25]) for i, name in enumerate(models.objects)}

    publish(overlay, models, [Mode.HOLD, Mode.TRANSITION, Mode.REACH], q, origins)
    assert all(is_visible(meshcat, sphere_path(name)) for name in (*models.agents, *models.objects))
    assert not any(is_visible(meshcat, team_path(name)) for name in models.objects)

    publish(overlay, models, [Mode.HOLD, Mode.TRANSPORT + 1, Mode.TRANSPORT + 1], q, origins)
    shown = {name: is_visible(meshcat, sphere_path(name)) for name in (*models.agents, *models.objects)}
    assert shown == {"a1": True, "a2": False, "a3": False, "o1": True, "o2": False}
    assert [is_visible(meshcat, team_path(name)) for name in models.objects] == [False, True]

    for name, model in models.agents.items():
        np.testing.assert_allclose(position(meshcat, member_path(name)), model.centre(q[name]), atol=1e-15)
    for name, p_WO in origins.items():
        np.testing.assert_array_equal(position(meshcat, member_path(name)), p_WO)


def test_everything_has_its_name(case_ii, meshcat):
    scenario, models = case_ii
    DrawWorkspace(meshcat, scenario)
    MissionOverlay(models, meshcat, name_height=1.0)
    paths = [name_path(name) for name in (*scenario.agent_names, *scenario.object_names)]
    paths += [f"/mission/regions/{name}/name" for name in scenario.region_names]
    assert all(meshcat.HasPath(path) for path in paths)


def test_drawing_again_leaves_nothing_behind(case_ii, meshcat):
    scenario, _ = case_ii
    meshcat.SetProperty("/mission/members/of_another_scenario", "visible", True)
    DrawWorkspace(meshcat, scenario)
    assert not meshcat.HasPath("/mission/members/of_another_scenario")


def test_agents_wear_their_colours(case_ii):
    scenario, models = case_ii
    with without_half_space_warning():
        parts = AddTransportPlant(DiagramBuilder(), scenario, models)
    before = parts.scene_graph.model_inspector().NumGeometriesWithRole(Role.kIllustration)
    _paint_agents(parts)
    inspector = parts.scene_graph.model_inspector()
    assert inspector.NumGeometriesWithRole(Role.kIllustration) == before
    for name, colour in agent_colours(scenario.agent_names).items():
        painted = [
            inspector.GetIllustrationProperties(geometry).GetProperty("phong", "diffuse")
            for index in parts.plant.GetBodyIndices(parts.agents[name])
            for geometry in parts.plant.GetVisualGeometriesForBody(parts.plant.get_body(index))
            if "accent" in inspector.GetName(geometry)
        ]
        assert painted
        for rgba in painted:
            np.testing.assert_allclose([rgba.r(), rgba.g(), rgba.b()], colour)


@pytest.mark.parametrize(("radius", "spacing"), [(30.0, 5.0), (10.0, 2.0), (5.0, 1.0), (99.0, 10.0), (0.5, 0.1)])
def test_grid_has_round_numbers(radius, spacing):
    assert grid_spacing(radius) == pytest.approx(spacing)
