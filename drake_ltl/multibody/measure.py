"""Measures, with Drake, the numbers that planning needs of the models (planning.geometry.Geometry)."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS, AgentModel
from drake_ltl.multibody.drive_agent import make_agent_model
from drake_ltl.multibody.object_model import ObjectModel
from drake_ltl.multibody.pair_distance import PairDistance
from drake_ltl.multibody.postures import GraspConfiguration, grasp_configurations
from drake_ltl.multibody.radii import agent_radius, check_stated_radii, object_radius, team_radius
from drake_ltl.planning.geometry import Geometry, GraspOption, Vector3, turned_posture
from drake_ltl.scenario.model import Scenario, TransportObject

STANDOFF_GAP = 0.07
"""Between the spheres of an agent at its stand-off and of the object [m]: more than the least margin of packing."""
LEAST_APPROACH = 0.25
"""The straight way from stand-off to grasp is at least this long [m], so that the gripper clears the handle."""
APPROACH_SAMPLES = 6
"""Places on that way at which the agent's geometry is held against the object's."""


@dataclass(frozen=True)
class MeasuredModels:
    """The models of a scenario with everything measured from them."""

    agents: Mapping[str, AgentModel]
    objects: Mapping[str, ObjectModel]
    postures: Mapping[str, Mapping[str, np.ndarray]]
    """agent -> posture -> arm joints (n_i - 2,)."""
    grasps: Mapping[tuple[str, str], tuple[GraspConfiguration, ...]]
    """(agent, object) -> ways to grasp it when it stands at the origin, as it is turned at the start."""
    geometry: Geometry

    def grasp(self, agent: str, obj: str, option: str) -> GraspConfiguration:
        """One of them by name."""
        (configuration,) = (g for g in self.grasps[agent, obj] if g.name == option)
        return configuration

    def grasping(self, agent: str, obj: str, option: str, heading: float) -> np.ndarray:
        """q_i (n,) that grasps the object where it stands at the origin with a heading [rad]."""
        turn = heading - self.objects[obj].object.heading
        return self.agents[agent].turned(self.grasp(agent, obj, option).q, turn)


def MeasureGeometry(scenario: Scenario) -> MeasuredModels:
    """Loads the scenario's models and measures radii, postures and grasps.

    Radii that the scenario gives are taken as they are, unless they are smaller than the bodies.

    Raises:
        InvalidInputError: a model cannot be used, an arm starts beyond its joints' limits, a radius is too small, or
            nobody can turn an object that is to be turned.
    """
    agents = {agent.name: make_agent_model(agent, scenario) for agent in scenario.agents}
    _check_start_joints(agents)
    objects = {obj.name: ObjectModel(obj) for obj in scenario.objects}
    grasps = {(a, o): _grasps(agents[a], objects[o]) for a, o in itertools.product(agents, objects)}
    _check_somebody_turns(scenario, grasps)
    check_stated_radii(scenario, agents, objects, grasps)
    postures = {name: _postures(model, name, grasps, objects) for name, model in agents.items()}
    radius_of_agent = {agent.name: agent_radius(agent, agents[agent.name]) for agent in scenario.agents}
    radius_of_object = {name: object_radius(model) for name, model in objects.items()}
    geometry = Geometry(
        agent_radius=radius_of_agent,
        object_radius=radius_of_object,
        object_height={name: model.height for name, model in objects.items()},
        team_radius={name: team_radius(agents, model, grasps) for name, model in objects.items()},
        postures={
            name: {key: centre_offset(agents[name], arm) for key, arm in table.items()}
            for name, table in postures.items()
        },
        grasps={
            (a, o): tuple(
                _grasp_option(
                    agents[a],
                    objects[o],
                    configuration,
                    posture_name(postures[a], configuration),
                    radius_of_agent[a] + radius_of_object[o],
                )
                for configuration in grasps[a, o]
            )
            for a, o in grasps
        },
    )
    return MeasuredModels(agents, objects, postures, grasps, geometry)


def _check_start_joints(agents: Mapping[str, AgentModel]) -> None:
    mistakes = []
    for name, model in agents.items():
        lower = model.plant.GetPositionLowerLimits()[NUM_BASE_JOINTS:]
        upper = model.plant.GetPositionUpperLimits()[NUM_BASE_JOINTS:]
        joints = zip(model.joint_names[NUM_BASE_JOINTS:], model.agent.joints or (), lower, upper, strict=False)
        mistakes += [
            Mistake(
                f"agents.{name}.joints",
                f"{angle!r} is beyond the limits of joint {joint}",
                f"write an angle from {low:.6g} to {high:.6g}",
            )
            for joint, angle, low, high in joints
            if not low <= angle <= high
        ]
    if mistakes:
        raise InvalidInputError(mistakes)


def centre_offset(model: AgentModel, arm: np.ndarray) -> Vector3:
    """p_BC_W [m]: the sphere's centre as seen from the base's origin on the floor."""
    return _vector3(model.centre(np.concatenate([np.zeros(NUM_BASE_JOINTS), arm])))


def posture_name(postures: Mapping[str, np.ndarray], configuration: GraspConfiguration) -> str:
    """The name under which the arm's posture of a grasp is listed."""
    arm = configuration.q[NUM_BASE_JOINTS:]
    return next(name for name, other in postures.items() if np.allclose(arm, other, rtol=0.0, atol=1e-6))


def _grasps(model: AgentModel, obj: ObjectModel) -> tuple[GraspConfiguration, ...]:
    """Ways to grasp the object that come nowhere too close to it, and can be kept while it is turned."""
    if not model.has_arm:
        return ()
    X_WO, distance = obj.pose(np.array([0.0, 0.0, obj.height]), obj.object.heading), PairDistance(model.agent, obj)
    pose = np.concatenate([X_WO.rotation().ToQuaternion().wxyz(), X_WO.translation()])

    def clearance(way: GraspConfiguration) -> float:
        """On the straight way to the grasp."""
        back = -(X_WO.rotation() @ way.X_OE.rotation()).matrix()[:, 2]
        q = np.repeat(way.q[None], APPROACH_SAMPLES, axis=0)
        q[:, :NUM_BASE_JOINTS] += np.linspace(0.0, LEAST_APPROACH, APPROACH_SAMPLES)[:, None] * back[:NUM_BASE_JOINTS]
        return min(distance(row, pose) for row in q)

    if obj.object.is_turned and not model.yaw_direction:
        return ()
    found = grasp_configurations(model, obj.X_OG, obj.height, X_WO.rotation(), clearance)
    lower, upper = model.plant.GetPositionLowerLimits(), model.plant.GetPositionUpperLimits()

    turns = _turns(obj.object)
    has_way = max(turns) - min(turns) < np.pi or not model.yaw_is_limited  # turns go the short way round

    def is_kept(way: GraspConfiguration) -> bool:
        q = np.array([model.turned(way.q, angle) for angle in turns])
        return has_way and bool(np.all((lower <= q) & (q <= upper)))

    return tuple(filter(is_kept, found))


def _turns(obj: TransportObject) -> list[float]:
    """By how much transports may have turned the object [rad]: not at all first."""
    return list(dict.fromkeys([0.0, *(heading - obj.heading for heading in obj.headings.values())]))


def _check_somebody_turns(scenario: Scenario, grasps: Mapping[tuple[str, str], tuple[GraspConfiguration, ...]]) -> None:
    mistakes = [
        Mistake(
            f"objects.{obj.name}.headings",
            f"no agent can turn {obj.name}: it takes a third joint that turns the whole robot about the vertical",
            f"write its heading at the start, {obj.heading:.6g}, leave the key out, or add an agent with a yaw joint",
        )
        for obj in scenario.objects
        if obj.is_turned and not any(grasps[agent, obj.name] for agent in scenario.agent_names)
    ]
    if mistakes:
        raise InvalidInputError(mistakes)


def _postures(
    model: AgentModel,
    agent: str,
    grasps: Mapping[tuple[str, str], tuple[GraspConfiguration, ...]],
    objects: Mapping[str, ObjectModel],
) -> dict[str, np.ndarray]:
    """Start posture if the scenario gives one, then each grasp's (alike ones once), then all joints at zero, or as near
    to it as their limits allow; at last those of grasps of objects that were turned."""
    table: dict[str, np.ndarray] = {}

    def add(name: str, arm: np.ndarray) -> None:
        if not any(np.allclose(arm, other, rtol=0.0, atol=1e-6) for other in table.values()):
            table[name] = arm

    if (start := model.start_arm) is not None:
        add("start", start)
    for (a, o), configurations in grasps.items():
        for configuration in configurations:
            if a == agent:
                name = configuration.name if configuration.name not in table else f"{configuration.name}_{o}"
                add(name, configuration.q[NUM_BASE_JOINTS:])
    add("zero", np.clip(0.0, *model.arm_limits))
    for (a, o), configurations in grasps.items():
        for configuration in configurations if a == agent else ():
            for angle in _turns(objects[o].object)[1:]:
                name = turned_posture(posture_name(table, configuration), angle)
                table[name] = model.turned(configuration.q, angle)[NUM_BASE_JOINTS:]
    return table


def _grasp_option(
    model: AgentModel, obj: ObjectModel, configuration: GraspConfiguration, posture: str, clear: float
) -> GraspOption:
    """Backs off from the grasp, straight against the gripper's direction, until the spheres are apart."""
    p_OoC = model.centre(configuration.q) - [0.0, 0.0, obj.height]
    back = -model.grasp_pose(configuration.q).rotation().matrix()[:, 2]
    along, beside = float(p_OoC @ back), p_OoC - (p_OoC @ back) * back
    needed = np.sqrt(max(0.0, (clear + STANDOFF_GAP) ** 2 - float(beside @ beside))) - along
    standoff = p_OoC + max(needed, LEAST_APPROACH) * back
    return GraspOption(configuration.name, _vector3(standoff), _vector3(p_OoC), posture)


def _vector3(array: np.ndarray) -> Vector3:
    x, y, z = (float(value) for value in array)
    return (x, y, z)
