"""Objects that rest are borne by a constant force, to the same effect as by the floor."""

from __future__ import annotations

import numpy as np
import pytest
from drake_ltl.diagrams import MakeMissionDiagram
from pydrake.systems.analysis import Simulator

from drake_ltl.execution.resting import RESTING_TIME, Resting

LOOK = 0.25  # [s] between two looks
AFTER = RESTING_TIME + 2 * LOOK  # [s] when everything rests: it settles before the first of these looks
WEIGHT = 0.5 * 9.81  # [N] of a crate


@pytest.fixture(scope="module")
def diagram(mission, case_ii, models):
    return MakeMissionDiagram(mission, case_ii, models, num_steps=1, monitors=False)


class Watched:
    """A run with looks, or without."""

    def __init__(self, diagram, looks: bool = True):
        self.diagram, self.plant = diagram, diagram.transport_plant.plant
        self.simulator = Simulator(diagram.diagram, diagram.CreateStartContext())
        self.root = self.simulator.get_mutable_context()
        self.context = self.plant.GetMyMutableContextFromRoot(self.root)
        self.resting = Resting(diagram) if looks else None
        self.simulator.Initialize()

    def advance(self, until: float) -> None:
        for time in np.arange(self.root.get_time(), until, LOOK):
            if self.resting is not None:
                self.resting.look(self.root)
            self.simulator.AdvanceTo(time + LOOK)

    def support(self, name: str) -> np.ndarray:
        """(6,)"""
        value = self.diagram.support.get_output_port().Eval(self.diagram.support.GetMyContextFromRoot(self.root))
        return self.plant.GetVelocitiesFromArray(self.diagram.transport_plant.objects[name], value)

    def pose(self, name: str) -> np.ndarray:
        return self.plant.GetPositions(self.context, self.diagram.transport_plant.objects[name])

    def contacts(self) -> int:
        return self.plant.get_contact_results_output_port().Eval(self.context).num_point_pair_contacts()


@pytest.fixture
def watched(diagram):
    return lambda **options: Watched(diagram, **options)


def test_what_rests_is_borne_and_stays_where_the_floor_would_keep_it(watched):
    run, floor = watched(), watched(looks=False)
    run.advance(AFTER + LOOK)
    floor.advance(AFTER + LOOK)
    for name in ("o1", "o2"):
        np.testing.assert_allclose(run.support(name), [0, 0, 0, 0, 0, WEIGHT], atol=1e-9)
        np.testing.assert_allclose(run.pose(name), floor.pose(name), atol=1e-7)  # feet still sink, by less than this
    assert floor.contacts() == 8  # feet
    assert run.contacts() == 0


def test_what_moves_is_put_on_the_floor_again(watched, diagram):
    run = watched()
    run.advance(AFTER)
    push = np.array([0.0, 0.0, 0.0, 0.5, 0.0, 0.0])
    run.plant.SetVelocities(run.context, diagram.transport_plant.objects["o2"], push)
    run.advance(AFTER + LOOK)
    assert run.support("o2").tolist() == [0.0] * 6
    assert run.support("o1")[5] > 0.0
    sliding = 0.5**2 / (2 * 0.6 * 9.81)  # [m] until friction stops it
    before = run.pose("o2")[4]
    run.advance(AFTER + 2 * LOOK)
    assert run.pose("o2")[4] - before < sliding
    speed = run.plant.GetVelocities(run.context, diagram.transport_plant.objects["o2"])
    assert np.abs(speed).max() < 1e-3


def test_what_is_held_is_not_borne(watched, diagram):
    run = watched()
    run.advance(AFTER)
    parts = diagram.transport_plant
    weld = next(i for i, w in zip(parts.weld_ids, parts.welds, strict=True) if w.object == "o1")
    run.plant.SetConstraintActiveStatus(run.context, weld, True)
    run.resting.look(run.root)
    assert run.support("o1").tolist() == [0.0] * 6
    assert run.support("o2")[5] > 0.0


def test_nothing_is_borne_before_it_has_settled(watched):
    run = watched()
    run.resting.look(run.root)
    run.resting.look(run.root)
    assert not run.support("o1").any()
