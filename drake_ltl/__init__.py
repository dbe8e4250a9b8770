"""From linear temporal logic over robots and objects to a proven plan and a verified Drake simulation."""

__version__ = "0.1.0"
