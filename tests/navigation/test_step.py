"""The relations of a plan step: exactly the paper's list, on its first example and on corner cases."""

from collections import Counter

import numpy as np
import pytest

from drake_ltl.errors import InvalidInputError
from drake_ltl.navigation import (
    NavigationFunction,
    Reach,
    RegionBall,
    StaticBody,
    Transport,
    Traveller,
    step_relations,
)

REGIONS = [
    RegionBall("pi1", (-15.0, -15.0, 0.0), 4.0),
    RegionBall("pi2", (15.0, -15.0, 0.0), 4.0),
    RegionBall("pi3", (15.0, 15.0, 0.0), 4.0),
    RegionBall("pi4", (-15.0, 15.0, 0.0), 4.0),
]


def example_1():
    """Teams {1, 5} and {3, 4} carry objects 1 and 3, agent 2 grasps object 2, agent 6 travels."""
    return step_relations(
        travellers=[Traveller("a6", 1.2, "pi4", "pi2", (-13.0, 15.0, 1.0), (13.0, -15.0, 1.0))],
        transports=[
            Transport("o1", ("a1", "a5"), 2.5, "pi1", "pi4", (-15.0, -15.0, 0.3), (-15.0, 15.0, 0.3)),
            Transport("o3", ("a3", "a4"), 2.6, "pi3", "pi1", (15.0, 15.0, 0.3), (-15.0, -15.0, 0.3)),
        ],
        reaches=[Reach("a2", ((17.35, -15.0, 1.0), (17.0, -15.0, 1.0)), (1.1, 1.3))],
        static_objects=[StaticBody("o2", 0.5, (15.5, -15.0, 0.3))],
        regions=REGIONS,
        workspace_radius=40.0,
    )


EXAMPLE_1 = {
    "agent-agent": [("a6", "a2 at the stand-off"), ("a6", "a2 at the grasp")],
    "agent-object": [("a6", "o2")],
    "agent-team": [
        ("a6", "o1"),
        ("a6", "o3"),
        ("a2 at the stand-off", "o1"),
        ("a2 at the grasp", "o1"),
        ("a2 at the stand-off", "o3"),
        ("a2 at the grasp", "o3"),
    ],
    "team-team": [("o1", "o3")],
    "team-object": [("o1", "o2"), ("o3", "o2")],
    "agent-region": [("a6", "pi1"), ("a6", "pi3")],
    "team-region": [("o1", "pi2"), ("o1", "pi3"), ("o3", "pi2"), ("o3", "pi4")],
    "agent-workspace": [("a6",)],
    "team-workspace": [("o1",), ("o3",)],
}


def by_kind(step):
    kinds = {}
    for label in step.relations.labels:
        kinds.setdefault(label.kind, []).append(label.names)
    return {kind: sorted(names) for kind, names in kinds.items()}


def test_example_1_of_the_paper_has_exactly_its_relations():
    assert by_kind(example_1()) == {kind: sorted(names) for kind, names in EXAMPLE_1.items()}


def test_example_1_leaves_out_members_carried_objects_grasped_pairs_and_what_stands():
    step = example_1()

    assert not {"a1", "a3", "a4", "a5"} & set(step.points)
    for label in step.relations.labels:
        assert set(label.names) & set(step.movers), "a relation without a mover is a constant"
    assert Counter(label.names[0] for label in step.relations.labels)["o2"] == 0


def test_points_are_movers_then_what_stands():
    step = example_1()

    assert step.movers == ("a6", "o1", "o3")
    assert step.points == (
        *step.movers,
        "a2 at the stand-off",
        "a2 at the grasp",
        "o2",
        "pi1",
        "pi2",
        "pi3",
        "pi4",
    )
    assert step.index("a2 at the grasp") == 4
    np.testing.assert_array_equal(step.goal[step.index("o3")], [-15.0, -15.0, 0.3])
    np.testing.assert_array_equal(step.goal[3:], step.start[3:])
    with pytest.raises(KeyError, match="no point 'a1' in this step; points are a6"):
        step.index("a1")


def test_betas_of_example_1_by_hand():
    step = example_1()
    betas = dict(
        zip(
            ((label.kind, label.names) for label in step.relations.labels),
            step.relations.betas(step.start),
            strict=True,
        )
    )

    def squared(*difference):
        return float(np.square(difference).sum())

    expected = {
        ("agent-team", ("a6", "o1")): squared(2.0, 30.0, 0.7) - (1.2 + 2.5) ** 2,
        ("agent-team", ("a2 at the grasp", "o3")): squared(2.0, 30.0, 0.7) - (1.3 + 2.6) ** 2,
        ("team-team", ("o1", "o3")): squared(30.0, 30.0) - (2.5 + 2.6) ** 2,
        ("team-object", ("o3", "o2")): squared(0.5, 30.0) - (2.6 + 0.5) ** 2,
        ("agent-region", ("a6", "pi3")): squared(28.0, 0.0, 1.0) - (1.2 + 4.0) ** 2,
        ("team-region", ("o3", "pi4")): squared(30.0, 0.0, 0.3) - (2.6 + 4.0) ** 2,
        ("agent-workspace", ("a6",)): (40.0 - 1.2) ** 2 - squared(13.0, 15.0, 1.0),
        ("team-workspace", ("o3",)): (40.0 - 2.6) ** 2 - squared(15.0, 15.0, 0.3),
    }
    for label, beta in expected.items():
        assert betas[label] == pytest.approx(beta, rel=1e-13), label


def test_at_fills_in_the_movers_and_broadcasts():
    step = example_1()
    p_movers = np.random.default_rng(0).normal(size=(5, 2, 3, 3))

    p = step.at(p_movers)

    assert p.shape == (5, 2, 10, 3)
    np.testing.assert_array_equal(p[..., :3, :], p_movers)
    np.testing.assert_array_equal(p[4, 1, 3:], step.start[3:])
    np.testing.assert_array_equal(step.at(step.start[:3]), step.start)


def test_the_navigation_function_of_example_1_is_defined_from_start_to_goal():
    step = example_1()
    nf = NavigationFunction.for_goal(step.relations, step.goal, kappa=20.0)
    gamma = np.square(step.goal - step.start).sum()

    assert step.relations.violated(step.start) == []
    assert 0.0 < nf.value(gamma, step.start) < np.inf


def test_static_agents_count_for_movers_and_not_for_each_other():
    step = step_relations(
        travellers=[Traveller("a1", 1.0, "pi1", "pi2", (-15.0, -15.0, 1.0), (15.0, -15.0, 1.0))],
        static_agents=[StaticBody("a2", 1.0, (15.0, 15.0, 1.0)), StaticBody("a3", 1.5, (15.0, 12.0, 1.0))],
        static_objects=[StaticBody("o1", 0.5, (15.0, 13.8, 0.3))],
        regions=REGIONS,
        workspace_radius=40.0,
    )

    assert by_kind(step) == {
        "agent-agent": [("a1", "a2"), ("a1", "a3")],
        "agent-object": [("a1", "o1")],
        "agent-region": [("a1", "pi3"), ("a1", "pi4")],
        "agent-workspace": [("a1",)],
    }
    assert [apart.radius for apart in step.relations.apart] == [2.0, 2.5, 1.5, 5.0, 5.0]


def test_who_travels_within_a_region_stays_in_it_and_avoids_the_others():
    step = step_relations(
        travellers=[Traveller("a1", 1.0, "pi1", "pi1", (-16.0, -15.0, 0.0), (-14.0, -15.0, 0.0))],
        transports=[Transport("o1", ("a2",), 2.5, "pi3", "pi3", (15.0, 15.0, 0.0), (15.5, 15.0, 0.0))],
        regions=REGIONS[:3],
        workspace_radius=40.0,
    )

    assert by_kind(step) == {
        "agent-team": [("a1", "o1")],
        "agent-region": [("a1", "pi2"), ("a1", "pi3")],
        "team-region": [("o1", "pi1"), ("o1", "pi2")],
        "agent-workspace": [("a1",)],
        "agent-inside": [("a1", "pi1")],
        "team-workspace": [("o1",)],
        "team-inside": [("o1", "pi3")],
    }
    (stays,) = [inside for inside in step.relations.inside if inside.label.kind == "agent-inside"]
    assert stays.centre == (-15.0, -15.0, 0.0)
    assert stays.radius == 3.0
    leaving = step.start.copy()
    leaving[0] = [-11.9, -15.0, 0.0]
    assert [label.kind for label in step.relations.violated(leaving)] == ["agent-inside"]


def test_a_step_in_which_nothing_moves_has_no_relations():
    step = step_relations(static_agents=[StaticBody("a1", 1.0, (0.0, 0.0, 1.0))], workspace_radius=10.0)

    assert len(step.relations) == 0
    assert step.movers == ()


def traveller(name="a1", radius=1.0, start="pi1", goal="pi2"):
    return Traveller(name, radius, start, goal, (-15.0, -15.0, 1.0), (15.0, -15.0, 1.0))


@pytest.mark.parametrize(
    ("bodies", "message"),
    [
        ({"static_agents": [StaticBody("a1", 1.0, (0.0, 0.0, 1.0))]}, "a1: takes part more than once"),
        (
            {"transports": [Transport("o1", ("a1",), 2.5, "pi1", "pi2", (0, 0, 0), (1, 0, 0))]},
            "a1: takes part more than once",
        ),
        ({"travellers": [traveller(goal="pi9")]}, r"a1: unknown region 'pi9'; use one of \['pi1'"),
        ({"travellers": [traveller(radius=40.0)]}, "a1: radius 40.0 is not below the workspace's 40.0"),
        ({"travellers": [traveller(radius=4.5, goal="pi1")]}, "a1: radius 4.5 does not fit"),
        ({"travellers": [traveller(name="pi3")]}, "pi3: takes part more than once"),
    ],
)
def test_what_makes_no_step_is_refused(bodies, message):
    arguments = {"travellers": [traveller()], "regions": REGIONS, "workspace_radius": 40.0, **bodies}
    with pytest.raises(InvalidInputError, match=message):
        step_relations(**arguments)
