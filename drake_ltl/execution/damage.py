"""Whether the parts of a recording's file are of the kinds that `Recording` says they are.

JSON and arrays can hold anything; whoever reads a recording may rely on what this lets pass. What its numbers and
names mean is not asked here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from drake_ltl.execution.recording_versions import lacks_of_some_version

LARGEST = 1e9
"""Magnitude of numbers in the header; larger ones are no lengths, times or angles of a run."""
_WHOLE_ARRAYS = ("step", "phase", "mode", "grasp")


def header_damage(header: Mapping[str, Any]) -> Iterator[str]:
    """What is of another kind than it should be, in a header in which nothing is missing."""
    yield from _unfit("", header, _HEADER)
    for index, step in enumerate(header["steps"]):
        yield from _unfit(f"steps[{index}].", {"halted": "", "faulty": [], **step}, _STEP)
    for index, interval in enumerate(header["intervals"]):
        yield from _unfit(f"intervals[{index}].", interval, _INTERVAL)
    for index, seen in enumerate(header["monitored"]):
        yield from _unfit(f"monitored[{index}].", seen, _MONITORED)


def array_damage(arrays: Mapping[str, np.ndarray]) -> Iterator[str]:
    """Arrays of other numbers than Recording has."""
    for name, array in arrays.items():
        wanted = np.dtype(np.int64 if name in _WHOLE_ARRAYS else np.float64)
        if array.dtype != wanted:
            yield f"{_named(name)} is an array of {array.dtype}, not of {wanted}"


def _unfit(where: str, entries: Mapping[str, Any], checks: Mapping[str, tuple]) -> Iterator[str]:
    for key, (fits, kind) in checks.items():
        if not fits(entries[key]):
            yield f"{where}{key} is {_shown(entries[key])}, not {kind}"


def _shown(value: Any) -> str:
    try:
        text = repr(value)
    except ValueError:  # integers of thousands of digits have no decimal text
        text = "a number of thousands of digits"
    return text if len(text) <= 60 else f"{text[:57]}..."


def _named(name: str) -> str:
    return name if len(name) <= 60 and name.isprintable() else _shown(name)


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _is_flag(value: Any) -> bool:
    return isinstance(value, bool)


def _is_map(value: Any) -> bool:
    return isinstance(value, dict)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= LARGEST  # so no nan


def _is_count(value: Any) -> bool:
    return isinstance(value, int) and _is_number(value)


def _is_seed(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**63


def _are_texts(value: Any) -> bool:
    return isinstance(value, (list, tuple)) and all(map(_is_text, value))


def _are_lacks(value: Any) -> bool:
    return _are_texts(value) and lacks_of_some_version(value)


def _are_numbers(value: Any) -> bool:
    return isinstance(value, list) and all(map(_is_number, value))


def _are_named_numbers(value: Any) -> bool:
    return isinstance(value, dict) and all(map(_is_number, value.values()))


def _are_goals(value: Any) -> bool:
    return isinstance(value, dict) and all(map(_are_numbers, value.values()))


def _are_ways(value: Any) -> bool:
    return isinstance(value, dict) and all(
        isinstance(ends, list) and len(ends) == 2 and all(map(_are_numbers, ends)) for ends in value.values()
    )


def _is_measured(value: Any) -> bool:
    return value is None or _is_number(value)


def _are_actions(value: Any) -> bool:
    return isinstance(value, list) and all(map(_is_action, value))


def _is_action(value: Any) -> bool:
    return (
        isinstance(value, dict)
        and set(value) == {"kind", "agents", "object", "from", "to"}
        and _are_texts(value["agents"])
        and all(isinstance(value[key], str) for key in ("kind", "from", "to"))
        and isinstance(value["object"], str | None)
    )


_HEADER = {
    "scenario": (_is_text, "a text"),
    "versions": (_is_map, "a map"),
    "agents": (_are_texts, "a list of names"),
    "objects": (_are_texts, "a list of names"),
    "agent_radius": (_are_named_numbers, "a map of numbers"),
    "object_radius": (_are_named_numbers, "a map of numbers"),
    "team_radius": (_are_named_numbers, "a map of numbers"),
    "prefix_length": (_is_count, "a whole number"),
    "suffix_length": (_is_count, "a whole number"),
    "completed": (_is_flag, "true or false"),
    "reason": (_is_text, "a text"),
    "seed": (_is_seed, "a whole number"),
    "lacks": (_are_lacks, "what recordings of some version lack"),
}
_STEP = {
    "number": (_is_count, "a whole number"),
    "actions": (_are_actions, "a list of actions"),
    "start": (_is_number, "a number"),
    "duration": (_is_number, "a number"),
    "finished": (_is_flag, "true or false"),
    "halted": (_is_text, "a text"),
    "faulty": (_are_texts, "a list of names"),
}
_INTERVAL = {
    "step": (_is_count, "a whole number"),
    "phase": (_is_count, "a whole number"),
    "travels": (_are_goals, "a map of lists of numbers"),
    "transports": (_are_goals, "a map of lists of numbers"),
    "waiting": (_are_texts, "a list of names"),
    "reaches": (_are_ways, "a map of pairs of lists of numbers"),
}
_MONITORED = {
    "monitor": (_is_text, "a text"),
    "time": (_is_number, "a number"),
    "step": (_is_count, "a whole number"),
    "who": (_are_texts, "a list of names"),
    "what": (_is_text, "a text"),
    "value": (_is_measured, "a number"),
    "limit": (_is_measured, "a number"),
    "unit": (_is_text, "a text"),
}
