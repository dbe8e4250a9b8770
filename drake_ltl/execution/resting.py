"""Objects that rest on the floor cost a simulation nothing.

Friction between feet and floor is what a step of the plant spends most of its time on, and for an object that lies
still it works out to nothing: weight and floor balance. So while an object rests and nobody holds it, its weight is
balanced by a constant force in place of the floor. Contact with everything else stays real; whoever runs into a resting
object moves it, and at the next look it is on the floor again. (Drake can lock joints instead, but a locked free body
that touches the floor ends the process in 1.51.)
"""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import Context

from drake_ltl.diagrams.mission_diagram import MissionDiagram

RESTING_SPEED = 1e-3
"""[m/s, rad/s]"""
RESTING_WAY = 1e-5
"""Farthest that what rests may have come [m], and of its quaternion's components, ..."""
RESTING_TIME = 0.5
"""... for this long [s]: what is put down settles first."""


class Resting:
    """Looks, between two advances, which objects rest."""

    def __init__(self, mission: MissionDiagram):
        self._mission = mission
        parts = mission.transport_plant
        self._plant = parts.plant
        numbers = np.arange(self._plant.num_velocities(), dtype=float)
        self._rows = {
            name: self._plant.GetVelocitiesFromArray(instance, numbers).astype(int)
            for name, instance in parts.objects.items()
        }
        self._since: dict[str, tuple[float, np.ndarray]] = {}
        """When each object was seen where it is for the first time."""

    def look(self, root_context: Context) -> None:
        """Takes what has come to rest off the floor, and puts back what is held or moves."""
        mission, plant = self._mission, self._plant
        context = plant.GetMyMutableContextFromRoot(root_context)
        source = mission.support.get_mutable_source_value(mission.support.GetMyMutableContextFromRoot(root_context))
        support, held = source.get_mutable_value(), self._held(context)
        for name, rows in self._rows.items():
            rests = name not in held and self._is_still(name, context)
            if rests:
                plant.SetVelocities(context, mission.transport_plant.objects[name], np.zeros(len(rows)))
            if rests != bool(support[rows].any()):
                support[rows] = -plant.CalcGravityGeneralizedForces(context)[rows] if rests else 0.0
                mission.transport_plant.SetFloorContact(root_context, name, touches=not rests)

    def _held(self, context: Context) -> set[str]:
        parts = self._mission.transport_plant
        is_active = self._plant.GetConstraintActiveStatus
        return {w.object for w, i in zip(parts.welds, parts.weld_ids, strict=True) if is_active(context, i)}

    def _is_still(self, name: str, context: Context) -> bool:
        """At rest now, and where it is for some time."""
        instance, now = self._mission.transport_plant.objects[name], context.get_time()
        q, v = self._plant.GetPositions(context, instance), self._plant.GetVelocities(context, instance)
        since, there = self._since.setdefault(name, (now, q))
        if np.abs(q - there).max() > RESTING_WAY or np.abs(v).max() > RESTING_SPEED:
            self._since[name] = now, q
            return False
        return now - since >= RESTING_TIME
