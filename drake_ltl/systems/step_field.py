"""The navigation function of one step with the numbers it is evaluated on: who moves, where to, around what."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from drake_ltl.dynamics.load_spring import LoadSpring
from drake_ltl.multibody.agent_model import AgentModel
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.navigation import (
    MoverPotential,
    NavigationFunction,
    Reach,
    RegionBall,
    StaticBody,
    StepRelations,
    Transport,
    Traveller,
    number_of_factors,
    shaping_from,
    step_relations,
)
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.legs import Moving
from drake_ltl.systems.program import TransportTask, TravelTask

LEAST_KAPPA = 12.0
"""Less is slow even among few bodies."""
KAPPA_PER_FACTOR = 1.25
"""kappa for each factor of G where the scenario leaves it open: over random layouts, less is slow and more comes too
close to what is passed. With lambda > 0 a pair is in many factors; counted once, forces are a hundred times what motors
give."""


@dataclass(frozen=True)
class Snapshot:
    """Where everything stood when a phase, or a leg of a detour, began."""

    q: Mapping[str, np.ndarray]
    """agent -> configuration (n_i,)."""
    p_WO: Mapping[str, np.ndarray]
    """object -> origin (3,) [m]."""


@dataclass(frozen=True)
class StepField:
    """phi of one step. Points of the movers come first: travellers, then carried objects, as the tasks do."""

    travels: tuple[TravelTask, ...]
    transports: tuple[TransportTask, ...]
    relations: StepRelations
    function: NavigationFunction

    @cached_property
    def springs(self) -> tuple[LoadSpring, ...]:
        """Of the carried objects."""
        return tuple(LoadSpring(task.p_goal, task.orientation_goal) for task in self.transports)

    @cached_property
    def potential(self) -> MoverPotential:
        """The same function, of the movers alone."""
        return MoverPotential(self.relations, self.function)


@dataclass(frozen=True)
class FieldBuilder:
    """Builds the navigation function of a step for the bodies as they stand."""

    scenario: Scenario
    models: MeasuredModels

    def relations(
        self, moving: Moving, snapshot: Snapshot, reaches: Mapping[str, tuple[np.ndarray, np.ndarray]]
    ) -> StepRelations:
        """The relations of a step.

        Args:
            moving: what moves, and which teams wait to move later.
            snapshot: where everything stands.
            reaches: for each agent that approaches or backs off meanwhile: its configurations at both ends.
        """
        travels, transports, waiting = moving
        geometry, agents = self.models.geometry, self.models.agents
        centre = {name: model.centre(snapshot.q[name]) for name, model in agents.items()}
        elsewhere = {task.agent for task in travels} | reaches.keys()
        elsewhere |= {name for task in (*transports, *waiting) for name in task.team}
        carried = {task.object for task in (*transports, *waiting)}
        return step_relations(
            travellers=[self._traveller(task, centre[task.agent]) for task in travels],
            transports=[self._transport(task, snapshot.p_WO[task.object]) for task in transports],
            static_agents=[
                StaticBody(name, geometry.agent_radius[name], tuple(centre[name]))
                for name in agents
                if name not in elsewhere
            ],
            reaches=[_reach(name, agents[name], geometry.agent_radius[name], ends) for name, ends in reaches.items()],
            static_objects=[
                *(
                    StaticBody(name, geometry.object_radius[name], tuple(p))
                    for name, p in snapshot.p_WO.items()
                    if name not in carried
                ),
                *(
                    StaticBody(task.object, geometry.team_radius[task.object], tuple(snapshot.p_WO[task.object]))
                    for task in waiting
                ),
            ],
            regions=[RegionBall(region.name, region.centre, region.radius) for region in self.scenario.regions],
            workspace_radius=self.scenario.workspace_radius,
        )

    def field(
        self, moving: Moving, snapshot: Snapshot, reaches: Mapping[str, tuple[np.ndarray, np.ndarray]]
    ) -> StepField:
        """phi for these movers (see `relations` for the arguments).

        Raises:
            InvalidInputError: a goal violates a relation (a placement that cannot be carried out), or the controller's
                settings do not allow a navigation function (lambda > 0 with too many relations, an unfit shaping).
        """
        relations = self.relations(moving, snapshot, reaches)
        settings = self.scenario.controller
        kappa = settings.kappa or self._kappa(relations)
        shaping = partial(shaping_from, settings.shaping, delta=settings.delta, kappa=kappa)
        function = NavigationFunction.for_goal(
            relations.relations,
            relations.goal,
            kappa=kappa,
            lambda_=settings.lambda_,
            h=settings.h,
            shaping=shaping(),
            n_movers=relations.n_movers,
        )
        if function.log_G_goal < function.log_G(relations.start):  # whoever leaves a crowd has force enough
            function = replace(function, shaping=shaping(n_movers=relations.n_movers))
        return StepField(moving.travels, moving.transports, relations, function)

    def _kappa(self, step: StepRelations) -> float:
        factors = number_of_factors(step.relations, self.scenario.controller.lambda_, step.goal, step.n_movers)
        return max(LEAST_KAPPA, KAPPA_PER_FACTOR * factors)

    def _traveller(self, task: TravelTask, centre: np.ndarray) -> Traveller:
        goal = self.models.agents[task.agent].centre(task.q_goal)
        radius = self.models.geometry.agent_radius[task.agent]
        return Traveller(task.agent, radius, task.start, task.goal, tuple(centre), tuple(goal))

    def _transport(self, task: TransportTask, p_WO: np.ndarray) -> Transport:
        radius = self.models.geometry.team_radius[task.object]
        return Transport(task.object, task.team, radius, task.start, task.goal, tuple(p_WO), tuple(task.p_goal))


def _reach(name: str, model: AgentModel, radius: float, ends: tuple[np.ndarray, np.ndarray]) -> Reach:
    """Both ends of the way count, with spheres whose union covers the whole swept sphere.

    Two balls of radius rho at distance 2 h cover the capsule of radius r between them iff rho^2 = r^2 + h^2.
    """
    start, goal = (model.centre(q) for q in ends)
    half = float(np.linalg.norm(goal - start)) / 2
    covering = float(np.hypot(radius, half))
    return Reach(name, (tuple(start), tuple(goal)), (covering, covering))
