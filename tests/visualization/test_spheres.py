from hypothesis import given
from hypothesis import strategies as st

from drake_ltl.systems.signals import Mode
from drake_ltl.visualization.spheres import CARRIES, shown_agents, shown_objects, shown_teams, team_of

NUM_OBJECTS = 3
MODES = st.lists(st.integers(0, Mode.TRANSPORT + NUM_OBJECTS - 1), min_size=1, max_size=5)


@given(MODES)
def test_every_body_is_covered_by_exactly_one_visible_sphere(modes):
    agents, objects = shown_agents(modes), shown_objects(modes, NUM_OBJECTS)
    teams = shown_teams(modes, NUM_OBJECTS)
    assert [own + team for own, team in zip(objects, teams, strict=True)] == [1] * NUM_OBJECTS
    for agent, own in enumerate(agents):
        in_teams = sum(shown for obj, shown in enumerate(teams) if agent in team_of(modes, obj))
        assert own + in_teams == 1


def test_a_team_is_shown_only_while_it_carries():
    assert shown_teams([Mode.HOLD, Mode.REACH], 2) == [False, False]
    assert shown_teams([Mode.TRANSITION, Mode.TRANSPORT + 1], 2) == [False, True]


def test_carrying_is_what_the_supervisor_says():
    assert CARRIES == Mode.TRANSPORT
