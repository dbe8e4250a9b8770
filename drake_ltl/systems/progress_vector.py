"""Progress as the numbers that are a system's discrete state."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from drake_ltl.systems.progress import AgentSignals, Progress
from drake_ltl.systems.signals import Phase

MOST_WAY_POINTS = 64
"""Of a detour; a longer one is cut there, and sought anew from where it ends."""
HEADER = 11
"""count, phase, step start, revision, interval, active mover, slow since, exchange, exchanges, mover that is let by,
number of way points"""
NUMBERS = 4
"""mode, grasp, stage and share of an agent."""


@dataclass(frozen=True)
class ProgressVector:
    """Packs Progress into a vector (size,) and unpacks it; way points beyond MOST_WAY_POINTS are left out."""

    joints: tuple[int, ...]
    """n_i of each agent."""
    num_objects: int

    @cached_property
    def size(self) -> int:
        return self._starts[-1]

    @cached_property
    def _starts(self) -> list[int]:
        """Where way, anchor and each agent's signals (its NUMBERS; hold; reach) begin, and the end of all."""
        anchor = sum(self.joints) + 3 * self.num_objects
        parts = [HEADER, 2 * MOST_WAY_POINTS, anchor, *(NUMBERS + n + (2 + 2 * n) for n in self.joints)]
        return np.cumsum(parts).tolist()

    def pack(self, progress: Progress) -> np.ndarray:
        way = progress.way[:MOST_WAY_POINTS]
        header = [progress.count, progress.phase, progress.step_start, progress.revision, progress.interval]
        header += [progress.active, progress.slow_since, progress.exchange, progress.exchanges]
        header += [progress.lets_by, len(way)]
        padded = np.zeros((MOST_WAY_POINTS, 2))
        padded[: len(way)] = np.reshape(way, (-1, 2))
        agents = [([told.mode, told.grasp, told.stage, told.bears], told.hold, told.reach) for told in progress.agents]
        return np.concatenate([header, padded.ravel(), progress.anchor, *(part for parts in agents for part in parts)])

    def unpack(self, vector: np.ndarray) -> Progress:
        header, way, anchor, *agents = np.split(vector.copy(), self._starts[:-1])
        count, phase, step_start, revision, interval, active, slow_since, *last = header.tolist()
        exchange, exchanges, lets_by, ahead = last
        return Progress(
            count=int(count),
            phase=Phase(int(phase)),
            step_start=step_start,
            revision=int(revision),
            anchor=anchor,
            agents=tuple(self._signals(part, n) for part, n in zip(agents, self.joints, strict=True)),
            interval=int(interval),
            active=int(active),
            way=tuple((x, y) for x, y in way.reshape(-1, 2)[: int(ahead)].tolist()),
            slow_since=slow_since,
            exchange=int(exchange),
            exchanges=int(exchanges),
            lets_by=int(lets_by),
        )

    @staticmethod
    def _signals(part: np.ndarray, n: int) -> AgentSignals:
        mode, grasp, stage = map(int, part[: NUMBERS - 1])
        hold, reach = part[NUMBERS : NUMBERS + n], part[NUMBERS + n :]
        return AgentSignals(mode, hold, reach, grasp, stage, float(part[NUMBERS - 1]))
