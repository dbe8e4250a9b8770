"""Systems that watch a mission while it runs, and end the run when something is wrong. They never act."""

from drake_ltl.systems.monitors.monitor import Monitor

__all__ = ["Monitor"]
