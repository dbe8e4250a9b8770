"""The twin of AgentModel for AutoDiffXd: the same values, and the derivatives of central differences."""

from __future__ import annotations

import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd, ExtractGradient, ExtractValue, InitializeAutoDiff

from drake_ltl.multibody.autodiff_agent import AutoDiffAgent, agent_for

Q = np.array([0.4, -0.3, 0.9, 0.5])
FUNCTIONS = {
    "gravity": lambda agent, q: agent.gravity(q),
    "grasp_jacobian": lambda agent, q: agent.grasp_jacobian(q),
    "grasp_pose": lambda agent, q: agent.grasp_pose(q).GetAsMatrix34(),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_values_and_derivatives_are_the_model_s(models, name):
    model, function, h = models.agents["a2"], FUNCTIONS[name], 1e-6
    result = function(AutoDiffAgent(model), InitializeAutoDiff(Q).ravel())
    here = function(model, Q)
    np.testing.assert_allclose(ExtractValue(result).reshape(here.shape), here, atol=1e-13)
    slopes = ExtractGradient(np.reshape(result, (-1, 1)))
    for k, e in enumerate(np.eye(len(Q))):
        differences = (function(model, Q + h * e) - function(model, Q - h * e)) / (2.0 * h)
        np.testing.assert_allclose(slopes[:, k], differences.ravel(), atol=1e-8)  # rounding over h


def test_floats_get_the_model_itself(models):
    assert agent_for(float, models.agents["a1"]) is models.agents["a1"]
    assert isinstance(agent_for(AutoDiffXd, models.agents["a1"]), AutoDiffAgent)
