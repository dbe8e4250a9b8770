"""Least distances inside teams: the search against looking at every sample, and what is found of a run."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from drake_ltl.verification import models, verify
from drake_ltl.verification.inside_teams import RESOLUTION, SHARE, nearest

GRASP, CARRY, RELEASE, MIXED = 1, 2, 3, 5  # numbers of steps of the drawn run
PER_STEP = 50


@given(
    steps=hnp.arrays(float, st.integers(0, 60), elements=st.floats(0.0, 0.1)),
    signs=st.randoms(use_true_random=False),
    begin=st.floats(-0.2, 1.0),
)
def test_the_least_of_all_samples(steps, signs, begin):
    """A distance that changes by no more than the bodies move, in either direction."""
    moved = np.concatenate([[0.0], np.cumsum(steps)])
    values = begin + np.concatenate([[0.0], np.cumsum([signs.uniform(-1.0, 1.0) * step for step in steps])])
    seen = set()

    def distance(sample: int) -> float:
        seen.add(sample)
        return float(values[sample])

    sample, least = nearest(distance, moved)
    assert least == values[sample]
    assert values.min() <= least <= values.min() + max(RESOLUTION, SHARE * abs(least)) + 1e-12
    assert (least <= 0.0) == (values.min() <= 0.0)


def test_few_samples_are_looked_at():
    """Of a body that comes near once, and of one that stands."""
    time = np.linspace(-1.0, 1.0, 20001)
    for values in (0.05 + np.abs(time), np.full(len(time), 0.05)):
        moved, count = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(values)))]), 0

        def distance(sample: int, values=values) -> float:
            nonlocal count
            count += 1
            return float(values[sample])

        assert nearest(distance, moved)[1] == pytest.approx(0.05, abs=0.005)
        assert count < 100


@pytest.fixture
def with_distance(monkeypatch):
    """with_distance(f): bodies that f(agent, other, sample) says to be so far apart."""
    work_out = models.work_out

    def replace(distance) -> None:
        monkeypatch.setattr(models, "work_out", lambda *args: dataclasses.replace(work_out(*args), distance=distance))

    return replace


def test_who_is_asked_about(recording, with_distance):
    """All around one object, in the steps in which they grasp, hold or release it, and nobody else."""
    asked = set()

    def distance(agent: str, other: str, sample: int) -> float:
        asked.add((agent, other, min(sample // PER_STEP, 8)))
        return 0.05

    with_distance(distance)
    verdict = verify(recording)
    assert verdict.satisfied
    assert verdict.min_inside_teams == 0.05
    assert {(a, b) for a, b, _ in asked} == {("a1", "o1"), ("a2", "o1"), ("a1", "a2")}
    assert {step for _, _, step in asked} >= {GRASP, CARRY, 3, 4, 7, 8}
    assert not any(step == 0 for *_, step in asked)


@pytest.mark.parametrize(("pair", "step"), [(("a2", "o1"), GRASP), (("a1", "a2"), RELEASE), (("a1", "o1"), MIXED)])
def test_a_hit_is_found(recording, with_distance, pair, step):
    """At its worst, although it lasts for one sample, of which each is 15 mm and more from the next."""
    deepest = step * PER_STEP + 26

    def distance(agent: str, other: str, sample: int) -> float:
        return min(0.05, -0.004 + 0.01 * abs(sample - deepest)) if (agent, other) == pair else 0.05

    with_distance(distance)
    verdict = verify(recording)
    (violation,) = verdict.violations
    assert (violation.kind, violation.who, violation.step) == ("clearance", pair, step)
    assert str(violation).endswith(f"{pair[0]} hits {pair[1]}: 4 mm")
    assert violation.time == pytest.approx(recording.time[deepest])
    assert verdict.min_inside_teams == pytest.approx(-0.004)
