"""Which way objects face, judged against what the scenario says."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from drake_ltl.execution.recording import Recording, StepRecord
from drake_ltl.scenario.model import TransportObject
from drake_ltl.verification import verify
from drake_ltl.verification.headings import headings, limit, orientation
from drake_ltl.verification.objects import largest_tilt

CARRY, BACK = 2, 7  # numbers of the steps in which o1 is carried, to pi1 and back to pi2
PER_STEP = 50


def saying(recording: Recording, **changes) -> Recording:
    """A recording of a scenario with other entries of o1."""
    data = yaml.safe_load(recording.scenario)
    data["objects"]["o1"] |= changes
    return dataclasses.replace(recording, scenario=yaml.safe_dump(data, sort_keys=False))


def facing(recording: Recording, heading: np.ndarray) -> Recording:
    """o1 turned by heading (T,) [rad]."""
    pose, velocity = recording.pose["o1"].copy(), recording.velocity["o1"].copy()
    pose[:, 0], pose[:, 3] = np.cos(heading / 2), np.sin(heading / 2)
    velocity[:, 2] = np.diff(heading, prepend=heading[0]) / np.diff(recording.time, prepend=-1.0)
    return dataclasses.replace(
        recording, pose=recording.pose | {"o1": pose}, velocity=recording.velocity | {"o1": velocity}
    )


def turning(recording: Recording, there: float, back: float, start: float = 0.0) -> Recording:
    """o1 turned smoothly while it is carried."""
    tau = np.linspace(0.0, 1.0, PER_STEP)
    course = 10 * tau**3 - 15 * tau**4 + 6 * tau**5
    heading = np.full(len(recording.time), start)
    for step, before, after in ((CARRY, start, there), (BACK, there, back)):
        heading[step * PER_STEP : (step + 1) * PER_STEP] = before + course * (after - before)
        heading[(step + 1) * PER_STEP :] = after
    return facing(recording, heading)


def kinds(verdict) -> set[str]:
    """But for what a crate that turns alone, without its team, also breaks."""
    return {violation.kind for violation in verdict.violations} - {"weld"}


def test_headings_follow_the_transports(scenario):
    obj = dataclasses.replace(scenario.objects[0], orientation=(0.0, 0.0, 0.5), headings={"pi1": 1.0})
    told = dataclasses.replace(scenario, objects=(obj, scenario.objects[1]))

    def step(number: int, kind: str, to: str) -> StepRecord:
        action = {"kind": kind, "agents": ["a1"], "object": "o1", "from": "pi2", "to": to}
        return StepRecord(number, (action,), 0.0, 1.0, True)

    steps = [step(0, "transport", "pi3"), step(1, "transport", "pi1"), step(2, "release", "pi1")]
    steps += [step(3, "transport", "pi2")]
    assert headings(told, steps) == [{"o1": h, "o2": 0.0} for h in (0.5, 0.5, 1.0, 1.0, 1.0)]


def test_orientations_are_those_of_the_scenario():
    """R_WO = Rz(yaw) Ry(pitch) Rx(roll)."""
    obj = TransportObject("o1", "", (0.0, 0.0), 1.0, orientation=(0.3, -0.4, 9.9))
    x, y, z = (Rotation.from_rotvec(turn * axis) for turn, axis in zip((0.3, -0.4, 0.8), np.eye(3), strict=True))
    np.testing.assert_allclose(orientation(obj, 0.8).as_matrix(), (z * y * x).as_matrix(), atol=1e-12)


@pytest.mark.parametrize(("there", "back"), [(1.2, 0.0), (-3.0, 2.0), (np.pi, 0.0)])
def test_a_crate_that_is_turned_as_told(recording, there, back):
    told = saying(recording, headings={"pi1": there, "pi2": back})
    verdict = verify(turning(told, there, back))
    assert kinds(verdict) == set()
    assert verdict.max_heading_error == pytest.approx(0.0, abs=1e-9)
    assert kinds(verify(turning(told, there + 2 * np.pi, back))) == set()  # whole turns are none


def test_a_crate_that_keeps_its_heading(recording):
    verdict = verify(facing(saying(recording, heading=0.7), np.full(len(recording.time), 0.7)))
    assert verdict.satisfied
    assert verdict.max_tilt == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("changes", "there", "back", "error", "step"),
    [
        ({"headings": {"pi1": 1.2}}, 0.0, 0.0, 1.2, CARRY),  # not turned though it should be
        ({}, 0.2, 0.2, 0.2, CARRY),  # turned though it should not be
        ({"headings": {"pi1": 0.5}}, 0.5, 0.0, 0.5, BACK),  # turned back though it should keep its heading
        ({"headings": {"pi1": 3.1}}, -3.1, -3.1, 2 * np.pi - 6.2, CARRY),  # the short way round
    ],
)
def test_a_crate_that_is_not_turned_as_told(recording, changes, there, back, error, step):
    verdict = verify(turning(saying(recording, **changes), there, back))
    assert kinds(verdict) == {"heading"}
    (violation,) = (v for v in verdict.violations if v.kind == "heading")
    assert (violation.who, violation.step) == (("o1",), step)
    assert violation.worst == verdict.max_heading_error == pytest.approx(error, abs=1e-9)


def test_tolerances_of_headings(recording, scenario):
    most = limit(scenario)
    assert most == pytest.approx(0.03 + np.deg2rad(1.0))
    assert kinds(verify(turning(recording, 0.99 * most, 0.0))) == set()
    assert kinds(verify(turning(recording, 1.01 * most, 0.0))) == {"heading"}


def test_a_crate_is_not_left_on_its_edge(recording):
    """Tilted by 5 degrees while it is carried, its heading right; 2.7 degrees are within tolerances."""
    for tilt, found in ((2.0, set()), (5.0, {"heading"})):
        turn = np.deg2rad(tilt) * np.clip((recording.time - CARRY) / 0.9, 0.0, 1.0)
        pose = recording.pose["o1"].copy()
        pose[:, :2] = np.column_stack([np.cos(turn / 2), np.sin(turn / 2)])
        velocity = recording.velocity["o1"].copy()
        velocity[:, 0] = np.diff(turn, prepend=0.0) / np.diff(recording.time, prepend=-1.0)
        tilted = dataclasses.replace(
            recording, pose=recording.pose | {"o1": pose}, velocity=recording.velocity | {"o1": velocity}
        )
        assert kinds(verify(tilted)) == found


def test_a_crate_begins_as_it_is_told_to(recording):
    verdict = verify(saying(recording, heading=0.01))
    assert {v.kind for v in verdict.violations} == {"start"}
    assert verify(saying(recording, heading=2 * np.pi)).satisfied


def test_tilt_is_measured_from_how_an_object_lies(recording):
    """On its side, turned about the vertical and tilted by 0.1 rad."""
    lying = Rotation.from_euler("xyz", [0.0, np.pi / 2, 0.3])
    turned = Rotation.from_euler("z", 1.0) * Rotation.from_euler("x", 0.1) * lying
    pose = recording.pose["o1"].copy()
    pose[:, :4] = np.roll(lying.as_quat(), 1)
    pose[-1, :4] = np.roll(turned.as_quat(), 1)
    assert largest_tilt(dataclasses.replace(recording, pose={"o1": pose})) == pytest.approx(0.1, abs=1e-9)
