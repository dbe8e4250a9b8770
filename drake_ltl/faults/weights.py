"""Loads that were weighed while they were carried: what carriers bear from then on, and whether they can."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, combinations

import numpy as np

from drake_ltl.dynamics import body_gravity, load_shares, transport_torque
from drake_ltl.errors import InfeasibleError
from drake_ltl.multibody.agent_model import AgentModel
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.multibody.postures import GraspConfiguration
from drake_ltl.planning.plan import Plan
from drake_ltl.scenario.model import Scenario

LEAST_LOAD = 1e-9
"""Of a joint [N, N m per kg]: less is rounding."""


def weighed(models: MeasuredModels, masses: Mapping[str, float]) -> MeasuredModels:
    """The models with loads as heavy as they were found to be: object -> [kg]. Their V is that of before."""
    if not masses:
        return models
    found = {name: models.objects[name].weighing(mass) for name, mass in masses.items()}
    return replace(models, objects={**models.objects, **found})


def bearable(team: Sequence[str], obj: str, scenario: Scenario, models: MeasuredModels) -> float:
    """The largest mass [kg] that a team's torques hold up at its grasps, each member its share; 0 if one has none."""
    power = {agent.name: agent.power for agent in scenario.agents}
    shares = load_shares([power[name] for name in team])
    return min(_held(models, name, obj) / float(share) for name, share in zip(team, shares, strict=True))


def too_heavy(masses: Mapping[str, float], scenario: Scenario, models: MeasuredModels) -> frozenset[str]:
    """Objects that no team can hold up, whoever is in it."""
    return frozenset(
        obj for obj, mass in masses.items() if not any(mass <= most for most in _borne(obj, scenario, models))
    )


def check_burdens(plan: Plan, masses: Mapping[str, float], scenario: Scenario, models: MeasuredModels) -> None:
    """Raises InfeasibleError if a plan has a team carry what its torques cannot hold up."""
    for action in chain.from_iterable(plan.moves):
        if action.kind == "transport" and action.object in masses:
            most, team = bearable(action.agents, action.object, scenario, models), " and ".join(action.agents)
            if masses[action.object] > most:
                raise InfeasibleError(f"{team} are to carry {action.object}, of which their torques bear {most:.3g} kg")


def _borne(obj: str, scenario: Scenario, models: MeasuredModels) -> Iterator[float]:
    """By each team of agents that have grasps of the object, the largest first [kg]."""
    names = [name for name in models.agents if models.grasps[name, obj]]
    for size in range(len(names), 0, -1):
        for team in combinations(names, size):
            yield bearable(team, obj, scenario, models)


def _held(models: MeasuredModels, agent: str, obj: str) -> float:
    """The largest mass [kg] whose weight the agent alone can hold, at the best of its grasps."""
    model, height = models.agents[agent], models.objects[obj].height
    return max((_held_at(model, grasp, height) for grasp in models.grasps[agent, obj]), default=0.0)


def _held_at(model: AgentModel, grasp: GraspConfiguration, height: float) -> float:
    """The m with which g_q + m w comes to the limit of a joint, w the torques for each kg."""
    gravity, limits = model.gravity(grasp.q), model.effort_limits
    p_OoEo_W = model.grasp_pose(grasp.q).translation() - [0.0, 0.0, height]
    w = transport_torque(1.0, body_gravity(1.0), p_OoEo_W, model.grasp_jacobian(grasp.q), 0.0 * gravity)
    room = np.where(w > 0.0, limits - gravity, limits + gravity)
    loaded = np.abs(w) > LEAST_LOAD
    return max(0.0, float((room[loaded] / np.abs(w[loaded])).min(initial=np.inf)))
