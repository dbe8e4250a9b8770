"""All that is constant of a mission's control laws while the supervisor's Progress stays, formed once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from drake_ltl.dynamics import HeldDamping, check_load_shares, team_damping
from drake_ltl.dynamics.null_space import PostureSpring
from drake_ltl.multibody.agent_model import AgentModel
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.drive_law import DriveLaw
from drake_ltl.systems.hold_controller import TRACKING_FREQUENCY
from drake_ltl.systems.latest_field import LatestField
from drake_ltl.systems.posture_springs import PostureSprings
from drake_ltl.systems.program import MissionProgram
from drake_ltl.systems.progress import AgentSignals, Progress
from drake_ltl.systems.signals import Mode, Stage, pack_step
from drake_ltl.systems.step_field import StepField


@dataclass(frozen=True)
class Traveller:
    """An agent with an arm that travels."""

    agent: str
    rows: slice
    damping: HeldDamping


@dataclass(frozen=True)
class Carrier:
    """An agent of a team under way."""

    agent: str
    rows: slice
    share: float
    """c_tau."""
    spring: PostureSpring | None
    """Of a redundant agent."""


@dataclass(frozen=True)
class Load:
    """An object under way, and its team."""

    object: str
    carriers: tuple[Carrier, ...]
    damping: np.ndarray
    """Diagonal of K_O (6,) (rotational; translational) [N m s, N s/m]."""


@dataclass(frozen=True)
class Bearer:
    """An agent that bears a share of the weight of what it holds, in safe mode."""

    agent: str
    rows: slice
    object: str
    share: float


@dataclass(frozen=True)
class Drive:
    """A differential drive."""

    rows: slice
    law: DriveLaw
    hold: np.ndarray
    """Where it holds (8,)."""
    goal: np.ndarray | None = None
    """Where it travels to (8,), if it does."""
    stage: int = Stage.PARKED

    def torques(self, q: np.ndarray, qd: np.ndarray, gradient: np.ndarray | None) -> np.ndarray:
        """(8,) while k dPhi/dq is `gradient` (8,), None if it does not travel."""
        if gradient is None or self.goal is None:
            return self.law.hold(q, qd, self.hold)
        return self.law.travel(q, qd, gradient, self.stage, self.goal)


@dataclass(frozen=True)
class Orders:
    """What the laws of all agents are formed of. Arrays are stacked, agent after agent (n,)."""

    field: StepField | None
    travels: tuple[Traveller, ...]
    loads: tuple[Load, ...]
    bearers: tuple[Bearer, ...]
    drives: Mapping[str, Drive]
    """Differential drives."""
    frequency: np.ndarray
    """Of joints of agents that hold [rad/s], else 0."""
    hold: np.ndarray
    """Where these joints are to stay."""
    reaches: Mapping[str, np.ndarray]
    """agent -> signals.pack_reach."""
    tracking: np.ndarray
    """1 for joints of agents that hold or reach, else 0."""
    moving: np.ndarray
    """1 for joints whose kinetic energy counts in V, else 0."""


class LatestOrders:
    """Orders as a pure function of the Progress, kept for as long as this stays."""

    def __init__(self, program: MissionProgram, scenario: Scenario, models: MeasuredModels, rows: Mapping[str, slice]):
        """`rows` says where each agent's joints are in stacked arrays."""
        settings, agents = scenario.controller, models.agents
        self._program, self._agents, self._rows = program, agents, rows
        self._team_damping = np.repeat([settings.team_rotation_damping, settings.team_damping], 3)
        self._masses = {name: model.borne_mass for name, model in models.objects.items()}
        self._n = sum(model.n for model in agents.values())
        self._field, self._springs = LatestField(program, scenario, models), PostureSprings(agents)
        self._travellers = {
            name: Traveller(name, rows[name], self._held_damping(model, scenario))
            for name, model in agents.items()
            if model.has_arm
        }
        self._drive_laws = {
            name: DriveLaw(model, TRACKING_FREQUENCY, settings.speed_limit)
            for name, model in agents.items()
            if not model.has_arm
        }
        self._latest: tuple[Progress | None, Orders | None] = (None, None)

    @staticmethod
    def _held_damping(model: AgentModel, scenario: Scenario) -> HeldDamping:
        settings = scenario.controller
        K = model.damping(settings.base_damping, settings.arm_damping)
        return HeldDamping.of(model, K, settings.speed_limit, scenario.simulation.time_step)

    def of(self, progress: Progress) -> Orders:
        """What is to be done now."""
        if self._latest[0] is not progress:
            self._latest = (progress, self._form(progress))
        return self._latest[1]

    def _form(self, progress: Progress) -> Orders:
        signals = dict(zip(self._agents, progress.agents, strict=True))
        step = pack_step(self._program.index(progress.count), progress.phase, progress.interval, progress.leg)
        reaches = {name: signals[name].reach for name in self._field.reaching(step)}
        field = self._field.of(step, progress.anchor, reaches)
        drives = {name: self._drive(name, told, field) for name, told in signals.items() if name in self._drive_laws}
        with_arms = {name: told for name, told in signals.items() if name not in drives}
        holding, reaching = (
            [name for name, told in with_arms.items() if told.mode == mode] for mode in (Mode.HOLD, Mode.REACH)
        )
        travels = [task.agent for task in field.travels if task.agent in with_arms] if field is not None else []
        loads = self._loads(field, self._field.snapshot(progress.anchor).q)
        return Orders(
            field=field,
            travels=tuple(self._travellers[name] for name in travels),
            loads=loads,
            bearers=tuple(
                Bearer(name, self._rows[name], self._program.welds[told.grasp].object, told.bears)
                for name, told in signals.items()
                if told.bears > 0.0
            ),
            drives=drives,
            frequency=self._mask(holding) * TRACKING_FREQUENCY,
            hold=np.concatenate([told.hold for told in signals.values()]),
            reaches={name: signals[name].reach for name in reaching},
            tracking=self._mask([*holding, *reaching]),
            moving=self._mask([*travels, *(carrier.agent for load in loads for carrier in load.carriers)]),
        )

    def _drive(self, name: str, told: AgentSignals, field: StepField | None) -> Drive:
        goals = [task.q_goal for task in field.travels if task.agent == name] if field is not None else []
        return Drive(self._rows[name], self._drive_laws[name], told.hold, *((goals[0], told.stage) if goals else ()))

    def _loads(self, field: StepField | None, anchor: Mapping[str, np.ndarray]) -> tuple[Load, ...]:
        loads = []
        for task in field.transports if field is not None else ():
            shares = dict(zip(self._agents, task.shares.tolist(), strict=True))
            team = [self._carrier(name, shares[name], anchor[name]) for name in task.team]
            check_load_shares(np.array([carrier.share for carrier in team]))  # those that act: no motion shows them
            mass = self._masses[task.object] + sum(self._agents[name].mass for name in task.team)
            loads.append(Load(task.object, tuple(team), team_damping(self._team_damping, mass)))
        return tuple(loads)

    def _carrier(self, name: str, share: float, anchor: np.ndarray) -> Carrier:
        spring = self._springs.of(name, anchor) if self._agents[name].is_redundant else None
        return Carrier(name, self._rows[name], share, spring)

    def _mask(self, agents: Iterable[str]) -> np.ndarray:
        mask = np.zeros(self._n)
        for name in agents:
            mask[self._rows[name]] = 1.0
        return mask
