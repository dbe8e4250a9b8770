"""What a detected fault takes away."""

from __future__ import annotations

from dataclasses import replace

import pytest

from drake_ltl.faults.losses import DOOR, DRIVE, GRIP, LOAD, MOTION, OBJECT, Losses
from drake_ltl.monitoring.violation import Violation


def seen(monitor: str, *who: str) -> Violation:
    return Violation(monitor, 1.0, 0, who, "something is wrong")


@pytest.mark.parametrize("monitor", [DRIVE, MOTION])
def test_who_does_not_move_as_told_is_out_of_service(monitor):
    losses = Losses().after(seen(monitor, "a1"))
    assert losses == Losses(agents=frozenset({"a1"}))
    assert str(losses) == "a1 is out of service"


def test_who_loses_a_grasp_can_still_drive():
    assert Losses().after(seen(GRIP, "a1", "o1")) == Losses(grippers=frozenset({"a1"}))


def test_a_load_of_another_weight_is_as_heavy_as_it_is():
    losses = Losses().after(replace(seen(LOAD, "o1"), value=0.65)).after(replace(seen(LOAD, "o2"), value=2.0))
    assert losses == Losses(masses={"o1": 0.65, "o2": 2.0})
    assert str(losses) == "o1 weighs 0.65 kg; o2 weighs 2 kg"


def test_a_load_that_cannot_be_lifted_is_not_carried_any_more():
    assert Losses().after(seen(LOAD, "o1")) == Losses(objects=frozenset({"o1"}))


def test_a_push_takes_nothing_away():
    assert str(Losses().after(seen(OBJECT, "o1"))) == "nothing is lost"


def test_a_door_that_closes_blocks_its_region():
    assert Losses().after(seen(DOOR, "yard")) == Losses(regions=frozenset({"yard"}))


def test_losses_add_up():
    losses = Losses()
    for what in (seen(GRIP, "a1", "o1"), seen(DOOR, "yard"), seen(DRIVE, "a1"), seen(LOAD, "o2")):
        losses = losses.after(what)
    says = "a1 is out of service; o2 cannot be carried any more; nobody may enter yard any more"
    assert str(losses) == says
