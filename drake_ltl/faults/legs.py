"""What is still carried out after a fault, before the mission is planned again: everybody who can goes to a region.

Tasks are those of the plan's step that was halted, without what can no longer be done, or new ones for those who let
go of something between two regions.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from drake_ltl.faults.losses import Losses
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.planning.mission import Stand
from drake_ltl.planning.plan import Action
from drake_ltl.planning.spheres import rings
from drake_ltl.scenario.model import Region, Scenario
from drake_ltl.systems.legs import Moving
from drake_ltl.systems.program import ReleaseTask, StepProgram, TransportTask, TravelTask, Weld, start_configuration
from drake_ltl.systems.progress import Measurement
from drake_ltl.systems.step_field import FieldBuilder

MARGIN = 0.1
"""What is left between bodies that look for a place [m]."""
PLACES = 200
"""Looked at in a region."""


@dataclass(frozen=True)
class Bodies:
    """Where everything is, and which region contains it."""

    scenario: Scenario
    models: MeasuredModels
    now: Measurement

    def centre(self, member: str) -> np.ndarray:
        """Of its bounding sphere (3,) [m]."""
        if member in self.now.q:
            return self.models.agents[member].centre(self.now.q[member])
        return self.now.X_WO[member].translation()

    def radius(self, member: str) -> float:
        """[m]"""
        geometry = self.models.geometry
        return geometry.agent_radius[member] if member in self.now.q else geometry.object_radius[member]

    def region(self, member: str) -> str | None:
        """The one that contains its sphere."""
        for region in self.scenario.regions:
            if _inside(region, self.centre(member), self.radius(member)):
                return region.name
        return None

    def posture(self, agent: str) -> str:
        """The one of its model's that is nearest to how its arm stands."""
        arm = self.now.q[agent][2:]
        postures = self.models.postures[agent]
        return min(postures, key=lambda name: float(np.abs(arm - postures[name]).max()))


def sound(task: TransportTask, losses: Losses) -> bool:
    """Whether its team can still carry."""
    return task.object not in losses.objects and not set(task.team) & (losses.agents | losses.grippers)


def finishing(step: StepProgram, losses: Losses, bodies: Bodies, began: Mapping[str, np.ndarray]) -> StepProgram:
    """Travels, and transports by sound teams, of those who are between two regions, as far as their goals are free.

    Who is on its way to a region that is blocked does not go on: teams bring their object back to where it was, other
    movers are left to `gathering`.

    Args:
        began: object -> where it was when the step began (3,) [m].
    """
    travels = [
        t
        for t in step.travels
        if t.agent not in losses.agents and bodies.region(t.agent) is None and t.goal not in losses.regions
    ]
    transports = [
        _turned_back(t, began) if t.goal in losses.regions else t
        for t in step.transports
        if sound(t, losses) and None in map(bodies.region, (t.object, *t.team))
    ]
    transports = [t for t in transports if t.goal not in losses.regions and _is_in_goal(t, bodies)]
    kept = [task for task in (*travels, *transports) if not _is_taken([task], bodies)]
    if _is_taken(kept, bodies):
        kept = []
    return _program(
        tuple(task for task in kept if isinstance(task, TravelTask)),
        tuple(task for task in kept if isinstance(task, TransportTask)),
    )


def _turned_back(task: TransportTask, began: Mapping[str, np.ndarray]) -> TransportTask:
    """Back to where the object was."""
    return replace(task, start=task.goal, goal=task.start, p_goal=began[task.object])


def _is_in_goal(task: TransportTask, bodies: Bodies) -> bool:
    """Not if it is to go back to where an earlier fault had halted it."""
    return _inside(bodies.scenario.region(task.goal), task.p_goal, bodies.radius(task.object))


def _is_taken(tasks: Sequence[TravelTask | TransportTask], bodies: Bodies) -> bool:
    """Whether somebody who stays where he is stands in the way of a goal."""
    if not tasks:
        return False
    moving = Moving(
        tuple(task for task in tasks if isinstance(task, TravelTask)),
        tuple(task for task in tasks if isinstance(task, TransportTask)),
    )
    relations = FieldBuilder(bodies.scenario, bodies.models).relations(moving, bodies.now.snapshot, {})
    return bool(relations.relations.violated(relations.goal))


def releasing(holders: Sequence[Weld], bodies: Bodies) -> StepProgram:
    """Everybody lets go."""
    releases, actions = [], []
    for weld in holders:
        (option,) = (g for g in bodies.models.geometry.grasps[weld.agent, weld.object] if g.name == weld.option)
        retreat = np.subtract(option.p_OoC_standoff, option.p_OoC_grasp)[:2]
        releases.append(ReleaseTask(weld, retreat))
        region = bodies.region(weld.object) or bodies.scenario.region_names[0]
        actions.append(Action("release", (weld.agent,), region, region, weld.object))
    return StepProgram(tuple(actions), (), (), (), (), tuple(releases))


def gathering(outside: Mapping[str, tuple[str, str]], losses: Losses, bodies: Bodies) -> StepProgram:
    """Agents that are in no region go to one of the two between which they were, to none that is blocked; those find no
    place stay.

    Args:
        outside: agent -> the regions.
        losses: say which are blocked.
        bodies: where everything is.
    """
    taken = [
        (bodies.centre(name), bodies.radius(name)) for name in (*bodies.now.q, *bodies.now.X_WO) if name not in outside
    ]
    travels = []
    for agent, ends in outside.items():
        place = next(_places(agent, [end for end in ends if end not in losses.regions], taken, bodies), None)
        if place is None:
            taken.append((bodies.centre(agent), bodies.radius(agent)))
            continue
        goal, p_WC = place
        start = ends[0] if goal == ends[1] else ends[1]
        stand = Stand(tuple(map(float, p_WC)), bodies.posture(agent))
        q_goal = bodies.models.agents[agent].arriving(start_configuration(stand, agent, bodies.models), goal)
        travels.append(TravelTask(agent, start, goal, q_goal))
        taken.append((p_WC, bodies.radius(agent)))
    return _program(tuple(travels), ())


def _places(
    agent: str, ends: Sequence[str], taken: Sequence[tuple[np.ndarray, float]], bodies: Bodies
) -> Iterator[tuple[str, np.ndarray]]:
    """Regions with places in them, apart from what is taken, the nearest first."""
    here, radius = bodies.centre(agent), bodies.radius(agent)
    height = bodies.models.geometry.postures[agent][bodies.posture(agent)][2]
    found = []
    for name in dict.fromkeys(ends):
        region = bodies.scenario.region(name)
        reach = region.radius - radius - MARGIN
        for offset in rings(reach, PLACES) if reach > 0.0 else ():
            p = np.array([region.centre[0] + offset[0], region.centre[1] + offset[1], height])
            apart = all(np.linalg.norm(p - q) > radius + r + MARGIN for q, r in taken)
            if apart and _inside(region, p, radius):
                found.append((float(np.linalg.norm(p - here)), name, p))
    for _, name, p in sorted(found, key=lambda entry: entry[0]):
        yield name, p


def _inside(region: Region, centre: np.ndarray, radius: float) -> bool:
    return float(np.linalg.norm(centre - np.array(region.centre))) + radius <= region.radius


def _program(travels: tuple[TravelTask, ...], transports: tuple[TransportTask, ...]) -> StepProgram:
    actions = [Action("travel", (task.agent,), task.start, task.goal) for task in travels]
    actions += [Action("transport", task.team, task.start, task.goal, task.object) for task in transports]
    return StepProgram(tuple(actions), travels, transports, (), (), ())
