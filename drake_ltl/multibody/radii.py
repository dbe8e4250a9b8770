"""r_i, r_j^O and r_{T,j}: measured from the models, and those that a scenario states compared with them.

A stated radius that is smaller than the body would make every clearance, and so the verdict, a false one.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping

import numpy as np

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS, AgentModel
from drake_ltl.multibody.collision_balls import farthest
from drake_ltl.multibody.object_model import ObjectModel
from drake_ltl.multibody.postures import GraspConfiguration
from drake_ltl.scenario.model import Agent, Scenario, TransportObject

TEAM_SLACK = 0.03
"""Added to a measured r_{T,j} for what the joints give way while carrying [m]."""
MAX_SAMPLES = 4000
"""Configurations at which an agent's radius is measured."""
WHEEL_SAMPLES = 120
"""Of a turn of a drive's wheels."""
DENSE = 10
"""With fewer samples for each joint, the farthest of them are starts of a search for what lies between."""
SEARCHES = 4
ROUNDING = 1e-6
"""A stated radius may be this much too small [m]: the numbers of models are rounded as well."""

Grasps = Mapping[tuple[str, str], tuple[GraspConfiguration, ...]]


def agent_radius(agent: Agent, model: AgentModel) -> float:
    """r_i [m]: the stated one, or the measured one."""
    return bounding_radius(model) if agent.radius is None else agent.radius


def object_radius(model: ObjectModel) -> float:
    """r_j^O [m]: the stated one, or the measured one rounded up to a millimetre."""
    return round_up(model.radius) if model.object.radius is None else model.object.radius


def team_radius(agents: Mapping[str, AgentModel], obj: ObjectModel, grasps: Grasps) -> float:
    """r_{T,j} [m]: the stated one, or the measured one with some slack, rounded up to a millimetre."""
    if obj.object.team_radius is not None:
        return obj.object.team_radius
    return round_up(_team_reach(agents, obj, grasps) + TEAM_SLACK)


def bounding_radius(model: AgentModel) -> float:
    """r_i [m], rounded up to a millimetre: covers all collision geometry from c_i in every sampled configuration.

    The arm's joints run over a grid of their ranges (over +-pi where a joint has no limits); where there are too many
    for a dense one, the largest distance is searched for from its farthest points.
    """
    return round_up(_agent_reach(model))


def round_up(length: float) -> float:
    """To the next millimetre."""
    return float(np.ceil(length * 1e3 - 1e-9) / 1e3)


def check_stated_radii(
    scenario: Scenario, agents: Mapping[str, AgentModel], objects: Mapping[str, ObjectModel], grasps: Grasps
) -> None:
    """Compares with what the bodies reach for certain: points of theirs, nothing added for slack (but to the advice).

    Agents are seen from `bounding_centre` in every sampled configuration, objects and teams from the object's
    origin, teams in every way in which an agent can grasp.

    Raises:
        InvalidInputError: a radius in the file is smaller, with every such radius.
    """
    mistakes = list(_agent_mistakes(scenario, agents))
    mistakes += _object_mistakes(scenario, objects)
    mistakes += _team_mistakes(scenario, agents, objects, grasps)
    if mistakes:
        raise InvalidInputError(mistakes)


def _agent_mistakes(scenario: Scenario, agents: Mapping[str, AgentModel]) -> Iterator[Mistake]:
    for agent in scenario.agents:
        if agent.radius is not None:
            reach = _agent_reach(agents[agent.name], inner=True)
            body = f"{agent.name} reaches from its frame bounding_centre within the limits of its joints"
            yield from _too_small(f"agents.{agent.name}.radius", agent.radius, reach, body)


def _object_mistakes(scenario: Scenario, objects: Mapping[str, ObjectModel]) -> Iterator[Mistake]:
    for obj in scenario.objects:
        if obj.radius is not None:
            reach = objects[obj.name].inner_radius
            yield from _too_small(
                f"objects.{obj.name}.radius", obj.radius, reach, f"{obj.name} reaches from its origin"
            )


def _team_mistakes(
    scenario: Scenario, agents: Mapping[str, AgentModel], objects: Mapping[str, ObjectModel], grasps: Grasps
) -> Iterator[Mistake]:
    """The key that holds for all objects is named once, with the object that needs most."""
    by_key: dict[str, list[TransportObject]] = {}
    for obj in scenario.objects:
        if obj.team_radius is not None:
            shared = obj.team_radius == scenario.team_radius
            by_key.setdefault("team_radius" if shared else f"objects.{obj.name}.team_radius", []).append(obj)
    for key, members in by_key.items():
        reaches = {obj.name: _team_reach(agents, objects[obj.name], grasps, inner=True) for obj in members}
        name = max(reaches, key=reaches.__getitem__)
        body = f"who grasps {name}, or {name} itself, reaches from the origin of {name}"
        yield from _too_small(key, members[0].team_radius, reaches[name], body, TEAM_SLACK)


def _too_small(where: str, stated: float | None, reach: float, body: str, slack: float = 0.0) -> Iterator[Mistake]:
    if stated is not None and stated < reach - ROUNDING:
        what = f"{stated!r} is less than the {reach:.4f} m that {body}"
        yield Mistake(where, what, f"write at least {round_up(reach + slack):g}, or leave it out")


def _agent_reach(model: AgentModel, *, inner: bool = False) -> float:
    """Largest distance from c_i of a point of the agent, in any sampled configuration."""
    volume = model.inner_volume if inner else model.volume

    def distance(arm: np.ndarray) -> float:
        q = np.concatenate([np.zeros(NUM_BASE_JOINTS), arm])
        return farthest(volume(q), model.centre(q))

    arms = [np.array(arm) for arm in _arm_samples(model)]
    distances = model.reaches(np.array(arms), inner=inner)
    if _samples_per_joint(model) >= DENSE or not model.has_arm:
        return float(distances.max())
    starts = [arms[i] for i in np.argsort(-distances, kind="stable")[:SEARCHES]]
    return max(float(distances.max()), *(_search(distance, start, model.arm_limits) for start in starts))


def _search(distance: Callable[[np.ndarray], float], start: np.ndarray, limits: tuple[np.ndarray, np.ndarray]) -> float:
    """The largest distance near `start`, without derivatives: which point is farthest changes on the way."""
    import scipy.optimize  # takes a while to load, and few models need it

    bounds = scipy.optimize.Bounds(*limits)
    return -float(scipy.optimize.minimize(lambda arm: -distance(arm), start, method="Powell", bounds=bounds).fun)


def _team_reach(agents: Mapping[str, AgentModel], obj: ObjectModel, grasps: Grasps, *, inner: bool = False) -> float:
    """Largest distance from Oo of a point of the object or of an agent that grasps it."""
    p_WOo = np.array([0.0, 0.0, obj.height])
    reaches = [
        farthest((model.inner_volume if inner else model.volume)(configuration.q), p_WOo)
        for name, model in agents.items()
        for configuration in grasps[name, obj.object.name]
    ]
    return max([obj.inner_radius if inner else obj.radius, *reaches])


def _arm_samples(model: AgentModel) -> Iterator[tuple[float, ...]]:
    """A grid of the joints' ranges; of a drive, whose wheels reach what they reach one by one, its diagonal."""
    number = _samples_per_joint(model)
    if not model.has_arm:
        return iter(np.linspace(*model.arm_limits, WHEEL_SAMPLES))
    return itertools.product(*(np.linspace(lo, hi, number) for lo, hi in zip(*model.arm_limits, strict=True)))


def _samples_per_joint(model: AgentModel) -> int:
    return max(2, int(MAX_SAMPLES ** (1 / max(1, model.n - NUM_BASE_JOINTS))))
