"""The navigation function of the interval that is being carried out, formed once."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.exchange import exchanged
from drake_ltl.systems.legs import moving_tasks
from drake_ltl.systems.program import MissionProgram
from drake_ltl.systems.signals import Phase, reach_ends, unpack_step
from drake_ltl.systems.step_field import FieldBuilder, Snapshot, StepField


class LatestField:
    """phi as a pure function of the supervisor's signals, kept for as long as these stay."""

    def __init__(self, program: MissionProgram, scenario: Scenario, models: MeasuredModels):
        self._program, self._models, self._builder = program, models, FieldBuilder(scenario, models)
        self._latest: tuple[bytes, StepField | None] = (b"", None)

    def reaching(self, step: np.ndarray) -> list[str]:
        """Agents on whose signal `reach` phi depends."""
        program = self._program.steps[int(step[0])]
        return [task.weld.agent for task in (*program.grasps, *program.releases)]

    def of(self, step: np.ndarray, anchor: np.ndarray, reaches: Mapping[str, np.ndarray]) -> StepField | None:
        """None while nothing moves under a navigation function.

        Args:
            step: packed by `signals.pack_step`.
            anchor: all configurations and all objects' origins when the interval began.
            reaches: for each agent that is `reaching`, packed by `signals.pack_reach`.
        """
        key = b"".join(array.tobytes() for array in (step, anchor, *reaches.values()))
        if self._latest[0] != key:
            self._latest = (key, self._build(step, anchor, reaches))
        return self._latest[1]

    def snapshot(self, anchor: np.ndarray) -> Snapshot:
        """Of the signal `anchor`."""
        q, p_WO, start = {}, {}, 0
        for name, model in self._models.agents.items():
            q[name], start = anchor[start : start + model.n], start + model.n
        for name in self._models.objects:
            p_WO[name], start = anchor[start : start + 3], start + 3
        return Snapshot(q, p_WO)

    def _build(self, signal: np.ndarray, anchor: np.ndarray, reaches: Mapping[str, np.ndarray]) -> StepField | None:
        index, phase, leg = unpack_step(signal)
        step = exchanged(self._program.steps[index], leg.exchange, self._models)
        if phase is not Phase.NAVIGATE or not (step.travels or step.transports):
            return None
        ends = {name: reach_ends(reach) for name, reach in reaches.items()}
        return self._builder.field(moving_tasks(step, leg, self._models), self.snapshot(anchor), ends)
