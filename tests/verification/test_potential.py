"""V worked out from the motion is the V that steered, for every shaping and with relation verification functions."""

import dataclasses

import numpy as np
import pytest

from drake_ltl.mission import measure, plan_and_place, simulate
from drake_ltl.navigation import PseudoHuber
from drake_ltl.scenario import loads
from drake_ltl.verification.lyapunov import AGREEMENT, lyapunov_rises
from drake_ltl.verification.models import work_out

SCENARIO = """
name: crossing
workspace: {radius: 14}
regions:
  pi1: {centre: [-6, 0, 0], radius: 3.0}
  pi2: {centre: [6, 0, 0], radius: 3.0}
  pi3: {centre: [0, 9, 0], radius: 3.0}
agents:
  a1: {model: "package://drake_ltl_models/agents/planar_arm.urdf", position: [-6, 0], radius: 1.25}
  a2: {model: "package://drake_ltl_models/agents/planar_arm.urdf", position: [6, 0], radius: 1.25}
objects: {}
spec: "F(a1.pi2 & a2.pi1)"
simulation: {step_time_limit: 3}
"""


class Squared:
    """psi = w, the user's own."""

    supremum = float("inf")

    def __repr__(self):
        return "Squared()"  # part of a test's name, which must not change

    def value(self, L):
        return np.exp(np.minimum(L, 700.0))

    def log_slope(self, L):
        return np.zeros_like(L)


@pytest.mark.parametrize(
    ("settings", "force"),
    [
        ({}, 40.0),
        ({"shaping": "logarithmic"}, 200.0),
        ({"shaping": "paper", "kappa": 1.5}, 4e5),
        ({"shaping": Squared()}, 1.0),
        ({"shaping": PseudoHuber(2.0)}, 40.0),
        ({"lambda_": 1.0}, 40.0),
        ({"lambda_": 2.0, "h": 3.0, "shaping": "logarithmic"}, 200.0),
    ],
    ids=str,
)
def test_both_hands_form_the_same_V_and_it_falls(settings, force):
    scenario = loads(SCENARIO)
    scenario = dataclasses.replace(
        scenario, controller=dataclasses.replace(scenario.controller, force=force, **settings)
    )
    models = measure(scenario)

    recording = simulate(plan_and_place(scenario, models), scenario, models).recording
    V = work_out(recording, scenario).lyapunov

    moving = recording.lyapunov > 0.0
    assert moving.sum() > 500
    np.testing.assert_allclose(V, recording.lyapunov, rtol=AGREEMENT)
    assert V[moving][-1] < 0.9999 * V[moving][0]
    assert lyapunov_rises(recording, V, ()).max() < 1e-9
