"""What acts on the joints of agents besides their drives, by two measurements and the torques between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drake_ltl.multibody.crew import CrewModel
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.progress import Progress
from drake_ltl.systems.state_places import StatePlaces


@dataclass(frozen=True)
class Look:
    """Progress, state and torques (n,) of one look."""

    progress: Progress
    x: np.ndarray
    torques: tuple[np.ndarray, ...]
    """Of this look, and before it those of looks back to when `x` was measured; oldest first."""
    acted: np.ndarray | None = None
    """Torques (n,) from the state of the look before to this one's; None if they are not known."""


class Residuals:
    """B qdd + N qd + g - tau (n,) of all agents, with qdd from two measurements and tau of when they were made: what
    acts on the joints besides drives. Of a differential drive, which stands on the floor, it is that of (U1), at its
    joints x and yaw."""

    def __init__(self, places: StatePlaces, scenario: Scenario, models: MeasuredModels):
        self._places, self._dt = places, scenario.simulation.time_step
        self.crew = CrewModel(scenario.agents)
        """In the state of which the latest residual is."""
        self.limits = np.concatenate([model.effort_limits for model in models.agents.values()])
        """Of torques (n,) [N, N m]."""
        ranges = [
            (model.plant.GetPositionLowerLimits(), model.plant.GetPositionUpperLimits())
            for model in models.agents.values()
        ]
        self._lower, self._upper = (np.concatenate(ends) for ends in zip(*ranges, strict=True))
        self._wheeled = {name: model for name, model in models.agents.items() if not model.has_arm}

    def look(self, before: Look | None, progress: Progress, x: np.ndarray, torque: np.ndarray, age: float) -> Look:
        """What there is to be remembered of a look; `torque` (n,) acts from now on, `age` is that of `x` [s]."""
        torque, late = np.clip(torque, -self.limits, self.limits), round(age / self._dt)
        if before is None:
            return Look(progress, x.copy(), (torque,))
        # once the supervisor has changed its mind other torques act than were seen before
        known = progress is before.progress and len(before.torques) > late
        torques = (*before.torques, torque)[-1 - late :]
        return Look(progress, x.copy(), torques, before.torques[0] if known else None)

    def between(self, before: Look, now: Look) -> np.ndarray:
        """The residual (n,) [N, N m] of two looks, of which the torques that acted are known."""
        q, qd = before.x[self._places.q], before.x[self._places.qd]
        qdd = (now.x[self._places.qd] - qd) / self._dt
        self.crew.set_state(q, qd)
        residual = self.crew.inverse_dynamics(qdd) - now.acted
        for name, model in self._wheeled.items():
            rows = self.crew.rows[name]
            residual[rows] = model.unexplained(q[rows], qdd[rows], now.acted[rows])
        return residual

    def near_stops(self, look: Look, within: float) -> np.ndarray:
        """(n,) whether joints are so near to one of their limits [m, rad]."""
        q = look.x[self._places.q]
        return (q < self._lower + within) | (q > self._upper - within)
