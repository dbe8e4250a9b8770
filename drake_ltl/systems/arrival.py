"""When a task is done: how far everything is from where it should be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import dist, hypot

import numpy as np

from drake_ltl.dynamics import heading_difference
from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.multibody.postures import pose_error
from drake_ltl.scenario.model import Region, Scenario, Tolerances
from drake_ltl.systems.program import GraspTask, ReleaseTask, TransportTask, TravelTask
from drake_ltl.systems.progress import Measurement
from drake_ltl.systems.signals import reach_ends

WELD_SPEED = 0.005
"""Joints slower than this count as at rest for a weld [m/s, rad/s]."""
ROOM = 0.005
"""Who has arrived is so far inside its region [m], or half as far as its goal if that is less."""
RETREATED = 0.002
"""A retreat ends this close to its goal [m, rad]."""
OF_WELD_ANGLE = 0.5
"""So much of what a weld may be off is left to who grasps next and cannot turn: loads settle once they are let go."""


@dataclass(frozen=True)
class Arrival:
    """Judges tasks by the scenario's tolerances, and by the regions in which they end."""

    models: MeasuredModels
    tolerances: Tolerances
    regions: Mapping[str, Region]
    """By their names."""

    @classmethod
    def of(cls, models: MeasuredModels, scenario: Scenario) -> Arrival:
        return cls(models, scenario.tolerances, {region.name: region for region in scenario.regions})

    def is_done(self, task: TravelTask | TransportTask, now: Measurement) -> bool:
        """Whether a mover is at its goal, at rest. Whoever still moves is not asked for more, for that is quick."""
        if isinstance(task, TravelTask):
            return _fastest(now.qd[task.agent]) <= self.tolerances.speed and self._has_travelled(task, now)
        return self._team_speed(task, now) <= self.tolerances.speed and self._is_delivered(task, now)

    def left(self, task: TravelTask | TransportTask, now: Measurement) -> str:
        """What a mover still has to do, for people; empty when it is at its goal, at rest."""
        if self.is_done(task, now):
            return ""
        return self._travel_text(task, now) if isinstance(task, TravelTask) else self._transport_text(task, now)

    def can_weld(self, task: GraspTask, now: Measurement) -> bool:
        """Whether the gripper is where the grasp frame is, at rest."""
        angle, gap = self.misalignment(task, now)
        close = angle <= self.tolerances.weld_angle and gap <= self.tolerances.weld_position
        return close and _fastest(now.qd[task.weld.agent]) <= WELD_SPEED

    def has_retreated(self, task: ReleaseTask, reach: np.ndarray, now: Measurement) -> bool:
        """Whether the agent is at the end of its reach, at rest."""
        agent, goal = task.weld.agent, reach_ends(reach)[1]
        there = np.abs(now.q[agent] - goal).max() <= RETREATED
        return bool(there) and self.rests(agent, now)

    def rests(self, agent: str, now: Measurement, slack: float = 1.0) -> bool:
        """Whether the agent has come to rest; a weld that closes its gap sets light wrists moving."""
        return _fastest(now.qd[agent]) <= slack * self.tolerances.speed

    def lies_still(self, obj: str, now: Measurement, slack: float = 1.0) -> bool:
        """Whether the object has come to rest."""
        return _fastest(now.V_WO[obj]) <= slack * self.tolerances.speed

    def misalignment(self, task: GraspTask, now: Measurement) -> tuple[float, float]:
        """Angle [rad] and gap [m] between the gripper and the grasp frame."""
        weld = task.weld
        (configuration,) = (g for g in self.models.grasps[weld.agent, weld.object] if g.name == weld.option)
        X_WE = self.models.agents[weld.agent].grasp_pose(now.q[weld.agent])
        error = pose_error(X_WE, now.X_WO[weld.object] @ configuration.X_OE)
        return float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))

    def speed(self, task: TravelTask | TransportTask, now: Measurement) -> float:
        """Of the fastest joint of a traveller that says how it gets on, or component of a carried object's velocity
        [m/s, rad/s]."""
        if isinstance(task, TravelTask):
            return _fastest(self.models.agents[task.agent].rates_of_travel(now.qd[task.agent]))
        return _fastest(now.V_WO[task.object])

    def _has_travelled(self, task: TravelTask, now: Measurement) -> bool:
        q, tolerances = now.q[task.agent], self.tolerances
        there = _distance(q, task.q_goal) <= tolerances.position
        there = there and self.models.agents[task.agent].joint_error(q, task.q_goal) <= tolerances.joint
        return there and self._agent_is_inside(task, now)

    def _is_delivered(self, task: TransportTask, now: Measurement) -> bool:
        distance, turn = _offset(task, now)
        there = distance <= self.tolerances.position and turn <= self._angle(task)
        return there and self._object_is_inside(task, now)

    def _angle(self, task: TransportTask) -> float:
        """How far a load may be turned from its goal [rad]: little if some robot that can grasp it cannot turn, and its
        team can."""
        agents, angle = self.models.agents, self.tolerances.angle
        graspers = (agent for agent, obj in self.models.grasps if obj == task.object)
        stiff = any(not agents[name].yaw_direction for name in graspers)
        if stiff and all(agents[name].yaw_direction for name in task.team):
            return min(angle, OF_WELD_ANGLE * self.tolerances.weld_angle)
        return angle

    def _team_speed(self, task: TransportTask, now: Measurement) -> float:
        """Of a carried object [m/s], or of the fastest joint of who carries it if that is more."""
        return max([hypot(*now.V_WO[task.object][3:].tolist()), *(_fastest(now.qd[a]) for a in task.team)])

    def _travel_text(self, task: TravelTask, now: Measurement) -> str:
        distance, speed = _distance(now.q[task.agent], task.q_goal), self.speed(task, now)
        return f"{task.agent} is {distance:.2f} m from its place in {task.goal} (speed {speed:.2f} m/s)"

    def _transport_text(self, task: TransportTask, now: Measurement) -> str:
        (distance, turn), speed = _offset(task, now), self._team_speed(task, now)
        team = f"{task.object} (carried by {', '.join(task.team)})"
        turned = f" and {np.rad2deg(turn):.2g} degrees" if turn > self._angle(task) else ""
        return f"{team} is {distance:.2f} m{turned} from its place in {task.goal} (speed {speed:.2f} m/s)"

    def _agent_is_inside(self, task: TravelTask, now: Measurement) -> bool:
        model, radius = self.models.agents[task.agent], self.models.geometry.agent_radius[task.agent]
        return _is_inside(self.regions[task.goal], radius, model.centre(now.q[task.agent]), model.centre(task.q_goal))

    def _object_is_inside(self, task: TransportTask, now: Measurement) -> bool:
        radius = self.models.geometry.object_radius[task.object]
        return _is_inside(self.regions[task.goal], radius, now.X_WO[task.object].translation(), task.p_goal)


def _is_inside(region: Region, radius: float, centre: np.ndarray, goal: np.ndarray) -> bool:
    """Whether a sphere is in its region, if it is so at its goal: near the border tolerances could leave it outside."""
    here, there = (region.radius - radius - float(np.linalg.norm(p - np.array(region.centre))) for p in (centre, goal))
    return there <= 0.0 or here >= min(ROOM, 0.5 * there)


def _distance(q: np.ndarray, q_goal: np.ndarray) -> float:
    """Of a base from its goal [m]."""
    return dist(q[:NUM_BASE_JOINTS].tolist(), q_goal[:NUM_BASE_JOINTS].tolist())


def _offset(task: TransportTask, now: Measurement) -> tuple[float, float]:
    """Of a carried object from its goal: distance [m] and turn about the vertical [rad]."""
    X_WO = now.X_WO[task.object]
    turn = heading_difference(X_WO.rotation().ToQuaternion().wxyz(), task.orientation_goal)
    return dist(X_WO.translation().tolist(), task.p_goal.tolist()), abs(turn)


def _fastest(qd: np.ndarray) -> float:
    """Of all joints [m/s, rad/s]."""
    return max(map(abs, qd.tolist()))
