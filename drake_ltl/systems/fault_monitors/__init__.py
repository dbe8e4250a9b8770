"""Monitors that notice faults: what is measured is not what should follow from what was commanded.

They see commands, measured joints and poses, and measured torques; none of them knows which faults a scenario has.
"""

from drake_ltl.systems.fault_monitors.clock import ClockMonitor
from drake_ltl.systems.fault_monitors.door import DoorMonitor
from drake_ltl.systems.fault_monitors.drive import DriveMonitor
from drake_ltl.systems.fault_monitors.fault_monitor import FaultMonitor
from drake_ltl.systems.fault_monitors.grip import GripMonitor
from drake_ltl.systems.fault_monitors.load import LoadMonitor
from drake_ltl.systems.fault_monitors.motion import MotionMonitor
from drake_ltl.systems.fault_monitors.objects import ObjectMonitor

__all__ = [
    "ClockMonitor",
    "DoorMonitor",
    "DriveMonitor",
    "FaultMonitor",
    "GripMonitor",
    "LoadMonitor",
    "MotionMonitor",
    "ObjectMonitor",
]
