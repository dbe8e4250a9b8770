"""Monitor of the word: whether what the team has done so far can still satisfy the specification."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Context

from drake_ltl.monitoring.prefixes import START, Place, Prefixes, Standing
from drake_ltl.monitoring.violation import Finding
from drake_ltl.systems.monitors.mission_monitor import Look, MissionMonitor
from drake_ltl.systems.monitors.monitor import Memory
from drake_ltl.systems.program import MissionProgram


@dataclass(frozen=True)
class Watched:
    """One formula that is watched."""

    member: str
    """Whose it is; empty for the global one."""
    formula: str
    prefixes: Prefixes
    letter: Callable[[Mapping[str, str | None]], frozenset[str]]
    """Of the regions of all members."""


@dataclass(frozen=True)
class Reading:
    """How far the word has been read."""

    letters: int
    places: tuple[Place, ...]


class WordMonitor(MissionMonitor):
    """Spells the word, one letter for the start and one for each step that has ended, and reads it with the monitors
    of all formulas.

    .. pydrake_system::

        name: WordMonitor
        input_ports:
        - centres
        - progress
    """

    def __init__(
        self,
        name: str,
        period: float,
        program: MissionProgram,
        size: int,
        *,
        watched: tuple[Watched, ...],
        end_centres: Callable[[Look], np.ndarray],
        regions: Callable[[np.ndarray], Mapping[str, str | None]],
        unwatched: Mapping[str, str],
    ):
        """
        Args:
            end_centres: centres (3 (N + M),) when the step before this one ended.
            regions: (N + M, 3) -> where everybody is.
            unwatched: formulas whose monitors are too large -> why.
        """
        super().__init__(name, period, program, "centres", size)
        self._watched, self._end_centres, self._regions = watched, end_centres, regions
        self.unwatched = dict(unwatched)

    def standings(self, context: Context) -> dict[str, Standing]:
        """Formula -> what the word so far says of it; of a member's formula with the member's name before it."""
        reading = self._reading(self._remembered(context))
        return {_title(item): place.standing for item, place in zip(self._watched, reading.places, strict=True)}

    def _findings(self, look: Look, memory: Memory) -> Iterator[Finding]:
        reading = self._reading(memory)
        missing = look.step + 1 - reading.letters
        if missing <= 0:
            return
        regions = self._regions(self._end_centres(look).reshape(-1, 3))
        places = reading.places
        for _ in range(missing):  # several only if steps without motion ended since the last look
            places = tuple(
                item.prefixes.after(place, item.letter(regions))
                for item, place in zip(self._watched, places, strict=True)
            )
        memory.notes = Reading(look.step + 1, places)
        for item, old, new in zip(self._watched, reading.places, places, strict=True):
            if new.standing is Standing.BAD and old.standing is not Standing.BAD:
                whose = f"{item.member}'s formula" if item.member else "the global formula"
                yield Finding(
                    (item.member,) if item.member else (), f"nothing can satisfy {whose} any more: {item.formula}"
                )

    def _reading(self, memory: Memory) -> Reading:
        return memory.notes or Reading(0, (START,) * len(self._watched))


def _title(item: Watched) -> str:
    return f"{item.member}: {item.formula}" if item.member else item.formula
