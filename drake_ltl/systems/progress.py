"""Where a mission stands, and what its supervisor sees: immutable data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from pydrake.math import RigidTransform

from drake_ltl.systems.legs import ALL, Leg
from drake_ltl.systems.signals import NO_GRASP, Mode, Phase, Stage
from drake_ltl.systems.step_field import Snapshot


@dataclass(frozen=True)
class AgentSignals:
    """What the supervisor tells one agent's controllers."""

    mode: int
    hold: np.ndarray
    """Configuration (n,) that the hold controller keeps."""
    reach: np.ndarray
    """See `signals.pack_reach`."""
    grasp: int = NO_GRASP
    """Index of the commanded weld."""
    stage: int = Stage.FORWARDS
    """Of a differential drive that travels."""
    bears: float = 0.0
    """In safe mode: its share of the weight of what it holds."""


@dataclass(frozen=True)
class Progress:
    """Where the mission stands."""

    count: int
    """Number of the step being carried out, from 0."""
    phase: Phase
    step_start: float
    """[s]"""
    revision: int
    """Counts changes of commanded grasps."""
    anchor: np.ndarray
    """All configurations and all objects' origins when the interval began; of who holds anything, when the step did."""
    agents: tuple[AgentSignals, ...]
    interval: int = 0
    """Counts, within the step, the intervals of one navigation function each."""
    active: int = ALL
    """The mover that is on its way alone, see `Leg`."""
    way: tuple[tuple[float, float], ...] = ()
    """Way points that it has ahead, before its goal."""
    slow_since: float = np.inf
    """Since when all movers have been at rest [s]."""
    exchange: int = 0
    """Rank of the permutation by which travellers have taken each other's places, see `Leg`."""
    exchanges: int = 0
    """How often they have done so in this step."""
    lets_by: int = ALL
    """The mover that goes next, once the one on its way alone has got out of its way; ALL if that goes to its goal."""

    def with_agent(self, index: int, **changes) -> Progress:
        """With other signals for one agent."""
        agents = list(self.agents)
        agents[index] = replace(agents[index], **changes)
        return replace(self, agents=tuple(agents))

    def new_interval(self, now: Measurement, **changes) -> Progress:
        """With another navigation function from now on. Springs of those who carry stay at rest where the step began,
        with the load on the floor: else they would hold it up there."""
        anchor, start = now.anchor, 0
        for signals in self.agents:
            rows = slice(start, start := start + len(signals.hold))
            if signals.grasp != NO_GRASP:
                anchor[rows] = self.anchor[rows]
        return replace(self, interval=self.interval + 1, anchor=anchor, slow_since=np.inf, **changes)

    def holding(self, now: Measurement, but: frozenset[int] = frozenset()) -> Progress:
        """With every agent holding where it is, except in the modes `but`; who held before keeps its place."""
        state = self
        for index, (signals, q) in enumerate(zip(self.agents, now.q.values(), strict=True)):
            if signals.mode != Mode.HOLD and signals.mode not in but:
                state = state.with_agent(index, mode=Mode.HOLD, hold=q)
        return state

    @property
    def leg(self) -> Leg:
        """What moves now, and by way of which point."""
        return Leg(self.active, self.way[0] if self.way else None, self.exchange)


@dataclass(frozen=True)
class Measurement:
    """What the supervisor sees at one instant."""

    time: float
    q: Mapping[str, np.ndarray]
    qd: Mapping[str, np.ndarray]
    X_WO: Mapping[str, RigidTransform]
    V_WO: Mapping[str, np.ndarray]
    """(6,) (rotational; translational) [rad/s, m/s]."""

    @property
    def anchor(self) -> np.ndarray:
        """All configurations, then all objects' origins."""
        return np.concatenate([*self.q.values(), *(X.translation() for X in self.X_WO.values())])

    @property
    def snapshot(self) -> Snapshot:
        """The same, by name."""
        return Snapshot(self.q, {name: X.translation() for name, X in self.X_WO.items()})
