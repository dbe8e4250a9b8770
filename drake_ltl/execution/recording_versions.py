"""Recordings of older versions, brought to today's: what they do not hold is named in `lacks`, and filled in.

version 1   the first: gaps of welds in place of what moved under each navigation function
version 2   without gaps (they are worked out of the motion), with `intervals`; later ones with `effort` and
            `manipulability`
version 3   with `seed` and `lacks`
version 4   with `monitored`
version 5   the potential grows with distance where many gather, and kappa with the relations of all levels: `gathering`
version 6   loads are lifted and held level, and springs rest where the step began: `lift`
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import Any

import numpy as np

from drake_ltl.errors import InvalidInputError
from drake_ltl.scenario import yaml_text

VERSION = 6
SINCE = {"intervals": 2, "effort": 3, "manipulability": 3, "gathering": 5, "lift": 6}
"""What files may lack -> the version since which all have it, in the order in which `lacks` names it."""

Parts = tuple[dict[str, Any], dict[str, np.ndarray]]
"""Header and arrays of a file."""


def brought_up(header: dict[str, Any], arrays: dict[str, np.ndarray]) -> Parts:
    """Header and arrays as a file of today's version has them. Those given are left as they are.

    Raises:
        KeyError: something is missing that its version has.
    """
    header, arrays = {"lacks": [], **header}, dict(arrays)
    for version in range(header["version"], VERSION):
        _STEPS[version](header, arrays)
    return header | {"version": VERSION}, arrays


def whose_potential(lacks: Collection[str]) -> int:
    """The newest version that has the V of a recording that lacks this."""
    return min((SINCE[name] for name in lacks if name in ("intervals", "gathering", "lift")), default=VERSION + 1) - 1


def lacks_of_some_version(lacks: Sequence[str]) -> bool:
    """Whether files that lack this were ever written: who lacks something lacks all that is newer."""
    there = {"effort", "manipulability"} - set(lacks)  # later files of version 2 have them
    oldest = min((SINCE.get(name, 0) for name in lacks), default=VERSION + 1)
    return list(lacks) == [name for name, since in SINCE.items() if since >= oldest and name not in there]


def _from_1(header: dict[str, Any], arrays: dict[str, np.ndarray]) -> None:
    del arrays["weld_gap"], arrays["weld_angle"]
    header["intervals"] = []
    header["lacks"] = [*header["lacks"], "intervals"]


def _from_2(header: dict[str, Any], arrays: dict[str, np.ndarray]) -> None:
    header["seed"] = _seed(header["scenario"])
    for name in ("effort", "manipulability"):
        if name not in arrays:
            arrays[name] = np.zeros((len(arrays["time"]), len(header["agents"])))
            header["lacks"] = [*header["lacks"], name]


def _from_3(header: dict[str, Any], arrays: dict[str, np.ndarray]) -> None:
    header["monitored"] = []


def _from_4(header: dict[str, Any], arrays: dict[str, np.ndarray]) -> None:
    header["lacks"] = [*header["lacks"], "gathering"]


def _from_5(header: dict[str, Any], arrays: dict[str, np.ndarray]) -> None:
    header["lacks"] = [*header["lacks"], "lift"]


def _seed(scenario: str) -> int:
    """What the scenario's text says; 0, as there, if it says nothing."""
    try:
        data = yaml_text.parse(scenario, "the recording's scenario")
    except InvalidInputError:  # whoever reads the scenario says what is wrong
        return 0
    seed = data.get("seed", 0) if isinstance(data, dict) else 0
    return seed if isinstance(seed, int) and 0 <= seed < 2**63 else 0


_STEPS: dict[int, Callable[[dict[str, Any], dict[str, np.ndarray]], None]] = {
    1: _from_1,
    2: _from_2,
    3: _from_3,
    4: _from_4,
    5: _from_5,
}
