"""What a mission's diagram has in addition where faults are looked for: drives, sensors, doors, monitors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from drake_ltl.diagrams.transport_plant import TransportPlant
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import ConstantVectorSource

from drake_ltl.multibody.measure import MeasuredModels
from drake_ltl.scenario.model import Scenario
from drake_ltl.systems.doors import Doors
from drake_ltl.systems.drives import Drives
from drake_ltl.systems.fault_monitors import (
    ClockMonitor,
    DoorMonitor,
    DriveMonitor,
    FaultMonitor,
    GripMonitor,
    LoadMonitor,
    MotionMonitor,
    ObjectMonitor,
)
from drake_ltl.systems.plan_supervisor import PlanSupervisor
from drake_ltl.systems.sensors import Sensors
from drake_ltl.systems.state_places import StatePlaces


@dataclass(frozen=True)
class FaultParts:
    """That a diagram has them, and where in a run it begins."""

    first_step: int = 0
    """Number of the run's step with which it begins."""
    ignored: frozenset[str] = frozenset()
    """Members of whose faults is known."""
    blocked: frozenset[str] = frozenset()
    """Regions of which it is known that they are blocked."""


def AddSensors(builder: DiagramBuilder, scenario: Scenario, parts: TransportPlant) -> tuple[OutputPort, OutputPort]:
    """Noise and delay as the scenario has them; without any, measurements are exact.

    Returns:
        The state that is seen, and how old it is [s].
    """
    (settings, *_) = [*(fault.values for fault in scenario.faults if fault.kind == "sensors"), None]
    if settings is None:
        age = builder.AddNamedSystem("age", ConstantVectorSource(np.zeros(1)))
        return parts.plant.get_state_output_port(), age.get_output_port()
    plant = parts.plant
    places = StatePlaces.of(plant, parts.agents, parts.objects)
    sensors = builder.AddSystem(
        Sensors(places, plant.num_positions(), plant.time_step(), seed=scenario.seed, **settings)
    )
    builder.Connect(plant.get_state_output_port(), sensors.get_state_input_port())
    return sensors.get_state_output_port(), sensors.get_age_output_port()


def AddDrives(builder: DiagramBuilder, models: MeasuredModels, torque: OutputPort) -> Drives:
    """Motors between controllers and plant."""
    drives = builder.AddSystem(Drives({name: model.effort_limits for name, model in models.agents.items()}))
    builder.Connect(torque, drives.get_torque_input_port())
    return drives


def AddFaultMonitors(
    builder: DiagramBuilder,
    faults: FaultParts,
    scenario: Scenario,
    models: MeasuredModels,
    parts: TransportPlant,
    supervisor: PlanSupervisor,
    state: OutputPort,
    age: OutputPort,
    torque: OutputPort,
    drives: Drives,
    doors: Doors,
) -> tuple[FaultMonitor, ...]:
    """One for each kind of symptom, all of what is measured."""
    places = StatePlaces.of(parts.plant, parts.agents, parts.objects)
    common = {"first_step": faults.first_step, "ignored": faults.ignored}
    drive = DriveMonitor(places, scenario, models, **common)
    motion = MotionMonitor(places, scenario, models, **common)
    door = DoorMonitor(places, scenario, first_step=faults.first_step, ignored=faults.blocked)
    clock = ClockMonitor(places, scenario, models, **common)
    load = LoadMonitor(places, scenario, models, **common)
    monitors = (
        drive,
        motion,
        door,
        clock,
        load,
        GripMonitor(places, scenario, models, parts.welds, **common),
        ObjectMonitor(places, scenario, parts.welds, **common),
    )
    for monitor in monitors:
        builder.AddSystem(monitor)
        builder.Connect(state, monitor.get_state_input_port())
        builder.Connect(supervisor.get_progress_output_port(), monitor.get_progress_input_port())
    for monitor in (drive, motion):
        builder.Connect(torque, monitor.get_torque_input_port())
    for monitor in (drive, load):
        builder.Connect(drives.get_delivered_output_port(), monitor.get_delivered_input_port())
    for monitor in (clock, load, motion):
        builder.Connect(age, monitor.get_age_input_port())
    builder.Connect(doors.get_closed_output_port(), door.get_closed_input_port())
    return monitors
