"""What everybody does when a fault has been noticed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RigidTransform, RotationMatrix

from drake_ltl.multibody.postures import polished
from drake_ltl.systems.hold_controller import TRACKING_FREQUENCY
from drake_ltl.systems.program import GraspTask, ReleaseTask, all_welds
from drake_ltl.systems.progress import AgentSignals, Measurement, Progress
from drake_ltl.systems.safe_mode import SafeMode
from drake_ltl.systems.signals import NO_GRASP, Mode, Phase, pack_reach, reach_ends


@pytest.fixture(scope="module")
def safe_mode(models) -> SafeMode:
    return SafeMode(models, all_welds(models))


@pytest.fixture(scope="module")
def weld(safe_mode):
    """(index, weld) of a1 and o1."""
    return next((i, w) for i, w in enumerate(safe_mode.welds) if (w.agent, w.object) == ("a1", "o1"))


@pytest.fixture(scope="module")
def now(models, weld) -> Measurement:
    """a1 grasps o1 at the origin, a2 moves, a3 stands."""
    q = {"a1": models.grasp("a1", "o1", weld[1].option).q, "a2": np.array([10.0, 0, 0.5, 1.0])}
    q["a3"] = q["a2"] + [10.0, 0.0, 0.0, 0.0]
    qd = {"a1": np.zeros(4), "a2": np.array([1.0, -0.5, 0.2, 0.0]), "a3": np.zeros(4)}
    X_WO = {name: RigidTransform([0.0, y, models.objects[name].height]) for name, y in (("o1", 0.0), ("o2", 8.0))}
    return Measurement(3.0, q, qd, X_WO, dict.fromkeys(X_WO, np.zeros(6)))


def progress(now: Measurement, *modes: Mode, grasp: int = NO_GRASP) -> Progress:
    agents = [AgentSignals(m, q, pack_reach(0.0, 1.0, q, q)) for m, q in zip(modes, now.q.values(), strict=True)]
    agents[0] = replace(agents[0], grasp=grasp)
    return Progress(2, Phase.NAVIGATE, 0.0, 5, now.anchor, tuple(agents))


def test_movers_brake_without_overshoot(safe_mode, now):
    halted = safe_mode.halt(progress(now, Mode.HOLD, Mode.TRANSITION, Mode.HOLD), now, {})
    assert halted.phase is Phase.SAFE
    assert {told.mode for told in halted.agents} == {Mode.HOLD}
    np.testing.assert_allclose(halted.agents[1].hold, now.q["a2"] + now.qd["a2"] / TRACKING_FREQUENCY)
    np.testing.assert_array_equal(halted.agents[2].hold, now.q["a3"])


def test_who_approaches_comes_away_and_who_backs_off_goes_on(safe_mode, now, weld, models):
    state = progress(now, Mode.REACH, Mode.REACH, Mode.HOLD)
    index, own = weld
    other = next(w for w in safe_mode.welds if w.agent == "a2")
    grasp = GraspTask(own, index, now.q["a1"], np.array([1.0, 0.0, 0.0, 0.0]))
    halted = safe_mode.halt(state, now, {"a1": grasp, "a2": ReleaseTask(other, np.zeros(2))})
    assert halted.agents[1] == state.agents[1]
    start, goal = reach_ends(halted.agents[0].reach)
    np.testing.assert_array_equal(start, now.q["a1"])
    (option,) = (g for g in models.geometry.grasps["a1", "o1"] if g.name == own.option)
    away = np.subtract(option.p_OoC_standoff, option.p_OoC_grasp)[:2]
    np.testing.assert_allclose(goal[:2] - start[:2], away, atol=1e-9)


def test_who_lets_go_comes_clear_of_an_object_that_has_slid_towards_it(safe_mode, now, weld, models):
    towards = models.agents["a1"].centre(now.q["a1"]) * [1.0, 1.0, 0.0]
    slid = RigidTransform(now.X_WO["o1"].translation() + 0.5 * towards / np.linalg.norm(towards))
    later = replace(now, X_WO={**now.X_WO, "o1": slid})
    state = safe_mode.let_go(progress(later, Mode.HOLD, Mode.HOLD, Mode.HOLD, grasp=weld[0]), later, ["a1", "a3"])
    assert state.revision == 6
    assert [told.grasp for told in state.agents] == [NO_GRASP] * 3
    centre = models.agents["a1"].centre(reach_ends(state.agents[0].reach)[1])
    apart = np.linalg.norm(centre - slid.translation())
    assert apart > models.geometry.agent_radius["a1"] + models.geometry.object_radius["o1"]


def test_what_is_held_in_the_air_is_set_down(safe_mode, now, weld, models):
    """Gripper and object come down together, straight, to where the object stands."""
    (index, own), height = weld, models.objects["o1"].height
    lifted = RigidTransform(now.X_WO["o1"].rotation(), [0.3, -0.2, height + 0.05])
    X_OE = models.grasp("a1", "o1", own.option).X_OE
    q = polished(models.agents["a1"], lifted @ X_OE, now.q["a1"] + [0.3, -0.2, 0.0, 0.0])
    later = replace(now, q={**now.q, "a1": q}, X_WO={**now.X_WO, "o1": lifted})
    held = progress(later, Mode.HOLD, Mode.HOLD, Mode.HOLD, grasp=index)
    state = safe_mode.set_down(held, later, ["a1", "a3"])
    assert [told.mode for told in state.agents] == [Mode.REACH, Mode.HOLD, Mode.HOLD]
    assert state.agents[0].grasp == index
    gripper = models.agents["a1"].grasp_pose(reach_ends(state.agents[0].reach)[1])
    stands = RigidTransform([0.3, -0.2, height])
    assert gripper.IsNearlyEqualTo(stands @ X_OE, 1e-6)
    standing = safe_mode.set_down(held, now, ["a1"])
    assert [told.mode for told in standing.agents] == [Mode.HOLD] * 3


def test_what_is_held_askew_is_levelled_as_it_is_lowered(safe_mode, now, weld, models):
    """Gripper and object turn as one, about the horizontal axis about which the arm can turn it."""
    (index, own), height = weld, models.objects["o1"].height
    X_OE = models.grasp("a1", "o1", own.option).X_OE
    outwards = X_OE.translation() * [1.0, 1.0, 0.0]
    axis = np.cross([0.0, 0.0, 1.0], outwards / np.linalg.norm(outwards))
    askew = RigidTransform(RotationMatrix(AngleAxis(np.deg2rad(3.0), axis)), [0.0, 0.0, height])
    q = polished(models.agents["a1"], askew @ X_OE, now.q["a1"])
    later = replace(now, q={**now.q, "a1": q}, X_WO={**now.X_WO, "o1": askew})
    held = progress(later, Mode.HOLD, Mode.HOLD, Mode.HOLD, grasp=index)
    sagged = held.with_agent(0, hold=q + 0.01)  # as much as it pulls down those who hold it
    for state, sag in ((held, 0.0), (sagged, 0.01)):
        goal = reach_ends(safe_mode.set_down(state, later, ["a1"]).agents[0].reach)[1] - sag
        level = RigidTransform([0.0, 0.0, height]) @ X_OE
        assert models.agents["a1"].grasp_pose(goal).IsNearlyEqualTo(level, 1e-6)


def test_the_weight_is_shared_by_those_who_can(safe_mode, now, weld):
    other = next(i for i, w in enumerate(safe_mode.welds) if (w.agent, w.object) == ("a2", "o1"))
    state = progress(now, Mode.HOLD, Mode.HOLD, Mode.HOLD, grasp=weld[0]).with_agent(1, grasp=other)

    def shares(state) -> list[float]:
        return [told.bears for told in state.agents]

    both = safe_mode.halt(state, now, {})
    assert shares(both) == [0.5, 0.5, 0.0]
    alone = safe_mode.halt(state, now, {}, frozenset({"a2"}))
    assert shares(alone) == [1.0, 0.0, 0.0]
    assert shares(safe_mode.set_down(both, now, ["a1", "a2"], frozenset({"a1"}))) == [0.0, 1.0, 0.0]
    left = safe_mode.let_go(both.with_agent(0, hold=now.q["a1"] + 0.1), now, ["a2"])
    assert shares(left) == [1.0, 0.0, 0.0]
    np.testing.assert_array_equal(left.agents[0].hold, now.q["a1"])  # not where it had been dragged from
    assert shares(safe_mode.let_go(alone, now, ["a1"])) == [0.0, 0.0, 0.0]


def test_it_is_quiet_once_all_hold_and_rest_but_those_out_of_service(safe_mode, now):
    held = progress(now, Mode.HOLD, Mode.HOLD, Mode.HOLD)
    assert not safe_mode.is_quiet(held, now, frozenset())
    assert safe_mode.is_quiet(held, now, frozenset({"a2"}))
    assert not safe_mode.is_quiet(progress(now, Mode.REACH, Mode.HOLD, Mode.HOLD), now, frozenset({"a2"}))
    rolling = replace(now, V_WO={**now.V_WO, "o2": np.full(6, 0.1)})
    assert not safe_mode.is_quiet(held, rolling, frozenset({"a2"}))


def test_who_has_come_away_holds(safe_mode, now):
    state = progress(now, Mode.REACH, Mode.REACH, Mode.HOLD)  # a2 still moves
    after = safe_mode.advance(state, now)
    assert [told.mode for told in after.agents] == [Mode.HOLD, Mode.REACH, Mode.HOLD]
