"""How late measurements may come: what theory says against delayed motion in small steps, and what runs make of it."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from drake_ltl import mission
from drake_ltl.errors import InfeasibleError
from drake_ltl.faults.lateness import HOLD_BEARS, MARGIN, ROOM, bearable, decay_rate, slowed
from drake_ltl.systems.hold_controller import TRACKING_FREQUENCY
from drake_ltl.verification import verify

NOTICED_WITHIN = 0.02
"""What docs/faults.md promises of measurements that come late [s]."""


def growth(A: np.ndarray, A_late: np.ndarray, delay: float) -> float:
    """By how much x' = A x(t) + A_late x(t - delay) swings more at last than before, by Euler's method."""
    n, late = len(A), 400
    history = [np.random.default_rng(1).standard_normal(n)] * (late + 1)
    sizes = []
    for _ in range(12 * late):
        history.append(history[-1] + delay / late * (A @ history[-1] + A_late @ history[-1 - late]))
        sizes.append(np.linalg.norm(history[-1]))
    third = len(sizes) // 3
    return max(sizes[-third:]) / max(sizes[third:-third])


@pytest.fixture(scope="module")
def planar(relay):
    return relay[1].agents["a1"]


def test_damping_bears_what_is_promised_and_not_much_more(planar):
    """In the posture that bears least."""
    K, worst = planar.damping(18.0, 1.8), decay_rate(planar, 18.0, 1.8)
    arms = np.random.default_rng(0).uniform(*planar.arm_limits, (200, planar.n - 2))
    systems = [np.linalg.solve(planar.inertia(np.concatenate([np.zeros(2), arm])), np.diag(K)) for arm in arms]
    (system,) = (A for A in systems if np.linalg.eigvals(A).real.max() == pytest.approx(worst, rel=1e-9))
    most, nothing = math.pi / 2.0 / worst, np.zeros_like(system)
    assert growth(nothing, -system, 0.95 * most) < 1.0 < growth(nothing, -system, 1.05 * most)


def test_holds_bear_what_is_promised_and_not_much_more():
    w = TRACKING_FREQUENCY
    A, A_late = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0, 0.0], [-w * w, -2.0 * w]])
    assert growth(A, A_late, 0.95 * HOLD_BEARS) < 1.0 < growth(A, A_late, 1.05 * HOLD_BEARS)


def test_less_damping_bears_later_measurements(relay):
    scenario, models, _ = relay
    less = slowed(scenario, models.agents, 0.02)
    assert less.controller.arm_damping < scenario.controller.arm_damping
    assert less == replace(scenario, controller=replace(scenario.controller, arm_damping=less.controller.arm_damping))
    assert bearable(models.agents, less.controller, scenario.simulation.time_step) >= ROOM * 0.02
    assert slowed(scenario, models.agents, 0.005) == scenario
    with pytest.raises(InfeasibleError, match=r"comes 100 ms late, and gains bear at most \d"):
        slowed(scenario, models.agents, 0.1)


def test_half_a_step_of_the_plant_counts_as_delay():
    model = SimpleNamespace(
        n=3,
        has_arm=True,
        arm_limits=(np.zeros(1), np.ones(1)),
        damping=lambda *_: np.full(3, 8.0),
        inertia=lambda q: 0.1 * np.eye(3),
    )
    settings = SimpleNamespace(base_damping=8.0, arm_damping=8.0)
    expected = MARGIN * math.pi / 2.0 / 80.0
    for time_step in (0.0, 0.01):
        assert bearable({"a1": model}, settings, time_step) == pytest.approx(expected - time_step / 2.0)


def test_what_nobody_can_bear_ends_the_run_before_anything_swings(relay, with_fault):
    _, models, planned = relay
    scenario = with_fault("{kind: sensors, delay: 0.05}")
    run = mission.simulate(planned, scenario, models, announce=lambda line: None)
    assert run.noticed[0].seen.time <= NOTICED_WITHIN
    assert "comes 50 ms late, and gains bear at most" in run.recording.reason
    assert [violation.kind for violation in verify(run.recording, scenario).violations] == ["run"]


def test_what_can_be_borne_with_less_damping_is(relay, with_fault):
    """Nothing swings: the motion monitor keeps still. That V falls is not promised of what is seen so late."""
    _, models, planned = relay
    scenario = with_fault("{kind: sensors, delay: 0.02}")
    run = mission.simulate(planned, scenario, models, announce=lambda line: None)
    assert [noticed.seen.monitor for noticed in run.noticed] == ["clock"]
    assert run.recording.completed
    assert {violation.kind for violation in verify(run.recording, scenario).violations} <= {"lyapunov"}
