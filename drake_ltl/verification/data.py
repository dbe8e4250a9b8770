"""The samples themselves: numbers of a sane size, evenly spaced in time, as many as the simulation made."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping

import numpy as np

from drake_ltl.execution.recording import Recording
from drake_ltl.scenario.model import Scenario
from drake_ltl.verification.violations import Violation

SPACING = 1e-6
"""Relative difference of time steps that rounding explains."""
SAME_INSTANT = 1e-9
"""Samples this close [s] are one instant, logged when one advance of the simulator ends and the next begins."""
UNIT_LENGTH = 1e-3
"""A quaternion this far from unit length is none; integration keeps far closer."""

LARGEST_OTHER = 1e6
"""[m], [rad], [m/s], [rad/s]: no run comes near."""
LARGEST = {"time": 1e7, "lyapunov": 1e300}
"""[s]; [J], where spheres that all but touch make V as large as one likes."""


def data_violations(recording: Recording, scenario: Scenario) -> Iterator[Violation]:
    """Numbers that are none, and samples that are missing."""
    if not len(recording.time):
        yield Violation("data", (), "the recording holds no samples")
        return
    for name, array in _named_arrays(recording).items():
        bad = _unusable(name, array)
        if bad.any():
            sample = int(np.argmax(bad))
            finite = np.isfinite(array[sample]).all()
            what = f"{name} is beyond {_bound(name):g}" if finite else f"{name} is not finite"
            yield Violation("data", (name,), what, *_place(recording, sample))
    for obj in recording.objects:
        bad = _not_unit(recording.pose[obj])
        if bad.any():
            sample = int(np.argmax(bad))
            yield Violation("data", (obj,), f"the quaternion of {obj} is not a unit one", *_place(recording, sample))
    yield from _time_violations(recording, scenario.simulation.time_step)


def finite_part(recording: Recording) -> Recording:
    """The samples before the first with what is no number or no rotation: nothing can be said of the rest."""
    unusable = [_unusable(name, array) for name, array in _named_arrays(recording).items()]
    bad = np.any([*unusable, *map(_not_unit, recording.pose.values())], axis=0)
    if not bad.any():
        return recording
    keep = int(np.argmax(bad))
    steps = recording.steps[: int(recording.step[keep - 1]) + 1 if keep else 0]
    arrays = {field: getattr(recording, field)[:keep] for field in _SINGLE}
    groups = {field: {k: array[:keep] for k, array in getattr(recording, field).items()} for field in _GROUPS}
    return dataclasses.replace(recording, steps=steps, **arrays, **groups)


_SINGLE = ("time", "step", "phase", "mode", "grasp", "lyapunov", "effort", "manipulability")
_GROUPS = ("q", "qd", "centre", "pose", "velocity")


def _named_arrays(recording: Recording) -> Mapping[str, np.ndarray]:
    arrays = {field: getattr(recording, field) for field in _SINGLE}
    for field in _GROUPS:
        arrays |= {f"{field} of {name}": array for name, array in getattr(recording, field).items()}
    return arrays


def _unusable(name: str, array: np.ndarray) -> np.ndarray:
    """(T,) where something is not finite, or so large that computing with it overflows."""
    return ~(np.abs(array) <= _bound(name)).all(axis=tuple(range(1, array.ndim)))


def _bound(name: str) -> float:
    return LARGEST.get(name, LARGEST_OTHER)


def _not_unit(pose: np.ndarray) -> np.ndarray:
    """(T,) where the quaternion of poses (T, 7) is none; nan is left to others."""
    with np.errstate(over="ignore"):
        return np.abs(np.linalg.norm(pose[:, :4], axis=1) - 1.0) > UNIT_LENGTH


def _time_violations(recording: Recording, time_step: float) -> Iterator[Violation]:
    spacing = np.diff(recording.time)
    again = (spacing > 0.0) & (spacing <= SAME_INSTANT)
    bad = ~(again | (np.abs(spacing - time_step) <= SPACING * time_step))
    if bad.any():
        sample = int(np.argmax(bad))
        what = f"samples are not {time_step:g} s apart, as the plant's steps are, but {spacing[sample]:g} s"
        yield Violation("data", ("time",), what, *_place(recording, sample))


def _place(recording: Recording, sample: int) -> tuple[float | None, int | None]:
    """Time and step of a sample, as far as they are known."""
    time = float(recording.time[sample])
    return (time if np.isfinite(time) else None), int(recording.step[sample])
