"""What all monitors have in common: they look, remember, report, and never act."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import Context, EventStatus, LeafSystem, ValueProducer

from drake_ltl.monitoring.violation import Violation


@dataclass
class Memory:
    """What a monitor has seen in one Context."""

    found: dict[tuple, Violation] = field(default_factory=dict)
    """In order of time, by `Violation.key`."""
    notes: Any = None
    """Whatever else the monitor keeps from one look to the next; None at first."""


class Monitor(LeafSystem):
    """Base of the systems that watch a mission.

    A monitor has no outputs and no state, so nothing can depend on it: what it has seen is kept in its Context as a
    VectorLogSink keeps its log. It looks when the simulation begins and every `period` seconds. A violation that is
    new (see `Violation.key`) ends the AdvanceTo that is under way with this system's status; whoever advances the
    Simulator may go on, and is not stopped by the same one again.
    """

    def __init__(self, name: str, period: float):
        """`period` [s]."""
        super().__init__()
        self.set_name(f"monitor_{name}")
        self.kind = name
        self.period = period
        self._memory = self.DeclareCacheEntry(
            "memory", ValueProducer(allocate=_fresh, calc=_no_calc), prerequisites_of_calc={self.nothing_ticket()}
        )
        self.DeclareInitializationPublishEvent(self._forget)
        self.DeclarePeriodicPublishEvent(period, 0.0, self._publish)

    @abstractmethod
    def _observe(self, context: Context, memory: Memory) -> Iterable[Violation]:
        """What is wrong now; may write `memory.notes`."""

    def Look(self, context: Context) -> tuple[Violation, ...]:
        """Looks now, out of turn. Returns what is new; it is remembered."""
        memory = self._remembered(context)
        new = {}
        for violation in self._observe(context, memory):
            if violation.key not in memory.found:
                new.setdefault(violation.key, violation)
        memory.found |= new
        return tuple(new.values())

    def violations(self, context: Context) -> tuple[Violation, ...]:
        """All that was seen so far, in order of time."""
        return tuple(self._remembered(context).found.values())

    def _remembered(self, context: Context) -> Memory:
        return self._memory.get_mutable_cache_entry_value(context).GetMutableValueOrThrow()

    def _forget(self, context: Context) -> EventStatus:
        memory = self._remembered(context)
        memory.found, memory.notes = {}, None
        return _NOTHING

    def _publish(self, context: Context) -> EventStatus:
        new = self.Look(context)
        if not new:
            return _NOTHING
        return EventStatus.ReachedTermination(self, "; ".join(str(violation) for violation in new))


_NOTHING = EventStatus.DidNothing()


def _fresh() -> AbstractValue:
    return Value[object](Memory())


def _no_calc(context: Context, value: AbstractValue) -> None:
    """Only looks change the memory."""
