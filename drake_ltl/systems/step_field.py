"""The navigation function of one step with the numbers it is evaluated on: who moves, where to, around what."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from drake_ltl.multibody.agent_model import AgentModel
from drake_ltl.navigation import (
    NavigationFunction,
    PseudoHuber,
    Reach,
    RegionBall,
    StaticBody,
    StepRelations,
    Transport,
    Traveller,
    step_relations,
)
from drake_ltl.planning.geometry import Geometry
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.program import StepProgram


@dataclass(frozen=True)
class StepField:
    """phi of one step. Points of the movers come first: travellers, then carried objects, as the tasks do."""

    program: StepProgram
    relations: StepRelations
    function: NavigationFunction


def step_field(
    program: StepProgram,
    scenario: Scenario,
    geometry: Geometry,
    agents: Mapping[str, AgentModel],
    q: Mapping[str, np.ndarray],
    p_WO: Mapping[str, np.ndarray],
    reaches: Mapping[str, tuple[np.ndarray, np.ndarray]],
) -> StepField | None:
    """Builds phi for the bodies as they stand when the step begins; None if nothing moves under it.

    Args:
        q: each agent's configuration (n_i,) at the begin of the step.
        p_WO: each object's origin (3,) [m] at the begin of the step.
        reaches: for each agent that approaches or backs off during the step: its configurations at both ends.

    Raises:
        InvalidInputError: a goal violates a relation (a placement that cannot be carried out).
    """
    if not program.travels and not program.transports:
        return None
    centre = {name: model.centre(q[name]) for name, model in agents.items()}
    moving = {task.agent for task in program.travels}
    carried = {task.object for task in program.transports}
    carriers = {name for task in program.transports for name in task.team}
    relations = step_relations(
        travellers=[
            Traveller(
                task.agent,
                geometry.agent_radius[task.agent],
                task.start,
                task.goal,
                tuple(centre[task.agent]),
                tuple(agents[task.agent].centre(task.q_goal)),
            )
            for task in program.travels
        ],
        transports=[
            Transport(
                task.object,
                task.team,
                geometry.team_radius[task.object],
                task.start,
                task.goal,
                tuple(p_WO[task.object]),
                tuple(task.p_goal),
            )
            for task in program.transports
        ],
        static_agents=[
            StaticBody(name, geometry.agent_radius[name], tuple(centre[name]))
            for name in agents
            if name not in moving | carriers | reaches.keys()
        ],
        reaches=[_reach(name, agents[name], geometry.agent_radius[name], ends) for name, ends in reaches.items()],
        static_objects=[
            StaticBody(name, geometry.object_radius[name], tuple(p)) for name, p in p_WO.items() if name not in carried
        ],
        regions=[RegionBall(region.name, region.centre, region.radius) for region in scenario.regions],
        workspace_radius=scenario.workspace_radius,
    )
    settings = scenario.controller
    function = NavigationFunction.for_goal(
        relations.relations,
        relations.goal,
        kappa=settings.kappa,
        lambda_=settings.lambda_,
        h=settings.h,
        shaping=PseudoHuber(settings.delta),
    )
    return StepField(program, relations, function)


def _reach(name: str, model: AgentModel, radius: float, ends: tuple[np.ndarray, np.ndarray]) -> Reach:
    """Both ends of the way count, with spheres whose union covers the whole swept sphere.

    Two balls of radius rho at distance 2 h cover the capsule of radius r between them iff rho^2 = r^2 + h^2.
    """
    start, goal = (model.centre(q) for q in ends)
    half = float(np.linalg.norm(goal - start)) / 2
    covering = float(np.hypot(radius, half))
    return Reach(name, (tuple(start), tuple(goal)), (covering, covering))
