"""Monitors of bodies as they are: welds that gape, true geometry that touches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform

from drake_ltl.monitoring.violation import Finding
from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.multibody.postures import pose_error
from drake_ltl.multibody.scene_distance import SceneDistance
from drake_ltl.scenario.model import Agent, Tolerances
from drake_ltl.systems.monitors.mission_monitor import Look, MissionMonitor
from drake_ltl.systems.monitors.monitor import Memory
from drake_ltl.systems.program import MissionProgram
from drake_ltl.systems.signals import NO_GRASP
from drake_ltl.systems.state_places import StatePlaces
from drake_ltl.verification.grasps import HELD_ANGLE, HELD_GAP


class BodyMonitor(MissionMonitor):
    """Base of monitors of the plant's whole state.

    .. pydrake_system::

        name: BodyMonitor
        input_ports:
        - state
        - progress
    """

    def __init__(self, name: str, period: float, program: MissionProgram, places: StatePlaces):
        """`places` says what is where in the signal `state`."""
        super().__init__(name, period, program, "state", places.size)
        self._places = places
        ends = np.cumsum([0, *places.sizes]).tolist()
        self._rows = {
            name: places.q[start:end] for name, start, end in zip(places.agents, ends, ends[1:], strict=False)
        }

    def _q(self, x: np.ndarray) -> Mapping[str, np.ndarray]:
        return {name: x[rows] for name, rows in self._rows.items()}


class WeldMonitor(BodyMonitor):
    """Grippers keep to what they are welded to."""

    def __init__(
        self,
        name: str,
        period: float,
        program: MissionProgram,
        places: StatePlaces,
        models: MeasuredModels,
        tolerances: Tolerances,
    ):
        super().__init__(name, period, program, places)
        self._models = models
        self._limits = (
            (max(HELD_GAP, tolerances.weld_position), "m"),
            (max(HELD_ANGLE, tolerances.weld_angle), "rad"),
        )

    def _findings(self, look: Look, memory: Memory) -> Iterator[Finding]:
        for signals in look.progress.agents:
            if signals.grasp != NO_GRASP:
                yield from self._of_weld(look.signal, signals.grasp)

    def _of_weld(self, x: np.ndarray, number: int) -> Iterator[Finding]:
        weld = self._program.welds[number]
        pose = x[self._places.pose[weld.object]]
        X_WO = RigidTransform(Quaternion(pose[:4] / np.linalg.norm(pose[:4])), pose[4:])
        X_OE = self._models.grasp(weld.agent, weld.object, weld.option).X_OE
        X_WE = self._models.agents[weld.agent].grasp_pose(x[self._rows[weld.agent]])
        error = pose_error(X_WE, X_WO @ X_OE)
        for part, (limit, unit), how in zip((error[3:], error[:3]), self._limits, ("gapes", "is turned"), strict=True):
            if (off := float(np.linalg.norm(part))) > limit:
                yield Finding(
                    (weld.agent, weld.object), f"the weld of {weld.agent} to {weld.object} {how}", off, limit, unit
                )


class GeometryMonitor(BodyMonitor):
    """No two members touch with their collision geometries, but grippers handles."""

    def __init__(
        self,
        name: str,
        period: float,
        program: MissionProgram,
        places: StatePlaces,
        models: MeasuredModels,
        agents: Sequence[Agent],
    ):
        super().__init__(name, period, program, places)
        self._distance = SceneDistance(agents, list(models.objects.values()))

    def _findings(self, look: Look, memory: Memory) -> Iterator[Finding]:
        x = look.signal
        poses = {name: x[rows] for name, rows in self._places.pose.items()}
        for (a, b), distance in self._distance(self._q(x), poses, within=0.0).items():
            yield Finding((a, b), f"{a} hits {b}", distance, 0.0, "m")
