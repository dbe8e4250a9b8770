"""Descents and the search for kappa."""

import numpy as np
import pytest

from drake_ltl.errors import InvalidInputError
from drake_ltl.navigation import RegionBall, StaticBody, Traveller, step_relations
from drake_ltl.navigation.detour import arrival_order
from drake_ltl.navigation.planar import PlanarField
from drake_ltl.navigation.tuning import ARRIVED, default_kappas, descend, tune_kappa

HOME = RegionBall("home", (0.0, 0.0, 0.0), 12.0)


OBSTACLES = [(0.0, 0.3, 2.0), (3.0, 6.0, 1.5), (-3.0, -6.0, 1.5), (5.0, -4.0, 1.0)]


def step(start=(-8.0, 0.0), goal=(8.0, 0.0), obstacles=((0.0, 0.0, 2.0),)):
    traveller = Traveller("a", 1.0, "home", "home", (*start, 0.0), (*goal, 0.0))
    static = [StaticBody(f"o{k}", radius, (*centre, 0.0)) for k, (*centre, radius) in enumerate(obstacles)]
    return step_relations(travellers=[traveller], static_objects=static, regions=[HOME], workspace_radius=12.0)


def gathering(n=6, spread=2.62):
    """n agents that go to one region that just holds them."""
    angle = 2.0 * np.pi * np.arange(n) / n
    travellers = [
        Traveller(
            f"a{k}",
            1.25,
            "out",
            "mid",
            (-10.0 + 6.0 * np.cos(t + 0.1), 6.0 * np.sin(t + 0.1), 1.0),
            (12.0 + spread * np.cos(t), spread * np.sin(t), 1.0),
        )
        for k, t in enumerate(angle)
    ]
    regions = [RegionBall("mid", (12.0, 0.0, 0.0), 4.1), RegionBall("out", (-10.0, 0.0, 0.0), 9.0)]
    return step_relations(travellers=travellers, regions=regions, workspace_radius=30.0)


def test_a_descent_goes_around_an_obstacle_and_never_up():
    field = PlanarField.of(step(start=(-8.0, 0.5)), kappa=6.0)

    descent = descend(field, field.start)

    assert descent.outcome == "goal"
    assert np.linalg.norm(descent.end - field.goal) <= 1.01 * ARRIVED
    assert (np.diff(field.value(descent.path)) < 1e-6).all()
    assert not field.function.violated(field.points(descent.path))


def test_a_descent_that_rests_on_a_saddle_goes_on_from_there():
    """The obstacle stands exactly between start and goal, so the way leads straight onto the saddle."""
    field = PlanarField.of(step(), kappa=6.0)

    descent = descend(field, field.start)

    assert (descent.outcome, descent.saddles) == ("goal", 1)


def test_tuning_raises_kappa_until_nothing_gets_stuck_and_says_what_it_saw():
    tuning = tune_kappa(step(goal=(8.0, 1.0), obstacles=OBSTACLES), kappas=[2.0, 8.0, 20.0], n_starts=8)

    assert tuning.kappa == 8.0
    assert [trial.kappa for trial in tuning.trials] == [2.0, 8.0]
    assert tuning.trials[0].count("minimum") > 0
    assert tuning.trials[1].count("goal") == 9
    lines = str(tuning).splitlines()
    assert lines[0].startswith("kappa 2: ")
    assert "minimum at (" in lines[1]
    assert "kappa 8: 9 of 9 starts reach the goal, 0 end in other minima" in str(tuning)
    assert lines[-1] == "kappa = 8"


def test_tuning_says_so_where_no_kappa_was_large_enough():
    tuning = tune_kappa(step(goal=(8.0, 1.0), obstacles=OBSTACLES), kappas=[2.0], n_starts=8)

    assert tuning.kappa is None
    assert str(tuning).endswith("no kappa tried is free of other minima")


def test_a_start_that_touches_something_is_refused():
    with pytest.raises(InvalidInputError, match=r"start: violates a and o0 \(agent-object\)"):
        tune_kappa(step(start=(-1.0, 0.0)))


def test_tuning_is_repeatable():
    assert str(tune_kappa(step(), n_starts=3)) == str(tune_kappa(step(), n_starts=3))


def test_kappas_are_tried_in_increasing_order_up_to_a_hundred():
    kappas = list(default_kappas())

    assert kappas == sorted(kappas)
    assert kappas[0] == 2.0
    assert 100.0 / 1.5 < kappas[-1] <= 100.0


@pytest.mark.parametrize("seed", range(3))
def test_six_agents_arrive_in_a_region_that_just_holds_them_whatever_their_slots(seed):
    """The kappa that a scenario gets by default, 1.25 for each of 21 relations."""
    crowd = gathering()
    rng = np.random.default_rng(seed)
    field = PlanarField.of(crowd, kappa=26.25)
    start = field.start.reshape(6, 2)[rng.permutation(6)].ravel()

    assert descend(field, start).outcome == "goal"


def test_too_small_a_kappa_is_stuck_at_the_workspaces_border_and_tuning_raises_it():
    tuning = tune_kappa(gathering(), kappas=[5.0, 12.0], n_starts=2)

    assert tuning.trials[0].count("minimum") > 0
    assert tuning.kappa == 12.0


def test_innermost_places_are_taken_first():
    goals = np.array([[3.0, 0.0, 1.0], [-3.0, 0.0, 1.0], [0.2, 0.0, 1.0], [0.0, 3.5, 1.0]])

    order = arrival_order(goals)

    assert order[0] == 2
    assert sorted(order) == [0, 1, 2, 3]
