"""The hand that breaks things as a scenario's `faults:` say. Only between AdvanceTo calls, as welds are switched."""

from __future__ import annotations

import numpy as np
from pydrake.multibody.math import SpatialVelocity
from pydrake.systems.framework import Context

from drake_ltl.diagrams.mission_diagram import MissionDiagram
from drake_ltl.scenario.faults import LIMP, Fault

BRAKE = 1e8
"""Damping of a joint whose brake is on [N s/m, N m s/rad]: under any torque of its drive it creeps by micrometres."""


class Injector:
    """Faults that are still to come, and welds that are broken; one for all diagrams of a run."""

    def __init__(self, faults: tuple[Fault, ...]):
        self._pending = [fault for fault in faults if fault.kind != "sensors"]  # sensors are systems of the diagram
        self.broken: frozenset[int] = frozenset()
        """Indices of welds that do not hold, whatever is commanded."""
        self.happened: list[tuple[float, Fault]] = []
        """With the times at which they did."""

    def next_time(self, now: float, soon: float) -> float:
        """When to look next [s]: at the next fault's time; `soon` from now if one waits for a step or a grasp."""
        times = [fault.time for fault in self._pending if fault.time is not None and fault.time > now]
        waiting = len(times) < len(self._pending)
        return min([*times, *([now + soon] if waiting else [])], default=np.inf)

    def Inject(self, mission: MissionDiagram, context: Context, step: int) -> None:
        """Lets happen what is due; `step` is the number of the run's step, from 0."""
        now = context.get_time()
        for fault in list(self._pending):
            if _is_due(fault, now, step) and self._happens(mission, context, fault):
                self._pending.remove(fault)
                self.happened.append((now, fault))

    def _happens(self, mission: MissionDiagram, context: Context, fault: Fault) -> bool:
        """False if it cannot happen yet: a weld that is not made cannot break."""
        parts = mission.transport_plant
        plant_context = parts.plant.GetMyMutableContextFromRoot(context)
        if fault.kind == "weld_breaks":
            return self._break_weld(mission, plant_context, fault.who)
        if fault.kind == "mass":
            scale_mass(mission, plant_context, fault.who, fault.values["factor"])
        elif fault.kind == "push":
            _push(mission, plant_context, fault.who, fault.values["impulse"])
        elif fault.kind == "blocked_region":
            mission.doors.Close(mission.doors.GetMyMutableContextFromRoot(context), fault.who)
        elif fault.kind == "agent_stops" and fault.values["how"] != LIMP:
            _set_damping(mission, plant_context, fault.who, BRAKE)
        else:
            share = 0.0 if fault.kind == "agent_stops" else fault.values["factor"]
            mission.drives.SetShare(mission.drives.GetMyMutableContextFromRoot(context), fault.who, share)
            if fault.values.get("friction"):
                _set_damping(mission, plant_context, fault.who, fault.values["friction"])
        return True

    def _break_weld(self, mission: MissionDiagram, plant_context: Context, agent: str) -> bool:
        parts = mission.transport_plant
        for index, (weld, weld_id) in enumerate(zip(parts.welds, parts.weld_ids, strict=True)):
            if weld.agent == agent and parts.plant.GetConstraintActiveStatus(plant_context, weld_id):
                parts.plant.SetConstraintActiveStatus(plant_context, weld_id, False)
                self.broken |= {index}
                return True
        return False


def _is_due(fault: Fault, now: float, step: int) -> bool:
    if fault.step is not None:
        return step >= fault.step - 1
    return fault.time is None or now >= fault.time - 1e-9


def _set_damping(mission: MissionDiagram, plant_context: Context, agent: str, damping: float) -> None:
    """Of all joints that have a drive [N s/m, N m s/rad]: of an arm and its base all, of a wheeled base the wheels."""
    parts = mission.transport_plant
    for index in parts.plant.GetJointActuatorIndices(parts.agents[agent]):
        joint = parts.plant.get_joint_actuator(index).joint()
        joint.SetDampingVector(plant_context, [damping])  # Lock, with contact, can end the process (Drake 1.51)


def scale_mass(mission: MissionDiagram, plant_context: Context, obj: str, factor: float) -> None:
    """Multiplies an object's mass and rotational inertia; controllers keep the model's."""
    parts = mission.transport_plant
    for index in parts.plant.GetBodyIndices(parts.objects[obj]):
        body = parts.plant.get_body(index)
        body.SetMass(plant_context, factor * body.get_mass(plant_context))


def _push(mission: MissionDiagram, plant_context: Context, obj: str, impulse: tuple[float, float]) -> None:
    """An impulse [N s] through the object's origin, its centre of mass, changes its velocity at once."""
    parts = mission.transport_plant
    body = parts.plant.GetBodyByName(mission.models.objects[obj].body_name, parts.objects[obj])
    V_WO = body.EvalSpatialVelocityInWorld(plant_context)
    change = np.array([*impulse, 0.0]) / body.get_mass(plant_context)
    parts.plant.SetFreeBodySpatialVelocity(
        plant_context, body, SpatialVelocity(V_WO.rotational(), V_WO.translational() + change)
    )
