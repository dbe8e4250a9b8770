"""When a task is done: how far everything is from where it should be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drake_ltl.dynamics import heading_difference
from drake_ltl.multibody.agent_model import NUM_BASE_JOINTS
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.multibody.postures import pose_error
from drake_ltl.scenario.model import Tolerances
from drake_ltl.systems.program import GraspTask, ReleaseTask, TransportTask, TravelTask
from drake_ltl.systems.progress import Measurement
from drake_ltl.systems.signals import reach_ends

WELD_SPEED = 0.005
"""Joints slower than this count as at rest for a weld [m/s, rad/s]."""
RETREATED = 0.002
"""A retreat ends this close to its goal [m, rad]."""


@dataclass(frozen=True)
class Arrival:
    """Judges tasks by the scenario's tolerances."""

    models: MeasuredModels
    tolerances: Tolerances

    def left(self, task: TravelTask | TransportTask, now: Measurement) -> str:
        """What a mover still has to do, for people; empty when it is at its goal, at rest."""
        if isinstance(task, TravelTask):
            return self._travel_left(task, now)
        return self._transport_left(task, now)

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

    def rests(self, agent: str, now: Measurement) -> bool:
        """Whether the agent has come to rest; a weld that closes its gap sets light wrists moving."""
        return _fastest(now.qd[agent]) <= self.tolerances.speed

    def misalignment(self, task: GraspTask, now: Measurement) -> tuple[float, float]:
        """Angle [rad] and gap [m] between the gripper and the grasp frame."""
        weld = task.weld
        (configuration,) = (g for g in self.models.grasps[weld.agent, weld.object] if g.name == weld.option)
        X_WE = self.models.agents[weld.agent].grasp_pose(now.q[weld.agent])
        error = pose_error(X_WE, now.X_WO[weld.object] @ configuration.X_OE)
        return float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))

    def speed(self, task: TravelTask | TransportTask, now: Measurement) -> float:
        """Of the fastest joint of a traveller, or component of a carried object's velocity [m/s, rad/s]."""
        return _fastest(now.qd[task.agent] if isinstance(task, TravelTask) else now.V_WO[task.object])

    def _travel_left(self, task: TravelTask, now: Measurement) -> str:
        error, tolerances = now.q[task.agent] - task.q_goal, self.tolerances
        distance = float(np.linalg.norm(error[:NUM_BASE_JOINTS]))
        joint = float(np.abs(error[NUM_BASE_JOINTS:]).max())
        speed = self.speed(task, now)
        if distance <= tolerances.position and joint <= tolerances.joint and speed <= tolerances.speed:
            return ""
        return f"{task.agent} is {distance:.2f} m from its place in {task.goal} (speed {speed:.2f} m/s)"

    def _transport_left(self, task: TransportTask, now: Measurement) -> str:
        distance = float(np.linalg.norm(now.X_WO[task.object].translation() - task.p_goal))
        turn = abs(heading_difference(now.X_WO[task.object].rotation().ToQuaternion().wxyz(), task.orientation_goal))
        speed = max([float(np.linalg.norm(now.V_WO[task.object][3:])), *(_fastest(now.qd[a]) for a in task.team)])
        there = distance <= self.tolerances.position and turn <= self.tolerances.angle
        if there and speed <= self.tolerances.speed:
            return ""
        team = f"{task.object} (carried by {', '.join(task.team)})"
        turned = f" and {np.rad2deg(turn):.1f} degrees" if turn > self.tolerances.angle else ""
        return f"{team} is {distance:.2f} m{turned} from its place in {task.goal} (speed {speed:.2f} m/s)"


def _fastest(qd: np.ndarray) -> float:
    """Of all joints [m/s, rad/s]."""
    return float(np.abs(qd).max())
