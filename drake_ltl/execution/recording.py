"""What a run leaves behind: everything a verdict needs, as plain arrays in one file.

The file is a NumPy archive (.npz, readable from any language with a zip and a simple header) with one JSON header:
an open format that needs no library beyond numpy, and bytes that depend on the run alone. Its version is 6; files of
older ones are read too (`recording_versions`).
"""

from __future__ import annotations

import dataclasses
import json
import os
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from drake_ltl.errors import InvalidInputError, Mistake
from drake_ltl.execution.damage import array_damage, header_damage
from drake_ltl.execution.recording_versions import VERSION, brought_up
from drake_ltl.monitoring.violation import Violation
from drake_ltl.scenario.table import shown
from drake_ltl.whole_files import written_whole

FORMAT = "drake_ltl recording"
LARGEST_RATIO = 100
"""Of unpacked to packed size; recordings have 2 to 10, and archives that are made to fill the memory have 1000."""
NOTHING = -1
"""In `grasp`: holds no object."""


@dataclass(frozen=True)
class StepRecord:
    """One executed step of the plan."""

    number: int
    """From 0, in order of execution."""
    actions: tuple[dict[str, Any], ...]
    """Each {"kind", "agents", "object", "from", "to"}."""
    start: float
    """[s]"""
    duration: float
    """[s]"""
    finished: bool
    halted: str = ""
    """The fault that ended it before its actions were done; empty if none did. What its movers do then is to brake, to
    let go and to stand wherever they are: a state of the run all the same."""
    faulty: tuple[str, ...] = ()
    """Whom the fault befell."""


@dataclass(frozen=True)
class IntervalRecord:
    """What moved under one navigation function, and where to: with the motion, all that V depends on."""

    step: int
    phase: int
    travels: Mapping[str, tuple[float, ...]]
    """agent z -> q*_z (n_z,)."""
    transports: Mapping[str, tuple[float, ...]]
    """object -> p*_O (3,) [m] in W."""
    waiting: tuple[str, ...]
    """Objects whose teams stand for now, to move later; they count as one sphere already."""
    reaches: Mapping[str, tuple[tuple[float, ...], tuple[float, ...]]]
    """agent that approaches or backs off meanwhile -> q at both ends of its way."""


@dataclass(frozen=True)
class Recording:
    """A run, sampled at every step of the plant. Positions in W [m], quaternions (w, x, y, z)."""

    scenario: str
    """The scenario's text."""
    versions: Mapping[str, str]
    agents: tuple[str, ...]
    objects: tuple[str, ...]
    agent_radius: Mapping[str, float]
    object_radius: Mapping[str, float]
    team_radius: Mapping[str, float]
    prefix_length: int
    suffix_length: int
    """Steps of the plan's prefix (up to and into the suffix's first state) and of one round of its suffix."""
    steps: tuple[StepRecord, ...]
    completed: bool
    reason: str
    """Why the run ended early; empty if it did not."""
    intervals: tuple[IntervalRecord, ...]
    """In order of time."""
    time: np.ndarray
    """(T,) [s], increasing."""
    q: Mapping[str, np.ndarray]
    """agent -> (T, n_i)."""
    qd: Mapping[str, np.ndarray]
    """agent -> (T, n_i)."""
    centre: Mapping[str, np.ndarray]
    """agent -> c_i (T, 3)."""
    pose: Mapping[str, np.ndarray]
    """object -> quaternion and origin (T, 7)."""
    velocity: Mapping[str, np.ndarray]
    """object -> angular and linear velocity (T, 6)."""
    step: np.ndarray
    """(T,) number of the step being carried out; len(steps) once all are done."""
    phase: np.ndarray
    """(T,) counts from 0 within each step: V is one function for each (step, phase)."""
    mode: np.ndarray
    """(T, N) what each agent does: 0 hold, 1 travel, 2 reach, 3 + j carries object j."""
    grasp: np.ndarray
    """(T, N) index of the object each agent is welded to, or NOTHING."""
    lyapunov: np.ndarray
    """(T,) V [J] as the controllers evaluated it; 0 while nothing moves under the navigation function."""
    effort: np.ndarray
    """(T, N) the largest torque that each agent's controllers ask of a joint, relative to its effort limit; the plant
    gives no more than 1."""
    manipulability: np.ndarray
    """(T, N) w = sqrt(det J J^T) of each agent, of fewer than 6 joints sqrt(det J^T J); 0 at singularities."""
    seed: int = 0
    """The scenario's."""
    lacks: tuple[str, ...] = ()
    """What the file's older version did not have: of fields, arrays are 0 here, `intervals` and `monitored` are empty;
    `gathering` and `lift` are today's V (`recording_versions`)."""
    monitored: tuple[Violation, ...] = ()
    """What monitors saw go wrong while the run went on, in order of time."""

    @property
    def object_origin(self) -> dict[str, np.ndarray]:
        """object -> p_WO (T, 3)."""
        return {name: pose[:, 4:] for name, pose in self.pose.items()}

    def save(self, path: Path | str) -> None:
        """Writes the file whole or not at all (OSError if it cannot)."""
        header = {field: getattr(self, field) for field in _HEADER_FIELDS}
        header |= {"format": FORMAT, "version": VERSION}
        header |= {name: [dataclasses.asdict(record) for record in getattr(self, name)] for name in _RECORD_FIELDS}
        arrays = {field: getattr(self, field) for field in _ARRAY_FIELDS}
        for field in _GROUP_FIELDS:
            arrays |= {f"{field}/{name}": array for name, array in getattr(self, field).items()}
        text = json.dumps(header, sort_keys=True, default=dict)
        with written_whole(path) as file:
            np.savez_compressed(file, header=np.frombuffer(text.encode(), dtype=np.uint8), **arrays)

    @staticmethod
    def load(path: Path | str) -> Recording:
        """Reads a file written by `save`.

        Raises:
            InvalidInputError: it is not there, no recording, of a newer version, or has parts of the wrong kinds.
        """
        try:
            with open(path, "rb") as file:
                _check_kind(path, file.read(2))
                file.seek(0)
                header, arrays = _read(path, file)
        except OSError as error:
            raise _mistake(path, error.strerror or "cannot be read", "name a recording") from error
        try:
            header, arrays = brought_up(header, arrays)
            recording = _from_parts(header, arrays)
            damage = [*header_damage(header), *array_damage(arrays)]
        except KeyError as error:
            raise _mistake(path, f"is a damaged recording: it lacks {shown(error.args[0])}", _ANEW) from error
        except Exception as error:  # what does not fit together shows in many ways
            raise _mistake(path, "is a damaged recording: its parts do not fit together", _ANEW) from error
        if damage:
            raise InvalidInputError([Mistake(str(path), f"is damaged: {what}", _ANEW) for what in damage])
        return recording


_CUT_OFF = "is a damaged archive: it is cut off, or was changed"
_ANEW = "make a new one with `simulate`"


def _check_kind(path: Path | str, first: bytes) -> None:
    if not first:
        raise _mistake(path, "is empty", _ANEW)
    if first != b"PK":  # as every zip begins
        raise _mistake(path, "is not a recording but a file of another kind", "name one that `simulate` wrote")


def _read(path: Path | str, file: BinaryIO) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Header and arrays of an archive that is a recording, of this version or an older one."""
    try:
        size = file.seek(0, os.SEEK_END)
        with zipfile.ZipFile(file) as parts:
            unpacked = sum(part.file_size for part in parts.infolist())
        file.seek(0)
    except Exception as error:
        raise _mistake(path, _CUT_OFF, "copy it again") from error
    if unpacked > max(LARGEST_RATIO * size, 10**7):
        raise _mistake(path, f"unpacks to {unpacked // size} times its size", _ANEW)
    try:
        with np.load(file, allow_pickle=False) as archive:
            arrays = dict(archive) if "header" in archive else {}
    except Exception as error:  # damage shows in zipfile, zlib or numpy, in each in many ways
        raise _mistake(path, _CUT_OFF, "copy it again") from error
    try:
        header = json.loads(arrays.pop("header").tobytes())
        is_recording = header["format"] == FORMAT
    except Exception:  # no header, or none of ours
        is_recording = False
    if not is_recording:
        raise _mistake(path, "is not a recording but another archive", "name one that `simulate` wrote")
    version = header.get("version")
    if not isinstance(version, int) or isinstance(version, bool) or version < 1:
        raise _mistake(path, "is a damaged recording: it has no version", _ANEW)
    if version > VERSION:
        what = f"is a recording of the newer version {shown(version)}, and this release reads up to version {VERSION}"
        raise _mistake(path, what, "use the release of drake_ltl that made it")
    return header, arrays


_HEADER_FIELDS = (
    "scenario",
    "versions",
    "agents",
    "objects",
    "agent_radius",
    "object_radius",
    "team_radius",
    "prefix_length",
    "suffix_length",
    "completed",
    "reason",
    "seed",
    "lacks",
)
_ARRAY_FIELDS = ("time", "step", "phase", "mode", "grasp", "lyapunov", "effort", "manipulability")
_RECORD_FIELDS = ("steps", "intervals", "monitored")
_GROUP_FIELDS = ("q", "qd", "centre", "pose", "velocity")


def _from_parts(header: dict[str, Any], arrays: dict[str, np.ndarray]) -> Recording:
    lists = {field: tuple(header[field]) for field in ("agents", "objects", "lacks")}
    steps = tuple(
        StepRecord(**{**step, "actions": tuple(step["actions"]), "faulty": tuple(step.get("faulty", ()))})
        for step in header["steps"]
    )
    intervals = tuple(_interval(interval) for interval in header["intervals"])
    monitored = tuple(Violation(**{**seen, "who": tuple(seen["who"])}) for seen in header["monitored"])
    names = {"q": "agents", "qd": "agents", "centre": "agents", "pose": "objects", "velocity": "objects"}
    groups = {field: {name: arrays[f"{field}/{name}"] for name in header[names[field]]} for field in _GROUP_FIELDS}
    samples = len(arrays["time"])
    if any(len(array) != samples for array in arrays.values()):
        raise ValueError("arrays of different lengths")
    fields = {field: header[field] for field in _HEADER_FIELDS} | {field: arrays[field] for field in _ARRAY_FIELDS}
    return Recording(steps=steps, intervals=intervals, monitored=monitored, **(fields | lists), **groups)


def _interval(data: dict[str, Any]) -> IntervalRecord:
    return IntervalRecord(
        step=data["step"],
        phase=data["phase"],
        travels={name: tuple(q) for name, q in data["travels"].items()},
        transports={name: tuple(p) for name, p in data["transports"].items()},
        waiting=tuple(data["waiting"]),
        reaches={name: (tuple(start), tuple(goal)) for name, (start, goal) in data["reaches"].items()},
    )


def _mistake(path: Path | str, what: str, remedy: str) -> InvalidInputError:
    return InvalidInputError([Mistake(str(path), what, remedy)])
