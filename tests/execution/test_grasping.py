"""Welds follow the commanded grasps, and only where grippers fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from drake_ltl.diagrams import MakeMissionDiagram
from pydrake.math import RigidTransform, RollPitchYaw

from drake_ltl.errors import GraspError
from drake_ltl.execution.grasping import ApplyGrasps
from drake_ltl.systems.signals import NO_GRASP

WELD = 0  # a1 grasps o1
PLACE = np.array([2.0, -3.0])


@pytest.fixture(scope="module")
def diagram(mission, case_ii, models):
    return MakeMissionDiagram(mission, case_ii, models, num_steps=1)


@pytest.fixture
def stage(diagram, models):
    """stage(p, rpy): a1 stands where it grasps o1, which is then moved a little; and what is commanded."""

    def make(p=(0.0, 0.0, 0.0), rpy=(0.0, 0.0, 0.0)):
        root = diagram.CreateStartContext()
        parts, plant = diagram.transport_plant, diagram.transport_plant.plant
        weld = parts.welds[WELD]
        assert (weld.agent, weld.object) == ("a1", "o1")
        context = plant.GetMyMutableContextFromRoot(root)
        q = models.grasps["a1", "o1"][0].q + np.array([*PLACE, 0.0, 0.0])
        plant.SetPositions(context, parts.agents["a1"], q)
        X_WO = RigidTransform(RollPitchYaw(rpy), np.array([*PLACE, models.objects["o1"].height]) + p)
        plant.SetFreeBodyPose(context, plant.GetBodyByName("crate", parts.objects["o1"]), X_WO)
        return root

    return make


def command(diagram, monkeypatch, *welds: int) -> None:
    monkeypatch.setattr(diagram.supervisor, "commanded_grasps", lambda context: list(welds), raising=True)


def active(diagram, root) -> list[int]:
    plant = diagram.transport_plant.plant
    context = plant.GetMyContextFromRoot(root)
    ids = diagram.transport_plant.weld_ids
    return [index for index, weld_id in enumerate(ids) if plant.GetConstraintActiveStatus(context, weld_id)]


def test_exactly_the_commanded_welds_are_active(diagram, stage, monkeypatch):
    root = stage()
    command(diagram, monkeypatch, WELD, NO_GRASP, NO_GRASP)
    ApplyGrasps(diagram, root)
    assert active(diagram, root) == [WELD]
    command(diagram, monkeypatch, NO_GRASP, NO_GRASP, NO_GRASP)
    ApplyGrasps(diagram, root)
    assert active(diagram, root) == []


@pytest.mark.parametrize(
    ("p", "rpy"),
    [((0.0009, 0, 0), (0, 0, 0)), ((0, 0, -0.0009), (0, 0, 0)), ((0, 0, 0), (0, 0, 0.001))],
)
def test_a_small_gap_is_closed(diagram, stage, monkeypatch, p, rpy):
    root = stage(p, rpy)
    command(diagram, monkeypatch, WELD, NO_GRASP, NO_GRASP)
    ApplyGrasps(diagram, root)
    assert active(diagram, root) == [WELD]


@pytest.mark.parametrize(
    ("p", "rpy", "text"),
    [
        ((0.0011, 0, 0), (0, 0, 0), r"1\.10 mm"),
        ((0, 0, 0.005), (0, 0, 0), r"5\.00 mm"),
        ((0, 0, 0), (0, 0.002, 0), r"0\.115 degrees"),
        ((0.3, 0.4, 0), (0, 0, 0), r"500\.00 mm"),
    ],
)
def test_a_gap_is_refused_before_anything_is_switched(diagram, stage, monkeypatch, p, rpy, text):
    root = stage(p, rpy)
    command(diagram, monkeypatch, WELD, NO_GRASP, NO_GRASP)
    with pytest.raises(GraspError, match=rf"a1 cannot be welded to o1.*{text}"):
        ApplyGrasps(diagram, root)
    assert active(diagram, root) == []


def test_welds_that_hold_are_not_measured_again(diagram, stage, monkeypatch):
    """Under load a weld gives way a little: that is the verification's matter."""
    root = stage()
    command(diagram, monkeypatch, WELD, NO_GRASP, NO_GRASP)
    ApplyGrasps(diagram, root)
    plant, parts = diagram.transport_plant.plant, diagram.transport_plant
    context = plant.GetMyMutableContextFromRoot(root)
    q = plant.GetPositions(context, parts.agents["a1"])
    plant.SetPositions(context, parts.agents["a1"], q + np.array([0.002, 0.0, 0.0, 0.0]))
    ApplyGrasps(diagram, root)
    assert active(diagram, root) == [WELD]


def test_applied_grasps_are_acknowledged(diagram, stage):
    root = stage()
    supervisor = diagram.supervisor
    context = supervisor.GetMyMutableContextFromRoot(root)
    progress = supervisor.GetProgress(context)
    for agent in range(len(progress.agents)):
        progress = progress.with_agent(agent, grasp=NO_GRASP)
    supervisor.SetProgress(context, replace(progress, revision=5))
    assert supervisor.grasps_pending(context)
    ApplyGrasps(diagram, root)
    assert not supervisor.grasps_pending(context)
