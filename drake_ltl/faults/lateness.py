"""How late measurements may come, and gains that bear later ones.

Damping that acts on the velocity of T ago, B qdd = -K qd(t - T), is stable while T < pi / (2 w), w the largest
eigenvalue of B^-1 K: as B and K are positive definite it falls apart into scalar equations x' = -w x(t - T). Who holds
or reaches, qdd = -2 w qd - w^2 (q - q*), bears T < arctan(2 x) / (x w) with x^4 = 4 x^2 + 1, where its loop has gain 1.
Commands that are held for a step of the plant come another half of a step late.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from drake_ltl.errors import InfeasibleError
from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS, AgentModel
from drake_ltl.scenario.model import ControllerSettings, Scenario
from drake_ltl.systems.hold_controller import TRACKING_FREQUENCY

MARGIN = 0.8
"""Of what is stable: nearer to the limit arms swing for long."""
ROOM = 1.6
"""Gains that are chosen anew bear so many times the delay."""
LEAST_SHARE = 0.1
"""Of the arms' damping that is left at least: with less they swing whatever is measured."""
POSTURES = 200
"""At which inertias are looked at, drawn from the joints' ranges."""
_CROSSING = math.sqrt(2.0 + math.sqrt(5.0))
HOLD_BEARS = math.atan(2.0 * _CROSSING) / (_CROSSING * TRACKING_FREQUENCY)
"""[s]"""


def bearable(models: Mapping[str, AgentModel], settings: ControllerSettings, time_step: float) -> float:
    """The largest delay of measurements [s] that the gains bear with some margin; may be negative. Of drives, whose
    steering is another law, nothing is known."""
    arms = [model for model in models.values() if model.has_arm]
    rates = [decay_rate(model, settings.base_damping, settings.arm_damping) for model in arms]
    return MARGIN * min([HOLD_BEARS, *(math.pi / 2.0 / rate for rate in rates)]) - time_step / 2.0


def decay_rate(model: AgentModel, base: float, arm: float) -> float:
    """The largest eigenvalue of B^-1 K [1/s] in any of many postures."""
    K, chance = model.damping(base, arm), np.random.default_rng(0)
    arms = chance.uniform(*model.arm_limits, (POSTURES, model.n - NUM_BASE_JOINTS))
    inertias = (model.inertia(np.concatenate([np.zeros(NUM_BASE_JOINTS), row])) for row in arms)
    return max(float(np.linalg.eigvals(np.linalg.solve(B, np.diag(K))).real.max()) for B in inertias)


def slowed(scenario: Scenario, models: Mapping[str, AgentModel], delay: float) -> Scenario:
    """The scenario with so little damping of the arms that a delay [s] is borne.

    Raises:
        InfeasibleError: no damping does.
    """
    settings, time_step = scenario.controller, scenario.simulation.time_step
    for share in np.geomspace(1.0, LEAST_SHARE, 13):
        less = replace(settings, arm_damping=float(share) * settings.arm_damping)
        most = bearable(models, less, time_step)
        if most >= ROOM * delay:
            return replace(scenario, controller=less)
    raise InfeasibleError(
        f"what is measured comes {1e3 * delay:.3g} ms late, and gains bear at most {1e3 * most / ROOM:.3g} ms"
    )
