"""Numbers that planning needs, measured from the models."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from drake_ltl.models import package_xml
from hypothesis import given
from hypothesis import strategies as st
from pydrake.geometry import Box, Capsule, Cylinder, QueryObject, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from drake_ltl.errors import InvalidInputError
from drake_ltl.multibody import MeasureGeometry
from drake_ltl.multibody.measure import STANDOFF_GAP
from drake_ltl.multibody.object_model import ObjectModel
from drake_ltl.multibody.radii import bounding_radius, round_up


@pytest.fixture(scope="module")
def measured(case_ii):
    """Case ii without any radius in the file."""
    return MeasureGeometry(
        replace(
            case_ii,
            agents=tuple(replace(agent, radius=None) for agent in case_ii.agents),
            objects=tuple(replace(obj, radius=None, team_radius=None) for obj in case_ii.objects),
        )
    )


def surface(shape, X: RigidTransform, rng) -> np.ndarray:
    """Points (n, 3) on a shape that is posed at X: corners and rims, and others at random."""
    match shape:
        case Box():
            points = np.array(list(itertools.product((-0.5, 0.5), repeat=3))) * shape.size()
        case Sphere():
            points = shape.radius() * on_ball(rng)
        case Capsule():
            ball = shape.radius() * on_ball(rng)
            points = np.concatenate([ball + np.array([0, 0, s * shape.length() / 2]) for s in (-1, 1)])
        case Cylinder():
            angle = rng.uniform(0, 2 * np.pi, 200)
            rim = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(200)]) * shape.radius()
            points = np.concatenate([rim + np.array([0, 0, s * shape.length() / 2]) for s in (-1, 1)])
        case _:
            raise TypeError(type(shape).__name__)
    return (X @ points.T).T


def on_ball(rng) -> np.ndarray:
    points = rng.normal(size=(200, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


@pytest.fixture(scope="module")
def arm_surface():
    """arm_surface(q, heading, rng): points on the collision geometry, and the bounding sphere's centre."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    Parser(plant).AddModels(str(package_xml().parent / "agents" / "planar_arm.urdf"))
    plant.Finalize()
    diagram = builder.Build()
    root = diagram.CreateDefaultContext()
    context = plant.GetMyMutableContextFromRoot(root)
    inspector = scene_graph.model_inspector()
    geometries = inspector.GetAllGeometryIds()
    proximity = [g for g in geometries if inspector.GetProximityProperties(g) is not None]

    def points(q, rng):
        plant.SetPositions(context, q)
        query: QueryObject = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(root))
        cloud = [surface(inspector.GetShape(g), query.GetPoseInWorld(g), rng) for g in proximity]
        return np.concatenate(cloud), plant.GetFrameByName("bounding_centre").CalcPoseInWorld(context).translation()

    return points


def test_the_agent_s_sphere_covers_it_in_any_configuration(measured, arm_surface):
    rng = np.random.default_rng(0)
    radius, reached = measured.geometry.agent_radius["a1"], 0.0
    lower, upper = np.array([-1.6, -2.6]), np.array([1.6, 2.6])
    for q in [*itertools.product(*zip(lower, upper, strict=True)), *rng.uniform(lower, upper, size=(300, 2))]:
        cloud, centre = arm_surface([0.0, 0.0, *q], rng)
        reached = max(reached, np.linalg.norm(cloud - centre, axis=1).max())
    assert reached <= radius
    assert radius - reached < 0.02  # not larger than it must be


def test_radii_do_not_depend_on_the_base(measured):
    assert len(set(measured.geometry.agent_radius.values())) <= 2  # headings turn the arm over the base's corners
    assert bounding_radius(measured.agents["a1"]) == measured.geometry.agent_radius["a1"]


def test_the_object_s_sphere_covers_it(measured, make_object):
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    Parser(plant).AddModels(str(package_xml().parent / "objects" / "crate.sdf"))
    plant.Finalize()
    inspector = scene_graph.model_inspector()
    rng = np.random.default_rng(0)
    clouds = [
        surface(inspector.GetShape(g), inspector.GetPoseInFrame(g), rng)
        for g in plant.GetCollisionGeometriesForBody(plant.GetBodyByName("crate"))
    ]
    cloud = np.concatenate(clouds)
    radius = measured.geometry.object_radius["o1"]
    assert np.linalg.norm(cloud, axis=1).max() <= radius
    assert radius <= np.linalg.norm(cloud, axis=1).max() + 0.002
    crate = ObjectModel(make_object())
    assert measured.geometry.object_height["o1"] == pytest.approx(-cloud[:, 2].min(), abs=1e-3)
    assert crate.mass == pytest.approx(0.5)


@given(yaw_error=st.floats(-0.01, 0.01), sag=st.floats(-0.01, 0.01))
def test_the_team_s_sphere_covers_every_grasp(measured, arm_surface, yaw_error, sag):
    """Also where joints give way a little."""
    rng = np.random.default_rng(0)
    (plus, minus) = (g for g in measured.grasps["a1", "o1"])  # the agent whose heading is zero
    height = measured.geometry.object_height["o1"]
    for grasp in (plus, minus):
        cloud, _ = arm_surface(grasp.q + np.array([yaw_error, sag, yaw_error, sag]), rng)
        reach = np.linalg.norm(cloud - [0.0, 0.0, height], axis=1).max()
        assert reach <= measured.geometry.team_radius["o1"]


def test_the_team_s_sphere_ends_at_the_farthest_corner_of_a_base(measured):
    """By hand: bases do not turn, their lower corners stand 0.24 m below Oo. And a little slack."""
    corners = np.array(list(itertools.product((-0.25, 0.25), (-0.25, 0.25))))
    reach = max(
        np.hypot(0.24, np.linalg.norm(grasp.q[:2] + corners, axis=1).max())
        for (_, obj), grasps in measured.grasps.items()
        for grasp in grasps
        if obj == "o1"
    )
    assert reach < measured.geometry.team_radius["o1"] < reach + 0.05


def test_given_radii_are_taken_as_they_are(case_ii):
    scenario = replace(
        case_ii,
        agents=tuple(replace(a, radius=1.3 + 0.1 * k) for k, a in enumerate(case_ii.agents)),
        objects=tuple(replace(o, radius=0.55, team_radius=2.9 + 0.1 * k) for k, o in enumerate(case_ii.objects)),
    )
    geometry = MeasureGeometry(scenario).geometry
    assert geometry.agent_radius == pytest.approx({"a1": 1.3, "a2": 1.4, "a3": 1.5})
    assert geometry.object_radius == {"o1": 0.55, "o2": 0.55}
    assert geometry.team_radius == pytest.approx({"o1": 2.9, "o2": 3.0})


@pytest.mark.parametrize("which", ["measured", "models"])
def test_stand_offs_are_clear_of_the_object(request, which):
    models = request.getfixturevalue(which)
    geometry = models.geometry
    for (agent, obj), options in geometry.grasps.items():
        assert options
        clear = geometry.agent_radius[agent] + geometry.object_radius[obj]
        for option in options:
            assert np.linalg.norm(option.p_OoC_standoff) >= clear + STANDOFF_GAP - 1e-9
            way = np.subtract(option.p_OoC_grasp, option.p_OoC_standoff)
            (grasp,) = (g for g in models.grasps[agent, obj] if g.name == option.name)
            forwards = grasp.X_OE.rotation().matrix()[:, 2]
            np.testing.assert_allclose(np.cross(way, forwards), 0.0, atol=1e-9)  # straight ahead
            assert way @ forwards >= 0.25 - 1e-9


def test_options_stand_where_their_configurations_do(measured):
    for (agent, obj), options in measured.geometry.grasps.items():
        height = measured.geometry.object_height[obj]
        for option, grasp in zip(options, measured.grasps[agent, obj], strict=True):
            centre = measured.agents[agent].centre(grasp.q) - [0.0, 0.0, height]
            np.testing.assert_allclose(option.p_OoC_grasp, centre, atol=1e-9)
            arm = measured.postures[agent][option.standoff_posture]
            np.testing.assert_allclose(arm, grasp.q[2:], atol=1e-6)


def test_postures_are_seen_from_the_base(measured):
    for agent, table in measured.geometry.postures.items():
        assert list(table) == list(measured.postures[agent])
        for name, offset in table.items():
            q = np.array([2.0, -3.0, *measured.postures[agent][name]])
            centre = measured.agents[agent].centre(q)
            np.testing.assert_allclose(centre - [2.0, -3.0, 0.0], offset, atol=1e-9)


def test_the_start_posture_comes_first(case_ii):
    agents = (replace(case_ii.agents[0], joints=(0.2, -0.3)), *case_ii.agents[1:])
    models = MeasureGeometry(replace(case_ii, agents=agents))
    assert next(iter(models.postures["a1"])) == "start"
    np.testing.assert_array_equal(models.postures["a1"]["start"], [0.2, -0.3])


@given(st.floats(0.0, 100.0))
def test_lengths_are_rounded_up_to_a_millimetre(length):
    rounded = round_up(length)
    assert length - 1e-11 <= rounded < length + 1e-3
    assert rounded * 1e3 == pytest.approx(round(rounded * 1e3), abs=1e-6)


def test_an_arm_cannot_start_beyond_its_limits(case_ii):
    agents = (replace(case_ii.agents[0], joints=(9.0, 0.0)), *case_ii.agents[1:])
    with pytest.raises(InvalidInputError, match=r"agents\.a1\.joints: 9\.0 is beyond the limits of joint q1"):
        MeasureGeometry(replace(case_ii, agents=agents))
