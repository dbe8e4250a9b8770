"""A placed mission in joint coordinates: the tasks of each step, as the controllers need them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from drake_ltl.dynamics import load_shares
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.planning.mission import Layout, Mission, PlacedStep, Stand
from drake_ltl.planning.plan import Action
from drake_ltl.scenario.model import Scenario

SAME_PLACE = 0.06
"""An agent that stands this close to its stand-off [m] approaches from where it is (twice the goal tolerance)."""
PRESSED = 6e-4
"""A load's goal lies this deep in the floor [m]: one that is a little lighter than its team knows would else end in the
air, and drop when it is let go."""


@dataclass(frozen=True)
class Weld:
    """One (agent, object, grasp option): the weld that stands for this grasp."""

    agent: str
    object: str
    option: str


@dataclass(frozen=True)
class TravelTask:
    """Agent z in Z drives to q*_z under the navigation function."""

    agent: str
    start: str
    goal: str
    q_goal: np.ndarray


@dataclass(frozen=True)
class TransportTask:
    """Team T_m brings the object to p*_O, and to its heading there, under the navigation function."""

    object: str
    team: tuple[str, ...]
    shares: np.ndarray
    """c_tau (N,), zero for agents outside the team."""
    start: str
    goal: str
    p_goal: np.ndarray
    orientation_goal: np.ndarray
    """Of R*_WO, as a quaternion (4,)."""


@dataclass(frozen=True)
class GraspTask:
    """Agent g approaches straight from its stand-off and is welded to the object."""

    weld: Weld
    weld_index: int
    q_OE: np.ndarray
    """q_g that grasps the object when this stands at the origin of the floor with its heading of this step; the agent
    moves along with it."""
    orientation: np.ndarray
    """Of R_WO at that heading, as a quaternion (4,)."""


@dataclass(frozen=True)
class ReleaseTask:
    """Agent r lets go of the object and backs off straight to its stand-off."""

    weld: Weld
    retreat: np.ndarray
    """(2,) [m] displacement of the base."""


@dataclass(frozen=True)
class StepProgram:
    """The tasks of one step. They begin together; late grasps wait until every mover has arrived."""

    actions: tuple[Action, ...]
    travels: tuple[TravelTask, ...]
    """Includes drives to a stand-off within the region, ahead of a late grasp."""
    transports: tuple[TransportTask, ...]
    grasps: tuple[GraspTask, ...]
    """By agents that already stand at their stand-off."""
    late_grasps: tuple[GraspTask, ...]
    releases: tuple[ReleaseTask, ...]


@dataclass(frozen=True)
class MissionProgram:
    """The steps in order of execution; after the last one comes `steps[loop]`."""

    mission: Mission
    steps: tuple[StepProgram, ...]
    loop: int
    welds: tuple[Weld, ...]
    """All welds the plant has; a grasp is commanded by its index here."""

    def index(self, count: int) -> int:
        """Which step is executed as number `count` (from 0)."""
        if count < len(self.steps):
            return count
        return self.loop + (count - self.loop) % (len(self.steps) - self.loop)


def mission_program(mission: Mission, models: MeasuredModels, scenario: Scenario) -> MissionProgram:
    """Turns places into joint configurations."""
    welds = all_welds(models)
    power = {agent.name: agent.power for agent in scenario.agents}
    compiler = _Compiler(models, power, {weld: index for index, weld in enumerate(welds)})
    return MissionProgram(mission, tuple(compiler.step(step) for step in mission.steps), mission.loop, welds)


def start_configuration(stand: Stand, agent: str, models: MeasuredModels) -> np.ndarray:
    """q_i (n,) of an agent that grasps nothing and stands so."""
    offset = models.geometry.postures[agent][stand.posture]
    base = np.asarray(stand.p_WC[:2]) - np.asarray(offset[:2])
    return np.concatenate([base, models.postures[agent][stand.posture]])


def all_welds(models: MeasuredModels) -> tuple[Weld, ...]:
    """Every way in which some agent can grasp some object."""
    return tuple(
        Weld(agent, obj, configuration.name)
        for (agent, obj), configurations in models.grasps.items()
        for configuration in configurations
    )


@dataclass(frozen=True)
class _Compiler:
    models: MeasuredModels
    power: Mapping[str, float]
    weld_index: Mapping[Weld, int]

    def step(self, step: PlacedStep) -> StepProgram:
        travels, transports, grasps, late, releases = [], [], [], [], []
        for action in step.actions:
            if action.kind == "travel":
                (agent,) = action.agents
                goal = start_configuration(step.after.agents[agent], agent, self.models)
                goal = self.models.agents[agent].arriving(goal, action.goal)
                travels.append(TravelTask(agent, action.start, action.goal, goal))
            elif action.kind == "transport":
                transports.append(self._transport(action, step))
            elif action.kind == "grasp":
                (agent,) = action.agents
                grasp = self._grasp(agent, step)
                if self._is_there(agent, step):
                    grasps.append(grasp)
                else:
                    standoff = start_configuration(step.standoffs[agent], agent, self.models)
                    travels.append(TravelTask(agent, action.start, action.start, standoff))
                    late.append(grasp)
            else:
                releases.append(self._release(action.agents[0], step))
        return StepProgram(step.actions, tuple(travels), tuple(transports), tuple(grasps), tuple(late), tuple(releases))

    def _transport(self, action: Action, step: PlacedStep) -> TransportTask:
        shares = np.zeros(len(self.power))
        members = [list(self.power).index(name) for name in action.agents]
        shares[members] = load_shares([self.power[name] for name in action.agents])
        p_goal = np.asarray(step.after.objects[action.object]) - (0.0, 0.0, PRESSED)
        orientation = self._orientation(action.object, step.after)
        return TransportTask(action.object, action.agents, shares, action.start, action.goal, p_goal, orientation)

    def _orientation(self, obj: str, layout: Layout) -> np.ndarray:
        return self.models.objects[obj].pose(np.zeros(3), layout.headings[obj]).rotation().ToQuaternion().wxyz()

    def _grasp(self, agent: str, step: PlacedStep) -> GraspTask:
        obj, option = step.after.agents[agent].grasp
        q = self.models.grasping(agent, obj, option, step.after.headings[obj])
        weld = Weld(agent, obj, option)
        return GraspTask(weld, self.weld_index[weld], q, self._orientation(obj, step.after))

    def _release(self, agent: str, step: PlacedStep) -> ReleaseTask:
        obj, name = step.before.agents[agent].grasp
        (option,) = (g for g in self.models.geometry.grasps[agent, obj] if g.name == name)
        option = option.turned(step.before.headings[obj] - self.models.objects[obj].object.heading)
        retreat = np.asarray(option.p_OoC_standoff)[:2] - np.asarray(option.p_OoC_grasp)[:2]
        return ReleaseTask(Weld(agent, obj, name), retreat)

    def _is_there(self, agent: str, step: PlacedStep) -> bool:
        here, there = step.before.agents[agent], step.standoffs[agent]
        apart = np.linalg.norm(np.asarray(here.p_WC) - np.asarray(there.p_WC))
        return here.posture == there.posture and apart < SAME_PLACE
