"""The sizes that the paper gives with a plan."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property

from drake_ltl.errors import SearchLimitError
from drake_ltl.planning.automaton import buchi_size

BUCHI_TIME = 5.0
"""For the size of BA, which the plan itself does not need [s]."""


class Counts(Mapping[str, "int | None"]):
    """Sizes of TS, of the paper's automaton BA and of TS x BA.

    Planning takes another, smaller automaton; BA is translated when its size is asked for, and its sizes are None if
    that takes long.
    """

    def __init__(self, ts_states: int, ts_transitions: int | None, formula: str):
        self._ts_states, self._ts_transitions, self._formula = ts_states, ts_transitions, formula

    @cached_property
    def _all(self) -> dict[str, int | None]:
        states, edges = self._buchi_size()
        return {
            "ts_states": self._ts_states,
            "ts_transitions": self._ts_transitions,
            "automaton_states": states,
            "automaton_edges": edges,
            "product_states": None if states is None else self._ts_states * states,
        }

    def _buchi_size(self) -> tuple[int, int] | tuple[None, None]:
        try:
            return buchi_size(self._formula, BUCHI_TIME)
        except (TimeoutError, SearchLimitError):
            return None, None

    def __getitem__(self, key: str) -> int | None:
        return self._all[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)

    def __repr__(self) -> str:
        return repr(self._all)
