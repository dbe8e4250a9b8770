"""What a step that a fault has halted excuses, and what not: step 2, in which a1 and a2 carry o1 from 2 s to 3 s."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from drake_ltl.errors import InvalidInputError
from drake_ltl.execution.recording import NOTHING, Recording
from drake_ltl.scenario import loads
from drake_ltl.verification import models, verify
from drake_ltl.verification.befallen import befallen
from drake_ltl.verification.pushes import explained

BREAKS = "{kind: weld_breaks, agent: a2, time: 2.2}"
WEAK = "{kind: torque_limits, agent: a2, time: 2.2, factor: 0.1}"
OTHER = "{kind: push, object: o2, time: 0.5, impulse: [1, 0]}"


@pytest.fixture
def recording(draw: Callable[[int], Recording]) -> Recording:
    """It ends early, before a2 grasps again, which nobody does whom a fault has befallen."""
    return dataclasses.replace(draw(4), completed=False, reason="early")


def halted(recording: Recording, fault: str, faulty: tuple[str, ...] = ("a2",)) -> Recording:
    """In its third step, by the word of its record."""
    steps = [dataclasses.replace(one, halted="noticed", faulty=faulty) if one.number == 2 else one
             for one in recording.steps]  # fmt: skip
    return dataclasses.replace(recording, scenario=f"{recording.scenario}\nfaults: [{fault}]\n", steps=tuple(steps))


def opened(recording: Recording, first: float, end: float) -> Recording:
    """a2 holds nothing for some time."""
    grasp = recording.grasp.copy()
    grasp[(recording.time >= first) & (recording.time < end), 1] = NOTHING
    return dataclasses.replace(recording, grasp=grasp)


def gaping(monkeypatch: pytest.MonkeyPatch, since: float) -> None:
    """a2's gripper is 5 cm off from then on, while it counts as holding."""
    right = models.work_out

    def off(recording: Recording, scenario):
        mechanics = right(recording, scenario)
        late = (recording.time >= since) & (recording.time < 3.0)
        mechanics.gripper["a2"][late, 2, 3] += 0.05
        return mechanics

    monkeypatch.setattr(models, "work_out", off)


def said(recording: Recording) -> list[str]:
    return [violation.what for violation in verify(recording).violations]


def test_a_step_that_is_halted_and_comes_to_its_end_all_the_same_is_none_the_worse(recording):
    assert said(halted(recording, WEAK)) == said(recording)


@pytest.mark.parametrize("fault", ["{kind: push, object: o1, time: 3.1, impulse: [1, 0]}",
                                   "{kind: weld_breaks, agent: a2, step: 5}"])  # fmt: skip
def test_nothing_is_halted_before_the_first_fault(recording, fault):
    with pytest.raises(InvalidInputError, match=r"steps\.2: was halted by a fault at 3 s, and no fault had happened"):
        verify(halted(recording, fault))


def halted_thrice(recording: Recording, fault: str, faulty: tuple[str, ...]) -> Recording:
    """In its third, fifth and sixth step."""
    steps = [dataclasses.replace(one, halted="noticed", faulty=faulty) if one.number in (2, 4, 5) else one
             for one in recording.steps]  # fmt: skip
    return dataclasses.replace(recording, scenario=f"{recording.scenario}\nfaults: [{fault}]\n", steps=tuple(steps))


NOISE = "{kind: sensors, position_noise: 0.0001}"


@pytest.mark.parametrize(
    ("fault", "faulty", "what"),
    [
        (NOISE, (), r"steps\.5: is halt 3 by faults of no agent, which can be noticed 2 times"),
        (
            NOISE,
            ("o2",),
            r"steps\.5: is halt 3 by faults of no agent, which can be noticed 2 times",
        ),
        (NOISE, ("a3",), r"steps\.4: was halted by a fault of a3, which an earlier one had befallen"),
        (NOISE, ("a1",), r"steps\.5: a1 cannot grasp or carry after an earlier fault"),
        (NOISE, ("o2",), r"steps\.5: was halted by a fault, and is one of those that repeat for ever"),
        (OTHER, (), r"steps\.2: was halted by a fault at 3 s, and no fault had happened"),
    ],
    ids=["unnamed", "object", "agent", "serves", "repeats", "no cause"],
)
def test_faults_halt_as_often_as_they_can_be_noticed(draw, fault, faulty, what):
    with pytest.raises(InvalidInputError, match=what):
        verify(halted_thrice(draw(9), fault, faulty))


@pytest.mark.parametrize(
    ("fault", "faulty", "excused"),
    [(WEAK, ("a2",), True), (WEAK.replace("2.2", "2.8"), ("a2",), False), (NOISE, ("a2",), False),
     ("{kind: blocked_region, region: pi3, time: 2.2}", (), False)],
    ids=["moved", "not yet", "noise", "door"],
)  # fmt: skip
def test_v_may_rise_before_a_halt_if_a_fault_has_moved_something(recording, fault, faulty, excused):
    """It rises at 2.5 s."""
    recording.lyapunov[125:150] += 3.0
    found = said(halted(recording, fault, faulty))
    assert ("V rises, relative to its start" not in found) == excused


@pytest.mark.parametrize("fault", [BREAKS, OTHER])
def test_what_somebody_has_let_go_of_is_not_carried_on(recording, fault):
    """Whatever the record says of who is to blame: nobody lets go before all rest."""
    found = said(halted(opened(recording, 2.5, 3.0), fault))
    assert "o1 moves by more than 50 mm though nobody carries it" in found


@pytest.mark.parametrize(
    ("down", "all_let_go", "broken", "excused"),
    [(0.08, 3.0, "a2", True), (0.08, 2.6, "a2", False), (-0.08, 3.0, "a2", False), (0.08, 3.0, "a1", False)],
    ids=["set down", "fallen", "lifted", "held by a broken grasp"],
)
def test_what_somebody_has_let_go_of_others_may_set_down(recording, down, all_let_go, broken, excused):
    """a2 lets go at the end of its way, at 2.5 s; a1 holds o1 for some time, which changes its height by 3 s."""
    pose, late = recording.pose["o1"].copy(), recording.time >= 2.5
    pose[late, 4:6] = pose[np.argmax(late), 4:6]
    pose[:, 6] += down * (1.0 - np.clip((recording.time - 2.6) / 0.4, 0.0, 1.0)) * (recording.step == 2)
    grasp = opened(recording, 2.5, 9.0).grasp
    grasp[recording.time >= all_let_go, 0] = NOTHING
    moved = dataclasses.replace(recording, pose={**recording.pose, "o1": pose}, grasp=grasp)
    found = said(halted(moved, BREAKS.replace("a2", broken), faulty=(broken,)))
    assert ("o1 moves by more than 50 mm though nobody carries it" not in found) == excused


def test_who_has_let_go_does_not_grasp_again(recording):
    assert "a2 changes its grasp 2 times in one step" in said(halted(opened(recording, 2.5, 2.6), BREAKS))


@pytest.mark.parametrize(
    ("fault", "since", "excused"),
    [(BREAKS, 2.3, True), (BREAKS, 2.1, False), (OTHER, 2.3, False), (BREAKS.replace("a2", "a1"), 2.3, False)],
    ids=["broken", "not yet", "not at all", "another's"],
)
def test_a_grasp_may_gape_once_the_scenario_breaks_it(recording, monkeypatch, fault, since, excused):
    gaping(monkeypatch, since)
    assert any("the weld of a2 is off" in what for what in said(halted(recording, fault))) != excused


def test_a_grasp_that_nobody_notices_to_be_broken_is_a_violation(recording, monkeypatch):
    gaping(monkeypatch, 2.3)
    assert any("the weld of a2 is off" in what for what in said(halted(recording, BREAKS, faulty=("a1",))))


CARRIED_ON = "o1 moves by more than 50 cm after a grasp of it has broken"


def test_nothing_is_carried_on_after_a_grasp_has_broken(recording):
    """Whether the run says that it noticed or not, and whoever else holds it."""
    unnoticed = dataclasses.replace(recording, scenario=f"{recording.scenario}\nfaults: [{BREAKS}]\n")
    assert CARRIED_ON in said(unnoticed)
    assert CARRIED_ON in said(halted(recording, BREAKS))
    assert CARRIED_ON not in said(halted(recording, BREAKS.replace("2.2", "2.9")))  # it all but stands


def test_nor_after_another_grasp_gapes_that_a_fault_excuses(recording, monkeypatch):
    """The grasp that breaks is let go of at once; the next one, from 2 s on, gapes from 2.1 s."""
    again = halted(opened(recording, 1.97, 1.99), BREAKS.replace("2.2", "1.9"))
    assert CARRIED_ON not in said(again)
    gaping(monkeypatch, 2.1)
    assert CARRIED_ON in said(again)


@pytest.mark.parametrize(("fault", "excused"), [(OTHER, True), (OTHER.replace("o2", "o1"), False)])
def test_an_object_moves_by_itself_if_the_scenario_pushes_it(recording, fault, excused):
    """o2 slides by 5 cm while its record says that a fault befell it."""
    moved = slid(recording, 0.05 * np.clip(recording.time - 2.0, 0.0, 1.0))
    found = said(halted(moved, fault, faulty=("o2",)))
    assert any("o2 moves by more than" in what for what in found) != excused


@pytest.mark.parametrize(
    ("fault", "moves"),
    [("{kind: agent_stops, agent: a2, time: 0.5}", True), ("{kind: agent_stops, agent: a2, step: 2}", True),
     ("{kind: agent_stops, agent: a3, time: 0.5}", False), ("{kind: agent_stops, agent: a2, time: 3.98}", False),
     ("{kind: agent_stops, agent: a2, time: 0.5, how: limp}", False)],
    ids=["on its way", "at a step", "stands", "at the end", "limp"],
)  # fmt: skip
def test_who_is_stopped_stands_whether_that_is_noticed_or_not(recording, fault, moves):
    stopped = dataclasses.replace(recording, scenario=f"{recording.scenario}\nfaults: [{fault}]\n")
    assert any("after a fault has stopped it" in what for what in said(stopped)) == moves


def slid(recording: Recording, way: np.ndarray) -> Recording:
    """o2 has moved north by so much (T,) [m]."""
    pose, velocity = recording.pose["o2"].copy(), recording.velocity["o2"].copy()
    pose[:, 5] += way
    velocity[1:, 4] += np.diff(way) / np.diff(recording.time)
    return dataclasses.replace(
        recording, pose={**recording.pose, "o2": pose}, velocity={**recording.velocity, "o2": velocity}
    )


@pytest.mark.parametrize(
    ("impulse", "time", "swings", "excused"),
    [(0.5, 2.1, 0, True), (0.1, 2.1, 0, False), (0.5, 2.5, 0, False), (0.5, 2.1, 1, False)],
    ids=["pushed", "too gently", "too late", "comes back"],
)
def test_what_is_pushed_is_as_fast_as_its_push_makes_it_and_no_faster_later(recording, impulse, time, swings, excused):
    """The 0.5 kg of o2 go at 0.9 m/s from 2.1 s on, and ever slower; or, having come to rest, back."""
    late = np.clip(recording.time - 2.1, 0.0, 0.4)
    way = 0.9 * late - 0.9 / 0.8 * late**2
    again = np.clip(recording.time - 2.5, 0.0, 0.4)
    way -= swings * (0.9 * again - 0.9 / 0.8 * again**2)
    push = f"{{kind: push, object: o2, time: {time}, impulse: [0, {impulse}]}}"
    found = said(halted(slid(recording, way), push, faulty=("o2",)))
    assert any(what.startswith("o2 ") for what in found) != excused


def test_what_falls_may_become_faster():
    time, height, speed = np.arange(3) * 0.1, 9.81 * np.array([0.3, 0.3, 0.1]), np.array([0.0, 1.0, 2.5])
    most = explained([(0.0, 1.0)], time, speed, 0.5 * speed**2 + height, height)
    np.testing.assert_allclose(most, [1.0, 1.0, np.sqrt(1.0 + 2.0 * 9.81 * 0.2)])


def test_faults_happen_at_the_earliest_of_their_times(recording, scenario_text):
    text = f"{scenario_text}\nfaults: [{BREAKS}, {BREAKS.replace('time: 2.2', 'step: 2')}, {OTHER}]\n"
    assert befallen(recording, loads(text), "weld_breaks") == {"a2": 1.0}
    assert befallen(recording, loads(text), "push") == {"o2": 0.5}
