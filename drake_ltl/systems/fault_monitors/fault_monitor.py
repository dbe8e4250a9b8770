"""What the monitors of faults have in common."""

from __future__ import annotations

from dataclasses import dataclass, field

from pydrake.common.value import Value
from pydrake.systems.framework import Context, InputPort

from drake_ltl.monitoring.violation import Violation
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.monitors import Monitor
from drake_ltl.systems.progress import Progress
from drake_ltl.systems.state_places import StatePlaces

SMOOTHING = 0.1
"""Time constant with which residuals and errors are smoothed [s]."""


@dataclass
class Durations:
    """Since when something has been so, by name."""

    since: dict[str, float] = field(default_factory=dict)

    def lasts(self, name: str, is_so: bool, now: float) -> float:
        """For how long by now [s]; 0 if it is not."""
        if not is_so:
            self.since.pop(name, None)
            return 0.0
        return now - self.since.setdefault(name, now)


class FaultMonitor(Monitor):
    """What the monitors of faults have in common.

    .. pydrake_system::

        name: FaultMonitor
        input_ports:
        - state
        - progress
    """

    def __init__(self, name: str, places: StatePlaces, scenario: Scenario, first_step: int, ignored: frozenset[str]):
        """
        Args:
            places: what is where in `state`.
            first_step: number of the run's step with which this diagram begins.
            ignored: members of whose faults is known.
        """
        super().__init__(name, scenario.simulation.time_step)
        self._places, self._first_step, self._ignored = places, first_step, ignored
        self._state = self.DeclareVectorInputPort("state", places.size)
        self._progress = self.DeclareAbstractInputPort("progress", Value[object]())

    def get_state_input_port(self) -> InputPort:
        return self._state

    def get_progress_input_port(self) -> InputPort:
        return self._progress

    def Restart(self, context: Context) -> None:
        """Looks anew from now on: commands have changed between two looks."""
        self._remembered(context).notes = None

    def _says(
        self,
        context: Context,
        progress: Progress,
        who: tuple[str, ...],
        what: str,
        *,
        value: float | None = None,
        limit: float | None = None,
        unit: str = "",
    ) -> Violation:
        step = self._first_step + progress.count
        return Violation(self.kind, context.get_time(), step, who, what, value, limit, unit)
