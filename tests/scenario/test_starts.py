"""Where members stand at the start, compared with trying everything."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_ltl.errors import InvalidInputError
from drake_ltl.planning.geometry import Geometry
from drake_ltl.planning.initial import initial_state
from drake_ltl.planning.plan import State
from drake_ltl.scenario.model import Agent, Region, Scenario, TransportObject
from drake_ltl.scenario.starts import ROOM, check_starts

REGIONS = (Region("pi1", (0.0, 0.0, 0.0), 3.5), Region("pi2", (10.0, 0.0, 0.0), 3.5))
UP = {"up": (0.0, 0.0, 1.0)}
ALL = {**UP, "ahead": (0.8, 0.0, 0.4), "behind": (-0.8, 0.0, 0.4)}


def scenario_of(agents, objects=(), regions=REGIONS, joints=None) -> Scenario:
    """Agents a0, a1, ... and objects o0, o1, ... at the given positions."""
    return Scenario(
        name="starts",
        workspace_radius=1e3,
        regions=regions,
        agents=tuple(Agent(f"a{i}", "", position, 0.0, 1.0, joints=joints) for i, position in enumerate(agents)),
        objects=tuple(TransportObject(f"o{j}", "", position, 1.0) for j, position in enumerate(objects)),
    )


def geometry_of(scenario, postures=None, agent=1.25, obj=0.5) -> Geometry:
    """The same sizes and postures for all."""
    return Geometry(
        agent_radius=dict.fromkeys(scenario.agent_names, agent),
        object_radius=dict.fromkeys(scenario.object_names, obj),
        object_height=dict.fromkeys(scenario.object_names, 0.25),
        team_radius={},
        postures=dict.fromkeys(scenario.agent_names, UP if postures is None else postures),
    )


def lines(scenario, geometry) -> list[str]:
    with pytest.raises(InvalidInputError) as caught:
        check_starts(scenario, geometry)
    return [str(mistake) for mistake in caught.value.mistakes]


def test_regions_and_centres():
    scenario = scenario_of([(0, 0), (10, 1)], [(0, 2)])
    starts = check_starts(scenario, geometry_of(scenario))
    assert {name: (one.region, one.posture, one.p_WC) for name, one in starts.agents.items()} == {
        "a0": ("pi1", "up", (0, 0, 1)),
        "a1": ("pi2", "up", (10, 1, 1)),
    }
    assert (starts.objects["o0"].region, starts.objects["o0"].p_WO) == ("pi1", (0, 2, 0.25))
    assert initial_state(scenario, starts) == State(("pi1", "pi2"), ("pi1",), (None, None))


def test_sphere_outside_all_regions_is_reported_with_the_nearest():
    scenario = scenario_of([(7, 0)], [(0, 5)])
    agent, obj = lines(scenario, geometry_of(scenario))
    missing = math.hypot(3, 1) + 1.25 - 3.5
    assert agent.startswith("agents.a0.position: the bounding sphere at (7, 0, 1) of radius 1.25 m")
    assert f"it reaches {missing:.4g} m out of the nearest, pi2" in agent
    assert obj.startswith("objects.o0.position: ")
    assert "out of the nearest, pi1" in obj


def test_height_counts():
    scenario = scenario_of([(2.2, 0)])  # 2.2 + 1.25 < 3.5, but hypot(2.2, 1) + 1.25 is more
    check_starts(scenario, geometry_of(scenario, {"low": (0.0, 0.0, 0.0)}))
    assert "lies in no region" in lines(scenario, geometry_of(scenario))[0]


@pytest.mark.parametrize(
    ("agents", "objects", "names"),
    [
        ([(0, 0), (2.4, 0)], [], "a0 and a1 overlap by 0.1 m"),
        ([(0, 0)], [(1.5, 0)], "a0 and o0 overlap by 0.07"),
        ([(10, 0)], [(0, 0), (0, 0.9)], "o0 and o1 overlap by 0.1 m"),
    ],
)
def test_touching_spheres_are_reported_as_a_pair(agents, objects, names):
    scenario = scenario_of(agents, objects, regions=(Region("pi1", (0.0, 0.0, 0.0), 20.0),))
    (line,) = lines(scenario, geometry_of(scenario))
    assert names in line


def test_spheres_that_just_touch_are_no_start():
    scenario = scenario_of([(0, 0), (2.5, 0)], regions=(Region("pi1", (0.0, 0.0, 0.0), 20.0),))
    assert "overlap by 0 m" in lines(scenario, geometry_of(scenario))[0]


def test_all_mistakes_at_once():
    scenario = scenario_of([(0, 0), (0.5, 0), (5, 5)], [(10, 0), (10, 0.5)])
    assert sorted(line.split(":")[0] for line in lines(scenario, geometry_of(scenario))) == [
        "agents.a1.position",
        "agents.a2.position",
        "objects.o1.position",
    ]


def test_posture_is_the_first_that_lies_in_a_region():
    scenario = scenario_of([(2.2, 0)])
    assert check_starts(scenario, geometry_of(scenario, ALL)).agents["a0"].posture == "behind"


def test_posture_that_leaves_room_to_the_border_is_preferred():
    """Upright it is 2 cm inside, ahead 3 mm outside, behind 0.8 m inside."""
    scenario = scenario_of([(2.0, 0)])
    assert check_starts(scenario, geometry_of(scenario, ALL)).agents["a0"].posture == "behind"
    tight = geometry_of(scenario, {"up": ALL["up"]})
    assert check_starts(scenario, tight).agents["a0"].posture == "up"


def test_earlier_agent_makes_room_for_a_later_one():
    wide = (Region("pi1", (0.0, 0.0, 0.0), 20.0),)
    scenario = scenario_of([(0, 0), (2.0, 0)], [(3.8, 0)], wide)
    starts = check_starts(scenario, geometry_of(scenario, ALL))
    # a1 must bend away from the crate, so a0 cannot stand upright beside it
    assert [one.posture for one in starts.agents.values()] == ["behind", "up"]
    assert check_starts(scenario_of([(0, 0)], regions=wide), geometry_of(scenario, ALL)).agents["a0"].posture == "up"


def test_given_joints_leave_no_choice():
    scenario = scenario_of([(2.2, 0)], joints=(0.0, 0.0))
    geometry = geometry_of(scenario, {"start": (0.0, 0.0, 1.0), "behind": (-0.8, 0.0, 0.4)})
    assert "lies in no region" in lines(scenario, geometry)[0]


def test_unmeasured_agent_is_centred_on_its_base():
    scenario = scenario_of([(2.2, 0)])
    assert check_starts(scenario, geometry_of(scenario, {})).agents["a0"].p_WC == (2.2, 0, 0)


def test_many_agents_with_a_hopeless_pair_are_judged_at_once():
    """Trying all combinations of 24 agents with 3 postures would never end."""
    count = 24
    regions = tuple(Region(f"pi{k}", (10.0 * k, 0.0, 0.0), 4.0) for k in range(count))
    positions = [(10.0 * k, 0.0) for k in range(count)]
    scenario = scenario_of(positions, regions=regions)
    assert len(check_starts(scenario, geometry_of(scenario, ALL)).agents) == count
    scenario = scenario_of([*positions, positions[-1]], regions=regions)
    (line,) = lines(scenario, geometry_of(scenario, ALL))
    assert line.startswith(f"agents.a{count}.position")


coordinates = st.integers(-8, 8).map(lambda step: step * 0.45)
positions = st.tuples(coordinates, coordinates)


@settings(deadline=None, max_examples=300)
@given(st.lists(positions, min_size=1, max_size=4), st.lists(positions, max_size=2))
def test_choice_is_the_first_of_all_that_work(agents, objects):
    regions = (Region("pi1", (-1.5, 0.0, 0.0), 2.5), Region("pi2", (3.6, 0.0, 0.0), 2.5))
    scenario = scenario_of(agents, objects, regions)
    geometry = geometry_of(scenario, ALL, agent=0.9, obj=0.4)

    def works(names: tuple[str, ...]) -> bool:
        spheres = [
            ((x + ALL[name][0], y + ALL[name][1], ALL[name][2]), 0.9)
            for (x, y), name in zip(agents, names, strict=True)
        ] + [((x, y, 0.25), 0.4) for x, y in objects]
        inside = all(any(math.dist(c, region.centre) + r <= region.radius for region in regions) for c, r in spheres)
        return inside and all(math.dist(c, d) > r + s for (c, r), (d, s) in itertools.combinations(spheres, 2))

    def preferred(agent: tuple[float, float]) -> list[str]:
        """Those first that are ROOM inside."""
        centres = {name: (agent[0] + dx, agent[1] + dy, z) for name, (dx, dy, z) in ALL.items()}
        slack = {name: max(r.radius - math.dist(c, r.centre) - 0.9 for r in regions) for name, c in centres.items()}
        return sorted(ALL, key=lambda name: slack[name] < ROOM)

    expected = next((names for names in itertools.product(*map(preferred, agents)) if works(names)), None)
    if expected is None:
        assert lines(scenario, geometry)
    else:
        starts = check_starts(scenario, geometry)
        assert tuple(one.posture for one in starts.agents.values()) == expected
