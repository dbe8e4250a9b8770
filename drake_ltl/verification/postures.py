"""h(q), the energy of a redundant arm that is not in the posture in which it began to carry: part of V.

Formed from the joints' limits and the model's numbers, without the controllers' code.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from drake_ltl.multibody.agent_model import AgentModel

EDGE = 0.999
"""Share of a joint's range beyond which its barrier goes on as a parabola."""
BARRIER = 0.5
"""Share of a joint's stiffness that its barrier takes, if it has limits."""
SHORTFALL, SINGULARITY_WEIGHT = 0.5, 2.0
"""Share of manipulability below which it counts, and how much for each squared e-fold [J]."""


def posture_energy(model: AgentModel, q: np.ndarray, begin: int, rows: np.ndarray) -> np.ndarray:
    """h (n,) [J] at the samples `rows` (n,) of q (T, n_i), with the posture of the sample `begin` for its reference."""
    lower, upper = model.plant.GetPositionLowerLimits(), model.plant.GetPositionUpperLimits()
    h = np.zeros(len(rows))
    for joint, stiffness in enumerate(model.posture_stiffness):
        here, there = q[rows, joint], q[begin, joint]
        if 0.0 < upper[joint] - lower[joint] < np.inf:
            middle, half = (lower[joint] + upper[joint]) / 2, (upper[joint] - lower[joint]) / 2
            barrier = half**2 * _divergence((here - middle) / half, (there - middle) / half)
            h += stiffness * (BARRIER * barrier + (1 - BARRIER) * (here - there) ** 2 / 2)
        else:
            h += stiffness * (here - there) ** 2 / 2
    w = np.array([model.manipulability(row) for row in q[rows]])
    with np.errstate(divide="ignore", invalid="ignore"):  # w = 0 at singularities, where h has no value
        short = np.maximum(0.0, np.log(SHORTFALL * model.manipulability(q[begin]) / w))
    return h + SINGULARITY_WEIGHT / 2 * short**2


def _divergence(x: np.ndarray, x0: float) -> np.ndarray:
    """Bregman divergence of -log(1 - x^2) from x0, scaled to (x - x0)^2 / 2 near x0."""
    x0 = np.clip(x0, -EDGE, EDGE)
    edge = np.clip(x, -EDGE, EDGE)
    beyond = x - edge
    value = -np.log1p(-(edge**2)) + _slope(edge) * beyond + _curvature(edge) * beyond**2 / 2
    return (value + np.log1p(-(x0**2)) - _slope(x0) * (x - x0)) / _curvature(x0)


def _slope(x: np.ndarray) -> np.ndarray:
    return 1 / (1 - x) - 1 / (1 + x)


def _curvature(x: np.ndarray) -> np.ndarray:
    return 1 / (1 - x) ** 2 + 1 / (1 + x) ** 2


def springs(agents: dict[str, AgentModel], q: dict[str, np.ndarray]) -> dict[str, partial]:
    """For each redundant agent, its h as a function of (begin, rows)."""
    return {name: partial(posture_energy, model, q[name]) for name, model in agents.items() if model.is_redundant}
